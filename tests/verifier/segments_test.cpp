// One trace on several threads gives the report of one thread.
// SPDX-License-Identifier: MIT
#include "verifier/verify/segments.h"

#include <atomic>
#include <set>

#include "base/state/stage_hashes.h"
#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"
#include "verifier/compare/diff.h"
#include "verifier/corpus/trace_list.h"
#include "verifier/report/report.h"
#include "verifier/verify/rerun.h"
#include "verifier/verify/single_change.h"

namespace ticktrue::test {
namespace {

using verifier::Report;
using verifier::Verdict;
using verifier::VerifyMode;
using verifier::VerifyOptions;

/// The same trace, opened again for every thread.
Report verify_on(ByteView trace, VerifyOptions options, unsigned thread_count) {
  options.thread_count = thread_count;
  options.reopen = [trace]() -> std::unique_ptr<verifier::TraceSource> {
    return std::make_unique<verifier::OwnedReaderSource>(open_trace(trace));
  };
  return verify_bytes(trace, options);
}

std::string json_of(Report report) {
  report.segments = 1;
  return verifier::report_json({&report, 1}, false);
}

void inject_nudge(std::uint64_t tick) {
  injected = {tick, ToySimulation::move_stage,
              [](ToySimulation& toy) { toy.bodies[1].velocity[1] = std::nextafter(toy.bodies[1].velocity[1], 1e9F); }};
}

TEST_CASE("segments: a matching trace gives the same report on one thread and on several",
          "[verifier][segments][equivalence]") {
  for (const bool full : {false, true}) {
    const Bytes trace = toy_trace_with(full ? full_toy_setup(6, 5, 20) : toy_setup(6), 100, 8);
    for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore}) {
      const VerifyOptions options = verify_options(toy_info, mode);
      const Report one = verify_on(trace, options, 1);
      const Report four = verify_on(trace, options, 4);
      CHECK(one.verdict == Verdict::match);
      CHECK(json_of(one) == json_of(four));
      if (mode == VerifyMode::replay) CHECK(four.segments == 13);
    }
  }
}

TEST_CASE("segments: wherever a trace diverges, the report is that of the walk in order",
          "[verifier][segments][equivalence]") {
  for (const bool full : {false, true}) {
    const Bytes trace = toy_trace_with(full ? full_toy_setup(6, 0, 100) : toy_setup(6), 60, 8);
    for (std::uint64_t tick = 0; tick < 60; ++tick) {
      CAPTURE(full, tick);
      inject_nudge(tick);
      for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore}) {
        const VerifyOptions options = verify_options(faulty_info, mode);
        const Report one = verify_on(trace, options, 1);
        const Report three = verify_on(trace, options, 3);
        REQUIRE(three.divergence);
        CHECK(three.divergence->tick == tick);
        CHECK(json_of(one) == json_of(three));
      }
    }
  }
}

TEST_CASE("segments: a part of a trace is the same part", "[verifier][segments][equivalence]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 8);
  inject_nudge(41);
  for (std::uint64_t from = 0; from < 60; from += 7)
    for (std::uint64_t to = from; to < 60; to += 5) {
      CAPTURE(from, to);
      VerifyOptions options = verify_options(faulty_info);
      options.from = from;
      options.to = to;
      CHECK(json_of(verify_on(trace, options, 1)) == json_of(verify_on(trace, options, 3)));
    }
}

TEST_CASE("segments: a cut or damaged trace gives the report of the walk in order",
          "[verifier][segments][corruption]") {
  const Bytes trace = toy_trace_with(toy_setup(4), 80, 8);
  for (std::size_t size = 0; size < trace.size(); size += 23) {
    CAPTURE(size);
    const ByteView cut = ByteView(trace).first(size);
    if (!replay::TraceReader::open_bytes(cut, "toy.ttr")) continue;
    const VerifyOptions options = verify_options(toy_info);
    CHECK(json_of(verify_on(cut, options, 1)) == json_of(verify_on(cut, options, 3)));
  }
  Bytes changed = trace;
  for (std::size_t at = 0; at < trace.size(); at += 17) {
    CAPTURE(at);
    changed[at] ^= 0x20;
    if (replay::TraceReader::open_bytes(changed, "toy.ttr")) {
      const VerifyOptions options = verify_options(toy_info);
      const Report three = verify_on(changed, options, 3);
      CHECK(three.verdict != Verdict::match);
      CHECK(json_of(verify_on(changed, options, 1)) == json_of(three));
    }
    changed[at] ^= 0x20;
  }
}

