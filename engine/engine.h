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

/// Rises with every intended change of bits; CHANGELOG marks it with *TRACE*.
inline constexpr std::uint32_t physics_version = 30;
inline constexpr std::string_view simulation_name = "ticktrue.engine";

/// Options that change no bit of the state columns that two engines share.
struct EngineOptions {
  bool full_pipeline = false;                          // every stage that the solver can use, needed or not
  std::optional<BroadPhaseKind> broad_phase;           // instead of the scene's
  std::optional<InstructionSet> instruction_set = {};  // instead of instruction_set_in_use(); requires can_use
  unsigned thread_count = 1;                           // of a tick
  // For tests: a runner instead of the engine's own threads, and a size of chunks. The runner must outlive the engine.
  Parallel parallel = {};
  std::optional<std::size_t> pair_count_max = {};  // for tests: fewer than limits::pair_count_max
  // Does each tick a second time on a copy of the state without any cached structure, and compares every column. If
  // they differ, step() fails (inconsistent) with tick, stage, table, column and row. A tick takes two to five times as
  // long.
  bool check_caches = false;
};

/// A stage of the pipeline, or one that was left out.
struct StageDescription {
  std::string name;
  bool included;
  std::string why;
};

/// A body in f64 for drawing, tables and cross-checks, with more than its columns.
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

/// Boxes and pairs of the scene's broad phase at the present poses.
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
  std::vector<Box> boxes;   // of each shape that can touch another
  std::vector<Pair> pairs;  // that the narrow phase will test
};

/// The number of ticks so far that a substep budget has changed.
struct BudgetReport {
  std::uint64_t cut_ticks = 0;      // in which a shock was left before it had settled
  std::uint64_t limited_ticks = 0;  // in which an island had fewer substeps than its loads need
};

class Engine : public Simulation {
 public:
  /// The stages of the pipeline and the stages left out, with the reason for each.
  virtual std::vector<StageDescription> describe() const = 0;
  virtual const Scene& scene() const = 0;
  virtual std::vector<BodyReport> bodies() const = 0;
  /// Contacts of the present poses, computed for this call; forces are those of the last tick. Empty if the shapes have
  /// more pairs than a tick may have: broad_phase() then has no pairs, and the next step fails.
  virtual std::vector<ContactReport> contacts() const = 0;
  virtual BroadPhaseReport broad_phase() const = 0;
  virtual std::uint64_t tick() const = 0;                         // ticks done
  virtual double time_s() const = 0;                              // sum of their dt
  virtual std::uint64_t ignored_inputs() const = 0;               // inputs to bodies already removed
  virtual std::optional<BudgetReport> budget_report() const = 0;  // with settings.substep_budget

  /// Makes the next tick rebuild these structures. Changes no bit of any later state.
  virtual void forget_caches(CacheSet caches) = 0;
  virtual CacheReport cache_report() const = 0;
};

/// Errors: what check_scene refuses, incompatible, and what make_workers refuses (base/parallel/workers.h).
Result<std::unique_ptr<Engine>> make_engine(const Scene& scene, const EngineOptions& options = {});

/// The engine's name in traces: its setup is encode_scene of the scene (scene_binary.h).
const SimulationInfo& engine_info();

}  // namespace ticktrue::engine
