// The 2D rigid-body engine, as a Simulation made from a Scene.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/limits.h"
#include "base/parallel/parallel.h"
#include "base/result.h"
#include "base/state/simulation.h"
#include "engine/model/caches.h"
#include "engine/scene/scene.h"
#include "engine/simd/instruction_set.h"

namespace ticktrue::engine {

/// Rises with every change that changes bits on purpose; CHANGELOG says so under *TRACE*.
inline constexpr std::uint32_t physics_version = 12;
inline constexpr std::string_view simulation_name = "ticktrue.engine";

/// Choices that change no bit of what both sides have.
struct EngineOptions {
  bool full_pipeline = false;                          // every stage the solver can use, needed or not
  std::optional<BroadPhaseKind> broad_phase;           // instead of the scene's
  std::optional<InstructionSet> instruction_set = {};  // instead of instruction_set_in_use(); requires can_use
  unsigned thread_count = 1;                           // of a tick
  // For tests: instead of threads of its own, and chunks of this size. The runner must outlive the engine.
  Parallel parallel = {};
  std::optional<std::size_t> pair_count_max = {};  // for tests: fewer than limits::pair_count_max
  // Does each tick a second time without any cached structure, on a copy of the state, and compares every column: where
  // they differ, step() fails (inconsistent) with tick, stage, table, column and row. A tick takes two to
  // five times as long.
  bool check_caches = false;
};

/// A stage that is, or could have been, in the pipeline.
struct StageDescription {
  std::string name;
  bool included;
  std::string why;
};

/// What the engine shows of a body beyond its columns, in f64, for drawing, tables and cross-checks.
struct BodyReport {
  std::uint32_t id = 0;
  std::string name;  // "crate_7"; spawned bodies: "<prototype>#<id>"
  BodyType type = BodyType::dynamic_body;
  Point center;                 // centre of mass, world, m
  Point origin;                 // of the body's frame, world, m
  double angle = 0;             // rad, -pi..pi
  Point velocity;               // m/s
  double angular_velocity = 0;  // rad/s
  double mass = 0;              // kg; 0 for static and kinematic
  double inertia = 0;           // kg m^2 about the centre of mass; 0 for static, kinematic, fixed rotation
  const std::vector<Shape>* shapes = nullptr;  // in the body's frame; lives as long as the engine
};

struct ContactReport {
  std::uint32_t body_a = 0;  // id
  std::uint32_t body_b = 0;  // id
  Point normal;              // from A to B
  int point_count = 0;       // 1 or 2
  Point point[2];            // world, m
  double separation[2]{};    // m, < 0 overlaps; at the end of the tick
  double normal_force[2]{};  // N, mean of the tick
};

/// What the scene's broad phase makes of the present poses.
struct BroadPhaseReport {
  struct Box {
    std::uint32_t body = 0;  // id
    Point lower;             // world, m; with margin and the swept displacement of a tick
    Point upper;
  };
  struct Pair {
    std::uint32_t first = 0;  // index in `boxes`
    std::uint32_t second = 0;
  };
  std::vector<Box> boxes;   // of each shape that can meet another
  std::vector<Pair> pairs;  // that the narrow phase is to test
};

class Engine : public Simulation {
 public:
  /// The pipeline, stage by stage, those left out included, with the reason for each.
  virtual std::vector<StageDescription> describe() const = 0;
  virtual const Scene& scene() const = 0;
  virtual std::vector<BodyReport> bodies() const = 0;
  /// Contacts of the present poses, found anew; forces are those of the last tick. None where more pairs are near each
  /// other than a tick may have: the next step will say so. So too below.
  virtual std::vector<ContactReport> contacts() const = 0;
  virtual BroadPhaseReport broad_phase() const = 0;
  virtual std::uint64_t tick() const = 0;            // ticks done
  virtual double time_s() const = 0;                 // sum of their dt
  virtual std::uint64_t ignored_inputs() const = 0;  // inputs to bodies already removed

  /// Makes the next tick build these structures anew. Changes no bit of any later state.
  virtual void forget_caches(CacheSet caches) = 0;
  virtual CacheReport cache_report() const = 0;
};

/// Errors: what check_scene refuses, incompatible, and what make_workers refuses (base/parallel/workers.h).
Result<std::unique_ptr<Engine>> make_engine(const Scene& scene, const EngineOptions& options = {});

/// The engine as traces know it: its setup is encode_scene of the scene (scene_binary.h).
const SimulationInfo& engine_info();

}  // namespace ticktrue::engine