TEST_CASE("segments: a recording that ended in a value that is not finite", "[verifier][segments][equivalence]") {
  const TemporaryFolder folder;
  ToySimulation simulation(4);
  ScriptedInputs source([](std::uint64_t tick) -> Result<std::optional<std::pair<double, Bytes>>> {
    ToyInputs inputs;
    if (tick == 30) inputs.poison(2);
    return std::optional(std::pair(0.015625, inputs.take()));
  });
  replay::RecordOptions record_options;
  record_options.writer = plain_writer();
  replay::TraceSetup setup = toy_setup(4);
  setup.checkpoint_interval = 8;
  REQUIRE(replay::record(simulation, source, folder.file("toy.ttr"), setup, toy_facts, record_options));
  const Bytes trace = read_file(folder.file("toy.ttr"));
  const Report one = verify_on(trace, verify_options(toy_info), 1);
  CHECK(one.verdict == Verdict::match);
  REQUIRE(one.non_finite);
  CHECK(one.non_finite->tick == 30);
  CHECK(one.non_finite->table == "bodies");
  CHECK(json_of(one) == json_of(verify_on(trace, verify_options(toy_info), 2)));
}

TEST_CASE("segments: two runs that differ are not reproducible on several threads too",
          "[verifier][segments][determinism]") {
  static std::atomic<std::uint32_t> made{0};
  class Garbage : public ToySimulation {
   public:
    explicit Garbage(std::uint32_t body_count) : ToySimulation(body_count) {
      const std::uint32_t garbage = ++made;
      disturb = [garbage](ToySimulation& self, std::size_t stage) {
        if (stage == move_stage && self.world.tick_count == 21)
          self.bodies[0].hits = static_cast<std::uint16_t>(1000 + garbage);
      };
    }
  };
  const SimulationInfo info{"ticktrue.toy", 1, &make_toy<Garbage>};
  const Bytes trace = toy_trace_with(toy_setup(6), 50, 8);
  const Report report = verify_on(trace, verify_options(info), 3);
  CHECK(report.verdict == Verdict::not_reproducible);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 20);
}

TEST_CASE("segments: a single bit that differs is found from the root hash alone, whichever it is",
          "[verifier][single_bit][analytic]") {
  // The recorder's memory loses one bit at the end of tick 27 and records on from there.
  std::size_t named = 0;
  const std::size_t body_count = 6;
  for (std::size_t bit = 0; bit < 8 * body_count * sizeof(ToyBody); bit += 41) {
    CAPTURE(bit);
    if (bit / 8 % sizeof(ToyBody) < 8) continue;  // an id or partner that refers to nothing ends the toy
    const TemporaryFolder folder;
    ToySimulation simulation(body_count);
    simulation.disturb = [&](ToySimulation& self, std::size_t stage) {
      if (stage != ToySimulation::move_stage || self.world.tick_count != 28) return;
      auto* bytes = reinterpret_cast<std::uint8_t*>(self.bodies.data());
      bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1u << bit % 8));
    };
    ScriptedInputs source([](std::uint64_t) -> Result<std::optional<std::pair<double, Bytes>>> {
      return std::optional(std::pair(0.015625, Bytes()));
    });
    replay::RecordOptions record_options;
    record_options.tick_count = 40;
    record_options.writer = plain_writer();
    replay::TraceSetup setup = toy_setup(body_count);
    setup.checkpoint_interval = 10;
    const auto recorded = replay::record(simulation, source, folder.file("toy.ttr"), setup, toy_facts, record_options);
    REQUIRE(recorded);
    if (recorded->tick_count < 40) continue;  // it made a value that is not finite
    const Bytes trace = read_file(folder.file("toy.ttr"));
    VerifyOptions options = verify_options(toy_info);
    const Report plain = verify_on(trace, options, 2);
    REQUIRE(plain.divergence);
    CHECK(plain.divergence->tick == 27);
    CHECK(plain.divergence->tables.empty());
    options.search_single_bit = true;
    const Report report = verify_on(trace, options, 2);
    CHECK(report.verdict == Verdict::diverged);
    REQUIRE(report.divergence);
    REQUIRE(report.divergence->rows.size() == 1);
    const verifier::LaneReport& lane = report.divergence->rows[0];
    CHECK(lane.table == "bodies");
    CHECK(lane.row == bit / 8 / sizeof(ToyBody));
    CHECK(lane.name == "toy_" + std::to_string(*lane.id));
    REQUIRE(lane.expected);
    REQUIRE(lane.got);
    const std::uint64_t difference = *lane.expected ^ *lane.got;
    CHECK(difference != 0);
    CHECK((difference & (difference - 1)) == 0);
    ++named;
  }
  CHECK(named > 20);
}

