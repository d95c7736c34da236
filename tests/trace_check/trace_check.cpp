// Verifies traces by the shortest possible loop, beside the verifier and without it: reader, engine, root hash.
// SPDX-License-Identifier: MIT
//
// Needs none of the command line's headers, so it is built quickly for every compiler and optimisation level whose bits
// are to be compared (./dev test). A second opinion, too: it shares no code with verifier/.
// Verified: root hash of every tick and checkpoint, hashes after each stage and state images where they are stored.
// Not verified: anything of traces that are damaged, cut or of other simulations: those are refused.
#include <algorithm>
#include <cstdio>
#include <string>
#include <variant>
#include <vector>

#include "base/build_info.h"
#include "base/hash.h"
#include "base/state_view.h"
#include "engine/engine.h"
#include "replay/trace_reader.h"

namespace ticktrue {
namespace {

class StageHashes : public StageObserver {
 public:
  void after_stage(std::size_t, const StateView& state) override { hashes.push_back(root_hash(state)); }
  std::vector<std::uint64_t> hashes;
};

bool complain(const std::string& file, const std::string& what) {
  std::fprintf(stderr, "trace_check: error: %s: %s\n", file.c_str(), what.c_str());
  return false;
}

std::string differ(std::uint64_t found, std::uint64_t expected) {
  return "found " + hex64(found) + ", expected " + hex64(expected);
}

bool check_tick(const std::string& file, Simulation& simulation, const replay::TraceSetup& setup,
                const replay::TickRecord& tick) {
  const std::string place = "tick " + std::to_string(tick.tick);
  const TickInput input{tick.dt, tick.inputs};
  if (const Status status = simulation.accept(input); !status)
    return complain(file, place + ": inputs: " + status.error().message);
  StageHashes observer;
  simulation.step(input, tick.stage_hashes.empty() ? nullptr : &observer);
  for (std::size_t i = 0; i < tick.stage_hashes.size(); ++i)
    if (i >= observer.hashes.size() || observer.hashes[i] != tick.stage_hashes[i])
      return complain(file, place + ": stage " + setup.stages[i] + ": hash differs");
  const std::uint64_t found = root_hash(simulation.state());
  if (found != tick.root_hash) return complain(file, place + ": root hash: " + differ(found, tick.root_hash));
  if (!tick.image) return true;
  Bytes image;
  encode_image(simulation.state(), image);
  if (std::equal(image.begin(), image.end(), tick.image->begin(), tick.image->end())) return true;
  return complain(file, place + ": state image differs");
}

bool check_trace(const std::string& file) {
  auto reader = replay::TraceReader::open(file);
  if (!reader) return complain(file, reader.error().message);
  const replay::TraceSetup& setup = reader->setup();
  const SimulationInfo& info = engine::engine_info();
  if (setup.simulation != info.name || setup.physics_version != info.physics_version)
    return complain(file, "recorded with " + setup.simulation + " " + std::to_string(setup.physics_version));
  auto simulation = info.make(setup.setup);
  if (!simulation) return complain(file, simulation.error().message);
  std::uint64_t ticks = 0;
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
  if (ticks == 0) return complain(file, "found no tick, expected at least one");
  return true;
}

}  // namespace
}  // namespace ticktrue

int main(int argc, char* argv[]) {
  int failed = 0;
  for (int i = 1; i < argc; ++i)
    if (!ticktrue::check_trace(argv[i])) ++failed;
  std::printf("%s: %d traces, %d differ\n", ticktrue::build_line().c_str(), argc - 1, failed);
  return failed == 0 && argc > 1 ? 0 : 1;
}
