// Time of single kernels: a pair in the narrow phase, the broad phases, the hash of the state.
// SPDX-License-Identifier: MIT
#define TICKTRUE_PRECISION f32
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "base/random.h"
#include "base/state/state_view.h"
#include "engine/broad_phase/broad_phase.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue {
namespace {

namespace f32 = engine::f32;
using engine::Scene;
using engine::Shape;
using engine::ShapeKind;

Scene scene_of(const std::string& text) {
  auto scene = engine::make_builtin_scene(text);
  if (!scene) std::abort();
  return *std::move(scene);
}

Shape shape_of(const std::string& kind) {
  Shape shape;
  if (kind == "circle") {
    shape.kind = ShapeKind::circle;
    shape.radius = 0.5;
  } else if (kind == "box") {
    shape.kind = ShapeKind::box;
    shape.half_size = {0.5, 0.5};
  } else if (kind == "capsule") {
    shape.kind = ShapeKind::capsule;
    shape.vertices = {{-0.4, 0}, {0.4, 0}};
    shape.radius = 0.3;
  } else {
    shape.kind = ShapeKind::polygon;
    shape.vertices = {{0.5, 0}, {0.25, 0.4}, {-0.25, 0.4}, {-0.5, 0}, {-0.25, -0.4}, {0.25, -0.4}};
  }
  return shape;
}

/// Pairs of shapes at random angles, their centres 0.8 m to 1.1 m apart: most touch, some almost touch.
void collide_pairs(benchmark::State& bench, const std::string& kind_a, const std::string& kind_b) {
  constexpr int pair_count = 256;
  Random random(7);
  Scene scene;
  for (int i = 0; i < pair_count; ++i)
    for (const std::string& kind : {kind_a, kind_b}) {
      engine::Body body;
      body.name = "body_" + std::to_string(scene.bodies.size());
      body.position = {10.0 * i, scene.bodies.size() % 2 == 0 ? 0 : random.real(0.8, 1.1)};
      body.angle = random.real(-3, 3);
      body.shapes.push_back(shape_of(kind));
      scene.bodies.push_back(body);
    }
  const f32::Model model = f32::make_model(scene);
  const f32::State state = f32::initial_state(model);
  std::size_t i = 0;
  for (auto _ : bench) {
    const f32::BodyRow& a = state.bodies[2 * i];
    const f32::BodyRow& b = state.bodies[2 * i + 1];
    benchmark::DoNotOptimize(
        f32::collide(model, model.shape(model.bodies[a.source], 0), model.shape(model.bodies[b.source], 0), a, b, 0));
    i = (i + 1) % pair_count;
  }
}

/// `moved`: the share of the bodies that has moved by a hundredth of a metre since the last call.
void find_pairs(benchmark::State& bench, engine::BroadPhaseKind kind, float moved) {
  const Scene scene = scene_of("mixed_pile?substeps=4&bodies=" + std::to_string(bench.range(0)));
  const f32::Model model = f32::make_model(scene);
  f32::State state = f32::initial_state(model);
  f32::TickLists found;
  const std::unique_ptr<f32::Stage> stage = f32::make_broad_phase(kind);
  const auto stride = moved > 0 ? static_cast<std::size_t>(1 / moved) : state.bodies.size();
  float step = 0.01F;
  for (auto _ : bench) {
    for (std::size_t row = 3; row < state.bodies.size(); row += stride) state.bodies[row].position.x += step;
    step = -step;
    stage->run(model, state, found, 1.0F / 60);
    benchmark::DoNotOptimize(found.pairs.data());
  }
  bench.SetItemsProcessed(bench.iterations() * bench.range(0));
}

void hash_state(benchmark::State& bench) {
  const Scene scene = scene_of("mixed_pile?substeps=4&bodies=" + std::to_string(bench.range(0)));
  const auto engine = engine::make_engine(scene);
  if (!engine) std::abort();
  for (int tick = 0; tick < 60; ++tick)
    if (!(*engine)->step({scene.settings.dt, {}}, nullptr)) std::abort();
  for (auto _ : bench) benchmark::DoNotOptimize(root_hash((*engine)->state()));
  bench.SetItemsProcessed(bench.iterations() * bench.range(0));
}

void add_all() {
  const std::vector<std::pair<std::string, std::string>> kinds{{"circle", "circle"},   {"box", "circle"},
                                                               {"box", "box"},         {"polygon", "polygon"},
                                                               {"capsule", "capsule"}, {"box", "capsule"}};
  for (const auto& [a, b] : kinds)
    benchmark::RegisterBenchmark(("collide/" + a + "_" + b).c_str(), collide_pairs, a, b);
  for (const auto& info : engine::broad_phases) {
    const std::string name = "pairs/" + std::string(info.name);
    const bool is_quadratic =
        info.kind == engine::BroadPhaseKind::brute_force || info.kind == engine::BroadPhaseKind::bounding_circle;
    benchmark::RegisterBenchmark((name + "/all_moved").c_str(), find_pairs, info.kind, 1.0F)
        ->Arg(100)
        ->Arg(is_quadratic ? 1000 : 10'000);
    if (is_quadratic) continue;
    benchmark::RegisterBenchmark((name + "/a_hundredth_moved").c_str(), find_pairs, info.kind, 0.01F)->Arg(10'000);
  }
  benchmark::RegisterBenchmark("root_hash", hash_state)->Arg(1000)->Arg(10'000);
}

}  // namespace
}  // namespace ticktrue

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  ticktrue::add_all();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
