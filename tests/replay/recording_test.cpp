// What a recorder leaves behind: when all goes well, when it dies, when the disk is full, when inputs are refused.
// SPDX-License-Identifier: MIT
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

#include "replay/format/chunk.h"
#include "tests/replay/toy_traces.h"

using namespace ticktrue;
using namespace ticktrue::test;
using replay::EndReason;
using replay::TraceCondition;
using replay::TraceReader;
using replay::TraceWriter;

namespace {

bool exists(const std::string& path) {
  return std::filesystem::exists(path);
}

ScriptedInputs::Script steady(double dt = 0.015625) {
  return [dt](std::uint64_t) -> Result<std::optional<std::pair<double, Bytes>>> {
    return std::optional(std::pair(dt, Bytes()));
  };
}

}  // namespace

TEST_CASE("inputs are in the file before their tick runs, hashes right after it", "[replay][recorder][analytic]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("live.ttr");
  ToySimulation simulation(3);
  std::uint64_t tick = 0;
  simulation.disturb = [&](ToySimulation&, std::size_t stage) {
    if (stage != ToySimulation::input_stage) return;
    // The file as another process sees it at this moment, or after a kill.
    const ReadTrace seen = read_all(read_file(path));
    const auto script = lively_script(tick);
    REQUIRE(seen.tail.condition == TraceCondition::truncated);
    REQUIRE(seen.ticks.size() == tick);
    if (!(**script).second.empty()) {
      REQUIRE(seen.tail.has_pending_inputs);
      REQUIRE(seen.tail.pending_inputs == (**script).second);
      REQUIRE(seen.tail.pending_dt == (**script).first);
    }
    ++tick;
  };
  ScriptedInputs source(lively_script);
  replay::RecordOptions options;
  options.tick_count = 40;
  options.writer = plain_writer();
  replay::TraceSetup setup = full_toy_setup(3, 10, 12);
  setup.checkpoint_interval = 8;
  const auto result = replay::record(simulation, source, path, setup, toy_facts, options);
  REQUIRE(result);
  CHECK(tick == 40);
  CHECK(result->tick_count == 40);
  CHECK(result->reason == EndReason::complete);
  CHECK(result->root_hash == root_hash(simulation.state()));
  CHECK(result->size == read_file(path).size());
  CHECK(read_all(read_file(path)).tail.condition == TraceCondition::complete);
}

TEST_CASE("a writer that stops anywhere leaves every tick so far", "[replay][writer][corruption]") {
  const TemporaryFolder folder;
  for (std::uint64_t tick_count = 0; tick_count < 6; ++tick_count) {
    for (const bool in_flight : {false, true}) {
      CAPTURE(tick_count, in_flight);
      const std::string path = folder.file("dead_" + std::to_string(tick_count) + (in_flight ? "b" : "a") + ".ttr");
      const ToySimulation simulation(2);
      {
        auto writer = TraceWriter::create(path, toy_setup(2), toy_facts, plain_writer());
        REQUIRE(writer);
        REQUIRE(writer->checkpoint(simulation.state(), 9));
        for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
          REQUIRE(writer->begin_tick({0.5, Bytes{static_cast<std::uint8_t>(tick)}}));
          REQUIRE(writer->end_tick(tick, {}, nullptr));
        }
        if (in_flight) REQUIRE(writer->begin_tick({0.25, Bytes{77}}));
      }
      const ReadTrace all = read_all(read_file(path));
      REQUIRE(all.tail.condition == TraceCondition::truncated);
      REQUIRE(all.ticks.size() == tick_count);
      REQUIRE(all.tail.has_pending_inputs == in_flight);
      if (in_flight) {
        REQUIRE(all.tail.pending_dt == 0.25);
        REQUIRE(all.tail.pending_inputs == Bytes{77});
      }
    }
  }
}

