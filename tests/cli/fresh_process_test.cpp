// A process loads states that another process saved, and continues with equal bits: for every golden scene.
// SPDX-License-Identifier: MIT
//
// This process runs the session of a golden trace, and records a trace with checkpoints at random ticks. `verify --mode
// restore --to-end` runs in another process. It loads each checkpoint into a new simulation, runs to the end of the
// session, and compares every tick with the recording.
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "base/random.h"
#include "engine/scene/scene_binary.h"
#include "replay/trace_reader.h"
#include "replay/trace_writer.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tool/session/session.h"

namespace fs = std::filesystem;

namespace ticktrue::test {
namespace {

/// Some of the ticks 0 .. end - 1. Always includes 0, because a trace begins with a checkpoint.
std::set<std::uint64_t> random_ticks(std::uint64_t end, std::size_t count, Random& random) {
  std::set<std::uint64_t> ticks{0};
  while (ticks.size() < count && ticks.size() < end) ticks.insert(random.below(end));
  return ticks;
}

/// Runs the session of the golden trace at `from` again, with checkpoints at these ticks.
void record_with_checkpoints(const std::string& from, const std::string& to, std::size_t checkpoint_count,
                             Random& random) {
  auto reader = replay::TraceReader::open(from);
  REQUIRE(reader.has_value());
  const auto scene = engine::decode_scene(reader->setup().setup);
  REQUIRE(scene.has_value());
  const auto engine = make_engine_or_fail(*scene);
  tool::TraceChoices choices;
  choices.checkpoint_interval = 0;
  replay::WriterOptions options;
  options.overwrite = true;
  options.sync = false;
  auto writer =
      replay::TraceWriter::create(to, tool::make_trace_setup(*engine, choices), tool::make_build_facts(), options);
  REQUIRE(writer.has_value());
  const std::uint64_t end = reader->tick_count_hint().value_or(0);
  const std::set<std::uint64_t> saved = random_ticks(end, checkpoint_count, random);
  REQUIRE(saved.size() == checkpoint_count);
  while (true) {
    const replay::TraceReader::Item& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr) continue;
    if (saved.count(record->tick) != 0)
      REQUIRE(writer->checkpoint(engine->state(), root_hash(engine->state())).has_value());
    const TickInput input{record->dt, record->inputs};
    REQUIRE(writer->begin_tick(input).has_value());
    REQUIRE(engine->step(input, nullptr));
    REQUIRE(writer->end_tick(root_hash(engine->state()), {}, nullptr).has_value());
  }
  REQUIRE(writer->tick_count() == end);
  REQUIRE(writer->finish(replay::EndReason::complete, "").has_value());
}

/// Whether the tool exits with 0.
bool runs(const std::string& arguments) {
  return std::system((std::string("'") + TICKTRUE_TOOL + "' " + arguments + " > /dev/null 2>&1").c_str()) == 0;
}

/// Checks every `stride`-th golden trace, with this many checkpoints.
void check_goldens(std::size_t stride, std::size_t checkpoint_count) {
  const fs::path place = fs::temp_directory_path() / ("ticktrue_fresh_process_" + std::to_string(stride));
  fs::create_directories(place);
  std::set<fs::path> goldens;  // by name
  for (const auto& entry : fs::directory_iterator(std::string(TICKTRUE_SOURCE_DIR) + "/traces"))
    if (entry.path().extension() == ".ttr") goldens.insert(entry.path());
  REQUIRE(goldens.size() >= 49);
  Random random(stride);
  std::size_t index = 0;
  for (const fs::path& golden : goldens) {
    if (index++ % stride != 0) continue;
    CAPTURE(golden);
    const std::string trace = (place / golden.filename()).string();
    record_with_checkpoints(golden.string(), trace, checkpoint_count, random);
    CHECK(runs("verify '" + trace + "' --mode restore --to-end"));
    fs::remove(trace);
  }
  fs::remove_all(place);
}

}  // namespace

TEST_CASE("states that one process saves at 50 random ticks run on with the same bits in another",
          "[cli][restore][determinism]") {
  check_goldens(5, 50);
}

TEST_CASE("states of every golden scene, at 50 random ticks, run on with the same bits in another process",
          "[cli][restore][determinism][.slow]") {
  check_goldens(1, 50);
}

}  // namespace ticktrue::test
