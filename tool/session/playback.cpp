// Plays a trace from its start or from a checkpoint.
// SPDX-License-Identifier: MIT
#include "tool/session/playback.h"

#include <memory>
#include <variant>

#include "base/state/state_view.h"
#include "engine/scene/scene_binary.h"
#include "tool/session/simulations.h"
#include "verifier/locate/schema_difference.h"
#include "verifier/verify/trace_source.h"

namespace ticktrue::tool {
namespace {

/// Sets the engine to the last checkpoint at or before the tick. If no checkpoint fits, the engine stays at the start.
void go_to(verifier::TraceSource& reader, engine::Engine& engine, std::uint64_t tick) {
  const bool same_columns =
      !first_schema_difference(reader.setup().schema, *engine.state().schema, verifier::Ranges::inside);
  if (tick > 0 && same_columns && reader.seek(tick)) {
    const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&reader.next());
    if (checkpoint != nullptr && engine.load(checkpoint->image)) return;
  }
  reader.rewind();
}

}  // namespace

Result<engine::Scene> scene_of(const replay::TraceSetup& setup) {
  if (setup.simulation != engine::simulation_name)
    return Error{ErrorCode::unsupported,
                 "simulation: found " + setup.simulation + ", expected " + std::string(engine::simulation_name), ""};
  return engine::decode_scene(setup.setup);
}

Result<PlaybackResult> play_trace(replay::TraceReader& trace, std::uint64_t first, std::uint64_t last,
                                  const std::function<bool(const engine::Engine& engine, std::uint64_t tick)>& show) {
  verifier::ReaderSource reader(trace);
  const Result<engine::Scene> scene = scene_of(reader.setup());
  if (!scene) return scene.error();
  auto made = engine::make_engine(*scene, engine_options_of_environment());
  if (!made) return made.error();
  engine::Engine& engine = **made;

  PlaybackResult result;
  go_to(reader, engine, first);
  while (true) {
    const replay::TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr) continue;
    if (record->tick > last) return result;
    const TickInput input{record->dt, record->inputs};
    if (const Status accepted = engine.accept(input); !accepted) {
      result.refused = "tick " + std::to_string(record->tick) + ": " + accepted.error().message;
      return result;
    }
    if (const Status did = engine.step(input, nullptr); !did) {
      result.refused = did.error().message;
      return result;
    }
    ++result.tick_count;
    if (!result.first_difference && root_hash(engine.state()) != record->root_hash)
      result.first_difference = record->tick;
    if (record->tick >= first && !show(engine, record->tick)) return result;
    if (record->tick == last) return result;
  }
  result.tail = reader.tail();
  return result;
}

}  // namespace ticktrue::tool