TEST_CASE("an existing file is kept unless overwriting is asked for", "[replay][writer][analytic]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.ttr");
  const Bytes before{1, 2, 3};
  write_file(path, before);
  const auto refused = TraceWriter::create(path, toy_setup(1), toy_facts, plain_writer());
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::io);
  CHECK(refused.error().message == path + ": exists: it is not overwritten");
  CHECK(refused.error().hint.find("--force") != std::string::npos);
  CHECK(read_file(path) == before);

  replay::WriterOptions options = plain_writer();
  options.overwrite = true;
  const ToySimulation simulation(1);
  {
    auto writer = TraceWriter::create(path, toy_setup(1), toy_facts, options);
    REQUIRE(writer);
    CHECK(read_file(path + ".old") == before);
    writer->discard();
    CHECK(read_file(path) == before);
    CHECK_FALSE(exists(path + ".old"));
  }
  CHECK(read_file(path) == before);
  {
    auto writer = TraceWriter::create(path, toy_setup(1), toy_facts, options);
    REQUIRE(writer);
    REQUIRE(writer->checkpoint(simulation.state(), 1));
  }
  CHECK(read_file(path + ".old") == before);  // died before its end: both are there
  CHECK(read_all(read_file(path)).tail.condition == TraceCondition::truncated);
  // The file that was set aside is the only good recording now. Another recording over it is refused.
  const Bytes dead = read_file(path);
  const auto again = TraceWriter::create(path, toy_setup(1), toy_facts, options);
  REQUIRE_FALSE(again);
  CHECK(again.error().message == path + ".old: exists: it is not overwritten");
  CHECK(read_file(path + ".old") == before);
  CHECK(read_file(path) == dead);
  std::filesystem::remove(path + ".old");
  auto writer = TraceWriter::create(path, toy_setup(1), toy_facts, options);
  REQUIRE(writer);
  REQUIRE(writer->checkpoint(simulation.state(), 1));
  REQUIRE(writer->finish(EndReason::complete, ""));
  CHECK_FALSE(exists(path + ".old"));
  CHECK(read_all(read_file(path)).tail.condition == TraceCondition::complete);
}

TEST_CASE("places that cannot be written to are told", "[replay][writer][analytic]") {
  const TemporaryFolder folder;
  const auto error_of = [](const std::string& path, bool overwrite) {
    replay::WriterOptions options = plain_writer();
    options.overwrite = overwrite;
    const auto writer = TraceWriter::create(path, toy_setup(1), toy_facts, options);
    REQUIRE_FALSE(writer);
    CHECK(writer.error().code == ErrorCode::io);
    CHECK_FALSE(writer.error().hint.empty());
    return writer.error().message;
  };
  CHECK(error_of(folder.file(""), true).find("found a directory") != std::string::npos);
  CHECK(error_of(folder.file("missing/x.ttr"), false).find("No such file or directory") != std::string::npos);
  for (const bool overwrite : {false, true}) {
    CHECK(error_of("", overwrite) == "output: found an empty name, expected a file name");
    CHECK(error_of("/dev/null", overwrite) == "/dev/null: cannot write: found a device, expected a file name");
    CHECK(exists("/dev/null"));
  }
  std::filesystem::create_symlink("/dev/null", folder.file("link.ttr"));
  CHECK(error_of(folder.file("link.ttr"), true).find("found a device") != std::string::npos);
  std::filesystem::create_symlink("nowhere", folder.file("dangling.ttr"));
  CHECK(error_of(folder.file("dangling.ttr"), true).find("found a link to nowhere") != std::string::npos);
  CHECK_FALSE(exists(folder.file("nowhere")));
}

TEST_CASE("a write that fails is an error, and the last one", "[replay][writer][analytic]") {
  const TemporaryFolder folder;
  auto writer = TraceWriter::create(folder.file("x.ttr"), toy_setup(1), toy_facts, plain_writer());
  REQUIRE(writer);
  const ToySimulation simulation(1);
  REQUIRE(writer->checkpoint(simulation.state(), 1));
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &limit) == 0);
  const rlimit small{writer->size(), limit.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  const Status failed = writer->begin_tick({0.5, Bytes{1}});
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &limit) == 0);
  std::signal(SIGXFSZ, before);
  REQUIRE_FALSE(failed);
  CHECK(failed.error().code == ErrorCode::io);
  CHECK(failed.error().message.find("cannot write: File too large") != std::string::npos);
  // An error is final.
  CHECK_FALSE(writer->end_tick(1, {}, nullptr));
  CHECK_FALSE(writer->finish(EndReason::complete, ""));
}