TEST_CASE("segments: a single bit is found in any block of a table, and in any table",
          "[verifier][single_bit][analytic]") {
  // Three blocks of bodies and one of links.
  ToySimulation toy(1'000);
  Bytes here;
  encode_image(toy.state(), here);
  const auto found_bit = [&] {
    const auto found = verifier::find_single_bit(ToySimulation::schema(), here, root_hash(toy.state()), 1);
    REQUIRE(found);
    Bytes recorded;
    encode_image(toy.state(), recorded);
    return *found == recorded;
  };
  toy.bodies[0].charge ^= 8;
  CHECK(found_bit());
  toy.bodies[0].charge ^= 8;
  toy.links[499].stiffness = 1;  // before: 0.5, one bit less
  CHECK(found_bit());
  toy.links[499].stiffness = 0.5F;
  toy.bodies[999].hits ^= 0x8000;
  CHECK(found_bit());
  toy.bodies[999].charge ^= 1;
  CHECK_FALSE(found_bit());
}

TEST_CASE("segments: two bits that differ are not taken for one", "[verifier][single_bit][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 50, 0);
  injected = {37, ToySimulation::move_stage, [](ToySimulation& toy) {
                toy.bodies[1].charge ^= 1;
                toy.bodies[2].charge ^= 1;
              }};
  VerifyOptions options = verify_options(faulty_info);
  options.search_single_bit = true;
  const Report report = verify_on(trace, options, 1);
  CHECK(report.verdict == Verdict::diverged);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tables.empty());
}

/// The ticks of the checkpoints at which segments can begin.
std::vector<std::uint64_t> segment_starts(ByteView trace, std::optional<std::uint64_t> to = std::nullopt) {
  replay::TraceReader reader = open_trace(trace);
  verifier::ReaderSource source(reader);
  VerifyOptions options = verify_options(toy_info);
  options.to = to;
  std::vector<std::uint64_t> ticks;
  for (const verifier::Start& start : verifier::plan_segments({source.setup(), options}, source, {}, 100).starts)
    ticks.push_back(start.tick);
  return ticks;
}

TEST_CASE("segments: one begins at each checkpoint with a tick behind it, up to the last tick wanted",
          "[verifier][segments][analytic]") {
  using Ticks = std::vector<std::uint64_t>;
  const Bytes trace = toy_trace_with(toy_setup(6), 24, 8);
  CHECK(segment_starts(trace) == Ticks{0, 8, 16});
  CHECK(segment_starts(trace, 7) == Ticks{0});
  CHECK(segment_starts(trace, 8) == Ticks{0, 8});
  CHECK(segment_starts(trace, 15) == Ticks{0, 8});
  CHECK(segment_starts(trace, 16) == Ticks{0, 8, 16});
  std::size_t ends_with_checkpoint = 0;
  for (const ChunkPlace& place : chunk_places(trace)) {
    const ByteView cut = ByteView(trace).first(place.offset + place.size);
    if (!replay::TraceReader::open_bytes(cut, "toy.ttr")) continue;
    const ReadTrace read = read_all(cut);
    Ticks expected{0};
    for (const ReadCheckpoint& checkpoint : read.checkpoints)
      if (checkpoint.tick > 0 && checkpoint.tick < read.ticks.size()) expected.push_back(checkpoint.tick);
    CAPTURE(place.offset);
    CHECK(segment_starts(cut) == expected);
    if (!read.ticks.empty() && read.checkpoints.back().tick == read.ticks.size()) ++ends_with_checkpoint;
  }
  CHECK(ends_with_checkpoint > 0);
}

