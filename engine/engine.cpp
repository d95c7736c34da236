// The face of the engine: it is made from a scene, or from the setup of a trace.
// SPDX-License-Identifier: MIT
#include "engine/engine.h"

#include "base/parallel/workers.h"
#include "engine/scene/scene_binary.h"

namespace ticktrue::engine {

// Each precision is a namespace of its own, compiled from the same sources (math/real.h).
namespace f32 {
std::unique_ptr<Engine> make_world(const Scene& scene, const EngineOptions& options,
                                   std::unique_ptr<ChunkRunner> workers);
}
namespace f64 {
std::unique_ptr<Engine> make_world(const Scene& scene, const EngineOptions& options,
                                   std::unique_ptr<ChunkRunner> workers);
}

namespace {

struct PrecisionEntry {
  Precision kind;
  std::unique_ptr<Engine> (*make)(const Scene& scene, const EngineOptions& options,
                                  std::unique_ptr<ChunkRunner> workers);
};
constexpr std::array<PrecisionEntry, precisions.size()> makers{{
    {Precision::f32, f32::make_world},
    {Precision::f64, f64::make_world},
}};

Result<std::unique_ptr<Simulation>> make_on_threads(ByteView setup, unsigned thread_count) {
  const Result<Scene> scene = decode_scene(setup);
  if (!scene) return scene.error();
  EngineOptions options;
  options.thread_count = thread_count;
  Result<std::unique_ptr<Engine>> engine = make_engine(*scene, options);
  if (!engine) return engine.error();
  return std::unique_ptr<Simulation>(*std::move(engine));
}

Result<std::unique_ptr<Simulation>> make_from_setup(ByteView setup) {
  return make_on_threads(setup, 1);
}

}  // namespace

Result<std::unique_ptr<Engine>> make_engine(const Scene& scene, const EngineOptions& options) {
  if (const Status status = check_scene(scene, scene.name); !status) return status.error();
  Result<std::unique_ptr<ChunkRunner>> workers = make_workers(options.thread_count);
  if (!workers) return workers.error();
  return info_of(makers, scene.settings.precision).make(scene, options, *std::move(workers));
}

const SimulationInfo& engine_info() {
  static const SimulationInfo info{simulation_name, physics_version, make_from_setup, make_on_threads};
  return info;
}

}  // namespace ticktrue::engine