TEST_CASE("two writers of one file: the second is refused, and the first goes on", "[replay][writer][analytic]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.ttr");
  auto writer = TraceWriter::create(path, toy_setup(1), toy_facts, plain_writer());
  REQUIRE(writer);
  for (const bool overwrite : {false, true}) {
    replay::WriterOptions options = plain_writer();
    options.overwrite = overwrite;
    const auto second = TraceWriter::create(path, toy_setup(1), toy_facts, options);
    REQUIRE_FALSE(second);
    CHECK(second.error().message.find(" is recording to it") != std::string::npos);
  }
  const ToySimulation simulation(1);
  REQUIRE(writer->checkpoint(simulation.state(), 1));
  REQUIRE(writer->finish(EndReason::complete, ""));
  CHECK(read_all(read_file(path)).tail.condition == TraceCondition::complete);
}

TEST_CASE("a file that changes while it is read is told", "[replay][open][corruption]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.ttr");
  const Bytes trace = toy_trace(toy_setup(2), 20);
  const auto opened = [&] {
    write_file(path, trace);
    auto reader = TraceReader::open(path);
    REQUIRE(reader);
    CHECK(reader->check_unchanged());
    return reader;
  };
  const auto longer = opened();
  std::ofstream(path, std::ios::app) << "more";
  const Status refused = longer->check_unchanged();
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::io);
  CHECK(refused.error().message == path + ": changed while it was read: size: found " +
                                       std::to_string(trace.size() + 4) + ", expected " + std::to_string(trace.size()));
  const auto touched = opened();
  std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) + std::chrono::seconds(1));
  CHECK_FALSE(touched->check_unchanged());
}

TEST_CASE("places that cannot be read are told", "[replay][open][analytic]") {
  const TemporaryFolder folder;
  const auto error_of = [](const std::string& path) {
    const auto reader = TraceReader::open(path);
    REQUIRE_FALSE(reader);
    CHECK(reader.error().code == ErrorCode::io);
    return reader.error().message;
  };
  CHECK(error_of(folder.file("none.ttr")).find("cannot open: No such file") != std::string::npos);
  CHECK(error_of(folder.file("")).find("found a directory") != std::string::npos);
  CHECK(error_of("/dev/zero").find("found a device") != std::string::npos);
}

TEST_CASE("a tick that is not finite is not recorded, and its place is named", "[replay][recorder][analytic]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.ttr");
  ToySimulation simulation(4);
  ScriptedInputs source([](std::uint64_t tick) -> Result<std::optional<std::pair<double, Bytes>>> {
    ToyInputs inputs;
    if (tick == 6) inputs.poison(2);
    return std::optional(std::pair(0.015625, inputs.take()));
  });
  replay::RecordOptions options;
  options.tick_count = 100;
  options.writer = plain_writer();
  const auto result = replay::record(simulation, source, path, toy_setup(4), toy_facts, options);
  REQUIRE(result);
  CHECK(result->reason == EndReason::non_finite);
  CHECK(result->tick_count == 6);
  CHECK(result->note.find("tick 6: bodies row 2 (toy_2), column position, lane 1") == 0);
  const ReadTrace all = read_all(read_file(path));
  CHECK(all.tail.condition == TraceCondition::complete);
  CHECK(all.ticks.size() == 6);
  REQUIRE(all.tail.end);
  CHECK(all.tail.end->reason == EndReason::non_finite);
  CHECK(all.tail.end->note == result->note);
  CHECK(all.tail.has_pending_inputs);
  CHECK(all.tail.pending_inputs == ToyInputs().poison(2).take());
  CHECK(result->root_hash == all.ticks.back().root_hash);
}