TEST_CASE("segments: a run begins at a checkpoint that the trace has, or nowhere", "[verifier][segments][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 24, 8);
  replay::TraceReader reader = open_trace(trace);
  verifier::ReaderSource source(reader);
  for (std::uint64_t tick = 0; tick < 30; ++tick) {
    CAPTURE(tick);
    verifier::Start start;
    start.tick = tick;
    start.loaded = true;
    const bool has_checkpoint = tick % 8 == 0 && tick <= 24;  // one is behind the last tick
    CHECK(verifier::go_to_start(source, start) == has_checkpoint);
    CHECK(start.image.empty() == !has_checkpoint);
    CHECK(start.tick == tick);
  }
}

TEST_CASE("segments: the parts of a list have no file in common and are the list", "[verifier][shard][analytic]") {
  std::vector<std::string> files;
  for (int i = 0; i < 23; ++i) files.push_back("t" + std::to_string(i * 7 % 23) + ".ttr");
  std::vector<std::string> sorted = files;
  std::sort(sorted.begin(), sorted.end());
  for (const std::uint64_t count : {1u, 2u, 5u, 23u, 40u}) {
    std::multiset<std::string> together;
    for (std::uint64_t index = 1; index <= count; ++index) {
      const auto part = verifier::take_shard(files, {index, count});
      CHECK(part.size() <= (files.size() + count - 1) / count);
      together.insert(part.begin(), part.end());
    }
    CHECK(std::vector<std::string>(together.begin(), together.end()) == sorted);
  }
  CHECK(verifier::take_shard({"c", "a", "b"}, {1, 2}) == std::vector<std::string>{"a", "c"});
  for (const char* wrong : {"", "1", "0/2", "3/2", "1/0", "a/2", "1/2x", "-1/2", "1//2"}) {
    CAPTURE(wrong);
    CHECK(!verifier::parse_shard(wrong));
  }
  const auto shard = verifier::parse_shard("3/8");
  REQUIRE(shard);
  CHECK(shard->index == 3);
  CHECK(shard->count == 8);
}

/// The ticks of a toy session from `first_tick` on, as a trace that begins late.
Bytes late_trace(replay::Detail detail, std::uint64_t first_tick, std::uint64_t end_tick, bool has_tail = true) {
  replay::TraceSetup setup = detail == replay::Detail::full ? full_toy_setup(6, 0, 1'000) : toy_setup(6);
  setup.detail = detail;
  setup.checkpoint_interval = 8;
  if (has_tail) setup.features = static_cast<std::uint32_t>(replay::Feature::tail);
  setup.stage_interval = 3;
  const TemporaryFolder folder;
  replay::WriterOptions options = plain_writer();
  options.allow_third = true;
  auto writer = replay::TraceWriter::create(folder.file("late.ttr"), setup, toy_facts, options);
  REQUIRE(writer);
  ToySimulation toy(6);
  double time_s = 0;
  for (std::uint64_t tick = 0; tick < end_tick; ++tick) {
    const auto [dt, inputs] = **lively_script(tick);
    const TickInput input{dt, inputs};
    StageHashes stages;
    if (tick == first_tick && tick > 0) writer->begin_at(tick, time_s);
    const bool is_written = tick >= first_tick;
    if (is_written && writer->wants_checkpoint()) REQUIRE(writer->checkpoint(toy.state(), root_hash(toy.state())));
    if (is_written) REQUIRE(writer->begin_tick(input));
    REQUIRE(toy.step(input, &stages));
    if (is_written) REQUIRE(writer->end_tick(root_hash(toy.state()), stages.hashes(), &toy.state()));
    time_s += dt;
  }
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  return read_file(folder.file("late.ttr"));
}

TEST_CASE("a trace that begins late is verified from its first checkpoint", "[verifier][late][equivalence]") {
  using replay::Detail;
  for (const Detail detail : {Detail::root, Detail::cells, Detail::full}) {
    const Bytes trace = late_trace(detail, 13, 60);
    for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore, VerifyMode::twice}) {
      CAPTURE(static_cast<int>(detail), static_cast<int>(mode));
      const Report report = verify_bytes(trace, toy_info, mode);
      CHECK(report.verdict == Verdict::match);
      CHECK(report.first_tick == 13);
      CHECK(report.ticks_compared == 47);
      CHECK(report.ticks_recorded == 47U);
      if (mode != VerifyMode::replay) continue;
      CHECK(report.compared.stage_hashes == (detail == Detail::full ? 47 : 15));
      CHECK(report.compared.images == (detail == Detail::full ? 47 : 0));
      CHECK(report.compared.cells == (detail == Detail::cells ? 47 : 0));
      CHECK(json_of(verify_on(trace, verify_options(toy_info), 3)) ==
            json_of(verify_on(trace, verify_options(toy_info), 1)));
    }
    VerifyOptions part = verify_options(toy_info);
    part.from = 30;
    part.to = 40;
    CHECK(verify_bytes(trace, part).ticks_compared == 11);
    inject_nudge(35);
    const Report report = verify_bytes(trace, faulty_info);
    CHECK(report.verdict == Verdict::diverged);
    REQUIRE(report.divergence);
    CHECK(report.divergence->tick == 35);
    const Report threads = verify_on(trace, verify_options(faulty_info), 3);
    CHECK(threads.verdict == Verdict::diverged);
    CHECK(threads.divergence->tick == 35);
  }
}

