// Verifies traces with a minimal loop, independently of the verifier: reader, engine, root hash.
// SPDX-License-Identifier: MIT
//
// The program does not include the command line, so it builds quickly for every compiler and optimisation level to
// compare (./dev test). The program is also a second opinion, because it shares no code with verifier/.
// Verified: the root hash of every tick and checkpoint; stored stage hashes and state images.
// Not verified: damaged or truncated traces, and traces of other simulations, which are refused.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/build_info.h"
#include "base/hash.h"
#include "base/state/stage_hashes.h"
#include "base/state/state_view.h"
#include "engine/engine.h"
#include "replay/trace_reader.h"

namespace ticktrue {
namespace {

bool complain(const std::string& file, const std::string& what) {
  std::fprintf(stderr, "trace_check: error: %s: %s\n", file.c_str(), what.c_str());
  return false;
}

std::string differ(std::uint64_t found, std::uint64_t expected) {
  return "found " + hex64(found) + ", expected " + hex64(expected);
}

/// The first lane that differs from the recorded state: "table bodies, column velocity, row 3, lane 0".
std::string place_of(const Simulation& simulation, ByteView expected) {
  const StateSchema& schema = *simulation.state().schema;
  Bytes got;
  encode_image(simulation.state(), got);
  const auto expected_tables = split_image(schema, expected);
  const auto got_tables = split_image(schema, got);
  if (!expected_tables || !got_tables) return "the image is of another shape";
  const std::vector<LaneDifference> differences = diff_images(schema, *expected_tables, *got_tables, 1);
  if (differences.empty()) return "no lane differs";
  const LaneDifference& first = differences.front();
  const TableSchema& table = schema.tables[first.place.table];
  const Column& column = table.columns[first.place.column];
  const auto text = [&](const std::optional<std::uint64_t>& bits) {
    return bits ? lane_text(column.type, *bits) + " (" + lane_hex(column.type, *bits) + ")"
                : std::string("no such row");
  };
  return "table " + table.name + ", column " + column.name + ", row " + std::to_string(first.place.row) + ", lane " +
         std::to_string(first.place.lane) + ": found " + text(first.got) + ", expected " + text(first.expected);
}

bool check_tick(const std::string& file, Simulation& simulation, const replay::TraceSetup& setup,
                const replay::TickRecord& tick) {
  const std::string place = "tick " + std::to_string(tick.tick);
  const TickInput input{tick.dt, tick.inputs};
  if (const Status status = simulation.accept(input); !status)
    return complain(file, place + ": inputs: " + status.error().message);
  StageHashes observer;
  if (const Status did = simulation.step(input, tick.stage_hashes.empty() ? nullptr : &observer); !did)
    return complain(file, did.error().message);
  for (std::size_t i = 0; i < tick.stage_hashes.size(); ++i)
    if (i >= observer.hashes().size() || observer.hashes()[i] != tick.stage_hashes[i])
      return complain(file,
                      place + ": stage " + setup.stages[i] + ": hash differs" +
                          (tick.image ? "; at the end of the tick " + place_of(simulation, tick.image->joined()) : ""));
  const std::uint64_t found = root_hash(simulation.state());
  if (found != tick.root_hash)
    return complain(file, place + (tick.image ? ": " + place_of(simulation, tick.image->joined())
                                              : ": root hash: " + differ(found, tick.root_hash)));
  if (!tick.image) return true;
  Bytes image;
  encode_image(simulation.state(), image);
  if (image == tick.image->joined()) return true;
  return complain(file, place + ": state image differs");
}

bool check_trace(const std::string& file, std::uint64_t& ticks) {
  auto reader = replay::TraceReader::open(file);
  if (!reader) return complain(file, reader.error().message);
  const replay::TraceSetup& setup = reader->setup();
  const SimulationInfo& info = engine::engine_info();
  if (setup.simulation != info.name || setup.physics_version != info.physics_version)
    return complain(file, "recorded with " + setup.simulation + " " + std::to_string(setup.physics_version));
  auto simulation = info.make(setup.setup);
  if (!simulation) return complain(file, simulation.error().message);
  const std::uint64_t ticks_before = ticks;
  for (;;) {
    const replay::TraceReader::Item& item = reader->next();
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) {
      if (!check_tick(file, **simulation, setup, *tick)) return false;
      ++ticks;
    } else if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
      const std::uint64_t found = root_hash((*simulation)->state());
      if (found != checkpoint->root_hash)
        return complain(file, "checkpoint at tick " + std::to_string(checkpoint->tick) + ": " +
                                  differ(found, checkpoint->root_hash));
    } else {
      break;
    }
  }
  const replay::TraceTail& tail = reader->tail();
  if (tail.condition != replay::TraceCondition::complete) return complain(file, tail.message);
  if (ticks == ticks_before) return complain(file, "found no tick, expected at least one");
  return true;
}

}  // namespace
}  // namespace ticktrue

int main(int argc, char* argv[]) {
  if (const char* name = std::getenv(ticktrue::engine::instruction_set_variable); name != nullptr)
    if (const ticktrue::Status status = ticktrue::engine::use_instruction_set(name); !status) {
      std::fprintf(stderr, "trace_check: error: %s\n", status.error().message.c_str());
      return 2;
    }
  int failed = 0;
  std::uint64_t ticks = 0;
  for (int i = 1; i < argc; ++i)
    if (!ticktrue::check_trace(argv[i], ticks)) ++failed;
  std::printf("%s: %d traces, %llu ticks, %d differ\n", ticktrue::build_line().c_str(), argc - 1,
              static_cast<unsigned long long>(ticks), failed);
  return failed == 0 && argc > 1 ? 0 : 1;
}