TEST_CASE("a refused input removes a repeatable recording and closes a live one", "[replay][recorder][analytic]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.ttr");
  const auto script = [](std::uint64_t tick) -> Result<std::optional<std::pair<double, Bytes>>> {
    ToyInputs inputs;
    if (tick == 3) inputs.push(99, 1);  // no such id
    return std::optional(std::pair(0.015625, inputs.take()));
  };
  const auto failing_script = [](std::uint64_t tick) -> Result<std::optional<std::pair<double, Bytes>>> {
    if (tick == 3) return Error{ErrorCode::invalid_input, "inputs.jsonl: line 4: broken", ""};
    return std::optional(std::pair(0.015625, Bytes()));
  };
  const bool fails_in_source = GENERATE(false, true);
  const bool repeatable = GENERATE(false, true);
  CAPTURE(fails_in_source, repeatable);
  ToySimulation simulation(2);
  ScriptedInputs source(fails_in_source ? ScriptedInputs::Script(failing_script) : ScriptedInputs::Script(script),
                        repeatable);
  replay::RecordOptions options;
  options.writer = plain_writer();
  const auto result = replay::record(simulation, source, path, toy_setup(2), toy_facts, options);
  REQUIRE_FALSE(result);
  CHECK(result.error().code == ErrorCode::invalid_input);
  CHECK(exists(path) != repeatable);
  if (repeatable) return;
  CHECK(result.error().hint.find("holds the 3 ticks before") != std::string::npos);
  const ReadTrace all = read_all(read_file(path));
  CHECK(all.tail.condition == TraceCondition::complete);
  CHECK(all.ticks.size() == 3);
  CHECK_FALSE(all.tail.has_pending_inputs);
  REQUIRE(all.tail.end);
  CHECK(all.tail.end->reason == EndReason::interrupted);
  CHECK(all.tail.end->note == result.error().message);
}

TEST_CASE("a recording ends with its source, at its tick count, or on request", "[replay][recorder][analytic]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.ttr");
  ToySimulation simulation(2);
  replay::RecordOptions options;
  options.writer = plain_writer();
  options.writer.overwrite = true;
  ScriptedInputs ending([](std::uint64_t tick) -> Result<std::optional<std::pair<double, Bytes>>> {
    if (tick == 4) return std::optional<std::pair<double, Bytes>>();
    return std::optional(std::pair(0.015625, Bytes()));
  });
  auto result = replay::record(simulation, ending, path, toy_setup(2), toy_facts, options);
  REQUIRE(result);
  CHECK(result->tick_count == 4);
  CHECK(result->reason == EndReason::complete);

  options.tick_count = 5;
  replay::NoInputs none(0.015625);
  result = replay::record(simulation, none, path, toy_setup(2), toy_facts, options);
  REQUIRE(result);
  CHECK(result->tick_count == 5);
  CHECK(result->reason == EndReason::complete);

  options.progress = [](std::uint64_t ticks_done) { return ticks_done < 3; };
  ScriptedInputs endless(steady());
  result = replay::record(simulation, endless, path, toy_setup(2), toy_facts, options);
  REQUIRE(result);
  CHECK(result->tick_count == 3);
  CHECK(result->reason == EndReason::interrupted);
  CHECK(read_all(read_file(path)).tail.end->reason == EndReason::interrupted);

  options.tick_count = 0;
  options.progress = nullptr;
  result = replay::record(simulation, endless, path, toy_setup(2), toy_facts, options);
  REQUIRE(result);
  CHECK(result->tick_count == 0);
  CHECK(read_all(read_file(path)).tail.condition == TraceCondition::complete);
}

TEST_CASE("an initial state that is not finite is refused, and nothing is written", "[replay][recorder][analytic]") {
  const TemporaryFolder folder;
  ToySimulation simulation(2);
  simulation.bodies[1].position[0] = std::nan("");
  replay::NoInputs none(0.015625);
  const auto result = replay::record(simulation, none, folder.file("x.ttr"), toy_setup(2), toy_facts, {});
  REQUIRE_FALSE(result);
  CHECK(result.error().code == ErrorCode::invalid_scene);
  CHECK(result.error().message.find("bodies row 1 (toy_1), column position, lane 0") != std::string::npos);
  CHECK_FALSE(exists(folder.file("x.ttr")));
}