TEST_CASE("a trace that begins late and is cut counts the ticks it holds", "[verifier][late][corruption]") {
  const Bytes trace = late_trace(replay::Detail::root, 13, 60);
  for (std::size_t size = trace.size() / 2; size < trace.size(); size += 97) {
    CAPTURE(size);
    const ByteView cut = ByteView(trace).first(size);
    const std::size_t tick_count = read_all(cut).ticks.size();
    REQUIRE(tick_count > 0);
    const Report report = verify_bytes(cut, toy_info);
    CHECK(report.verdict == Verdict::incomplete);
    CHECK(report.ticks_compared == tick_count);
    CHECK(report.ticks_recorded == tick_count);
  }
}

/// Shows its state and cannot load one.
class Observed : public ToySimulation {
 public:
  using ToySimulation::ToySimulation;
  Status load(ByteView) override { return Error{ErrorCode::unsupported, "the state can only be observed", ""}; }
};

TEST_CASE("a trace that begins late is not comparable where no state can be loaded", "[verifier][late]") {
  static const SimulationInfo observed{"ticktrue.toy", 1, &make_toy<Observed>};
  const Report report = verify_bytes(late_trace(replay::Detail::root, 13, 30), observed);
  CHECK(report.verdict == Verdict::not_comparable);
  CHECK(report.reason == "begins at tick 13 and holds no state that this program can load");
  // From tick 0 on, version 3 asks for nothing more than version 1.
  CHECK(verify_bytes(late_trace(replay::Detail::root, 0, 30, false), observed).verdict == Verdict::match);
}

TEST_CASE("a bundle is told as one, and not by each of its parts", "[verifier][parts][analytic]") {
  replay::TraceSetup setup = toy_setup(6);
  setup.features = static_cast<std::uint32_t>(replay::Feature::peers);
  setup.checkpoint_interval = 8;
  replay::WriterOptions writer = plain_writer();
  writer.allow_third = true;
  const Bytes trace = toy_trace(setup, 20, writer);
  const std::vector<std::string> note{"a bundle of several players: `ticktrue show toy.ttr` says who differs"};
  VerifyOptions options = verify_options(toy_info);
  CHECK(verify_bytes(trace, options).notes == note);
  options.in_segments = true;
  CHECK(verify_bytes(trace, options).notes == note);
  options.part = verifier::TracePart{0, 2};
  CHECK(verify_bytes(trace, options).notes.empty());
}

TEST_CASE("diff aligns traces that begin at other ticks", "[verifier][late][diff]") {
  for (const replay::Detail detail : {replay::Detail::root, replay::Detail::cells, replay::Detail::full}) {
    const Bytes whole = late_trace(detail, 0, 40), late = late_trace(detail, 16, 40);
    for (const bool is_swapped : {false, true}) {
      replay::TraceReader a = open_trace(is_swapped ? late : whole), b = open_trace(is_swapped ? whole : late);
      const verifier::DiffReport report = verifier::diff(a, b, {});
      CHECK(report.verdict == verifier::DiffVerdict::equal);
      CHECK(report.ticks_compared == 24);
      REQUIRE(report.notes.size() == 1);
      CHECK(contains(report.notes[0], ": compared from tick 16 on"));
    }
  }
}

}  // namespace
}  // namespace ticktrue::test