TEST_CASE("setups beyond the limits are refused, and nothing is written", "[replay][writer][analytic]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.ttr");
  const auto code_of = [&](const replay::TraceSetup& setup, const replay::BuildFacts& facts) {
    const auto writer = TraceWriter::create(path, setup, facts, plain_writer());
    REQUIRE_FALSE(writer);
    CHECK_FALSE(exists(path));
    return writer.error().code;
  };
  replay::TraceSetup setup = toy_setup(1);
  setup.title = std::string(1000, 'x');
  CHECK(code_of(setup, {}) == ErrorCode::limit);
  setup = toy_setup(1);
  setup.simulation.clear();
  CHECK(code_of(setup, {}) == ErrorCode::limit);
  setup = toy_setup(1);
  setup.stages.assign(1000, "stage");
  CHECK(code_of(setup, {}) == ErrorCode::limit);
  setup = toy_setup(1);
  setup.dt = -1;
  CHECK(code_of(setup, {}) == ErrorCode::invalid_scene);
  setup = toy_setup(1);
  setup.full_last = 3;
  CHECK(code_of(setup, {}) == ErrorCode::usage);
  setup = full_toy_setup(1, 4, 3);
  CHECK(code_of(setup, {}) == ErrorCode::usage);
  setup = toy_setup(1);
  setup.schema.tables[0].columns[0].offset = 3;
  CHECK(code_of(setup, {}) == ErrorCode::corrupt);
  CHECK(code_of(toy_setup(1), replay::BuildFacts(1000)) == ErrorCode::limit);
  CHECK(code_of(toy_setup(1), {{"name", std::string(10'000, 'x')}}) == ErrorCode::limit);
}

TEST_CASE("every prefix of a trace that holds a tick is recovered to a complete one", "[replay][recover][corruption]") {
  replay::TraceSetup setup = full_toy_setup(2, 3, 4);
  setup.checkpoint_interval = 5;
  const bool compress = GENERATE(false, true);
  replay::WriterOptions writer = plain_writer();
  writer.compress = compress;
  const Bytes whole = toy_trace(setup, 8, writer);
  const std::size_t setup_end = chunk_places(whole)[1].offset;
  const TemporaryFolder folder;
  const std::string input = folder.file("in.ttr");
  const std::string output = folder.file("out.ttr");
  for (std::size_t size = 0; size <= whole.size(); size += size < setup_end ? 97 : 7) {
    CAPTURE(size);
    write_file(input, ByteView(whole).first(size));
    const auto result = replay::recover_trace(input, output, true);
    REQUIRE(result.has_value() == (size >= setup_end));
    if (!result) {
      REQUIRE(result.error().code == ErrorCode::truncated);
      continue;
    }
    const ReadTrace expected = read_all(ByteView(whole).first(size));
    if (expected.ticks.empty()) {
      // No empty file is left.
      REQUIRE(result->ticks_written == 0);
      REQUIRE(!std::filesystem::exists(output));
      continue;
    }
    const ReadTrace got = read_all(read_file(output));
    REQUIRE(got.tail.condition == TraceCondition::complete);
    REQUIRE(got.ticks == expected.ticks);
    REQUIRE(got.checkpoints == expected.checkpoints);
    REQUIRE(got.tail.has_pending_inputs == expected.tail.has_pending_inputs);
    REQUIRE(got.tail.pending_inputs == expected.tail.pending_inputs);
    REQUIRE(got.tail.end->reason == (expected.tail.end ? EndReason::complete : EndReason::recovered));
    REQUIRE(result->ticks_written == expected.ticks.size());
    REQUIRE(result->tail.message == expected.tail.message);
  }
  write_file(input, whole);
  REQUIRE(replay::recover_trace(input, output, true));
  CHECK(read_file(output) == whole);
}

TEST_CASE("recovery keeps what stands before damage and never touches its input", "[replay][recover][corruption]") {
  replay::TraceSetup setup = toy_setup(2);
  setup.checkpoint_interval = 4;
  Bytes bytes = toy_trace(setup, 16);
  bytes[chunk_places(bytes)[7].offset + 50] ^= 1;  // ticks 8..11
  const TemporaryFolder folder;
  const std::string input = folder.file("in.ttr");
  write_file(input, bytes);
  const auto itself = replay::recover_trace(input, input, true);
  REQUIRE_FALSE(itself);
  CHECK(itself.error().code == ErrorCode::usage);
  const auto result = replay::recover_trace(input, folder.file("out.ttr"), false);
  REQUIRE(result);
  CHECK(result->ticks_written == 8);
  CHECK(result->tail.condition == TraceCondition::damaged);
  REQUIRE(result->tail.intact_after.size() == 1);
  CHECK(result->tail.intact_after[0].first_tick == 12);
  const auto again = replay::recover_trace(input, folder.file("out.ttr"), false);
  REQUIRE_FALSE(again);
  CHECK(again.error().message.find("exists") != std::string::npos);
  CHECK(read_file(input) == bytes);
  const ReadTrace got = read_all(read_file(folder.file("out.ttr")));
  CHECK(got.tail.condition == TraceCondition::complete);
  CHECK(got.tail.end->note == result->tail.message);
}
