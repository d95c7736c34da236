// Automatic substeps against 64 fixed substeps: piles, presses, thin shapes and joints.
// SPDX-License-Identifier: MIT
#include "tool/study/stress/stress_run_time.h"

#include <algorithm>
#include <cmath>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "tool/study/measures.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::Body;
using engine::BodyType;
using engine::Precision;
using engine::Scene;

// A floor and two walls `width` m apart.
Scene tub(const char* name, double width) {
  Scene scene = worlds::empty(Precision::f32);
  scene.name = name;
  scene.bodies = {worlds::ground(), worlds::body(worlds::box(0.5, 20), {-0.5 - width / 2, 20}, BodyType::static_body),
                  worlds::body(worlds::box(0.5, 20), {0.5 + width / 2, 20}, BodyType::static_body)};
  return scene;
}

// Boxes of 1 m in rows, with narrow gaps between columns.
void add_boxes(Scene& scene, int columns, int rows) {
  for (int row = 0; row < rows; ++row)
    for (int i = 0; i < columns; ++i)
      scene.bodies.push_back(worlds::body(worlds::box(0.5, 0.5), {1.05 * (i - 0.5 * (columns - 1)), row + 0.5}));
}

Result<Scene> pile() {
  return engine::make_builtin_scene("mixed_pile?bodies=40&substeps=4");
}

Result<Scene> discs() {
  return engine::make_builtin_scene("circles?columns=7&rows=30");
}

// A kinematic plate comes down on the boxes at 0.1 m/s.
Result<Scene> crusher() {
  Scene scene = tub("crusher", 6.5);
  add_boxes(scene, 6, 10);
  scene.bodies.push_back(worlds::body(worlds::box(3.2, 0.5), {0, 10.6}, BodyType::kinematic_body));
  scene.bodies.back().velocity = {0, -0.1};
  return scene;
}

// A motor of 1e4 N drives a plate down on the boxes.
Result<Scene> piston() {
  Scene scene = tub("piston", 10.8);
  add_boxes(scene, 10, 10);
  scene.bodies.push_back(worlds::weighted(worlds::box(5.3, 0.5), {0, 10.6}, 10));
  const auto plate = static_cast<std::uint32_t>(scene.bodies.size() - 1);
  engine::Joint ram = worlds::joint(engine::JointKind::prismatic, 0, plate, {0, 11.1});
  ram.axis = {0, -1};
  ram.motor = engine::JointMotor{1, 1e4};
  scene.joints.push_back(ram);
  return scene;
}

Result<Scene> card_house() {
  return engine::make_builtin_scene("card_house?substeps=4");
}

Result<Scene> dominoes() {
  Scene scene = worlds::empty(Precision::f32);
  scene.name = "dominoes";
  scene.bodies.push_back(worlds::ground());
  for (int i = 0; i < 30; ++i) scene.bodies.push_back(worlds::body(worlds::box(0.08, 0.5), {0.6 * i - 9, 0.5}));
  scene.bodies[1].velocity = {1.5, 0};
  scene.bodies[1].angular_velocity = -3;
  return scene;
}

Result<Scene> figures() {
  return engine::make_builtin_scene("rain?rows=1&columns=6&group=5");
}

Result<Scene> stack_10() {
  return engine::make_builtin_scene("stack?boxes=10&substeps=4");
}

Result<Scene> stack_40() {
  return engine::make_builtin_scene("stack?boxes=40&substeps=4");
}

Result<Scene> pyramid() {
  return engine::make_builtin_scene("pyramid?substeps=4");
}

Result<Scene> chain() {
  return engine::make_builtin_scene("chain?substeps=4");
}

// The smallest width of any moving shape, m.
double smallest_size(const Scene& scene) {
  double least = HUGE_VAL;
  for (const Body& body : scene.bodies) {
    if (body.type != BodyType::dynamic_body) continue;
    for (const engine::Shape& shape : body.shapes) {
      double size = 2 * shape.radius;
      if (shape.kind == engine::ShapeKind::box) size += 2 * std::min(shape.half_size.x, shape.half_size.y);
      if (size > 0) least = std::min(least, size);
    }
  }
  return std::isfinite(least) ? least : 1;
}

Result<RunTimeRow> run_time_of(const RunTimeScene& each, Precision precision, const RunTimeOptions& options,
                               const std::function<void(std::uint64_t)>& done) {
  Result<Scene> scene = each.make();
  if (!scene) return scene.error();
  scene->settings.precision = precision;
  scene->settings.substeps = 4;
  Scene fixed_scene = *scene;
  Scene default_scene = *scene;
  engine::choose_substeps(scene->settings);
  scene->settings.substep_loads = options.loads;
  scene->settings.substep_budget = options.budget;
  fixed_scene.settings.substeps = 64;
  Result<Run> automatic = Run::make(*scene);
  if (!automatic) return automatic.error();
  Result<Run> fixed = Run::make(fixed_scene);
  if (!fixed) return fixed.error();
  Result<Run> by_default = Run::make(default_scene);
  if (!by_default) return by_default.error();
  RunTimeRow row;
  row.scene = each.name;
  row.what = each.what;
  row.precision = automatic->engine().scene().settings.precision;
  const double size = smallest_size(*scene);
  while (row.tick_count < options.tick_count && row.automatic_s + row.fixed_s < options.seconds_max) {
    const std::uint64_t count = std::min(run_time_window, options.tick_count - row.tick_count);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (const Status did = automatic->advance(1); !did) return did.error();
      const int most = substeps_most(automatic->engine());
      row.substeps_most = std::max(row.substeps_most, most);
      row.ticks_at_most += most >= scene->settings.auto_substeps->substeps_max ? 1 : 0;
    }
    if (const Status did = fixed->advance(count); !did) return did.error();
    if (const Status did = by_default->advance(count); !did) return did.error();
    const double ours = automatic->step_time_s() - row.automatic_s;
    const double other = fixed->step_time_s() - row.fixed_s;
    if (other > 0) row.worst_ratio = std::max(row.worst_ratio, ours / other);
    const double by_default_s = by_default->step_time_s() - row.default_s;
    row.automatic_s += ours;
    row.fixed_s += other;
    row.default_s += by_default_s;
    if (row.tick_count >= run_time_settling) {
      row.automatic_later_s += ours;
      row.default_later_s += by_default_s;
    }
    row.tick_count += count;
    row.overlap = std::max(row.overlap, deepest_overlap(automatic->engine().contacts()) / size);
    row.gap = std::max(row.gap, largest(joint_gaps(*scene, automatic->bodies())));
    done(count);
  }
  if (const auto budget = automatic->engine().budget_report()) {
    row.cut_ticks = budget->cut_ticks;
    row.limited_ticks = budget->limited_ticks;
  }
  return row;
}

}  // namespace

const std::vector<RunTimeScene>& run_time_scenes() {
  static const std::vector<RunTimeScene> scenes{
      {"pile", "40 circles, boxes and polygons fall into a container", pile},
      {"discs", "a column of 210 discs falls into a tub", discs},
      {"crusher", "a kinematic plate comes down on 60 boxes", crusher},
      {"piston", "a motor drives a plate down on 100 boxes", piston},
      {"card_house", "forty cards stand", card_house},
      {"dominoes", "thirty dominoes fall", dominoes},
      {"figures", "thirty jointed figures fall on a floor", figures},
      {"stack_10", "ten boxes stand", stack_10},
      {"stack_40", "forty boxes stand", stack_40},
      {"pyramid", "a pyramid stands", pyramid},
      {"chain", "a chain hangs", chain},
  };
  return scenes;
}

Result<std::vector<RunTimeRow>> run_times(const RunTimeOptions& options) {
  const auto begins_with = [](std::string_view name, const std::string& start) {
    return name.substr(0, start.size()) == start;
  };
  std::vector<const RunTimeScene*> chosen;
  for (const RunTimeScene& each : run_time_scenes())
    if (options.names.empty() || std::any_of(options.names.begin(), options.names.end(),
                                             [&](const std::string& name) { return begins_with(each.name, name); }))
      chosen.push_back(&each);
  for (const std::string& name : options.names)
    if (std::none_of(chosen.begin(), chosen.end(), [&](const auto* each) { return begins_with(each->name, name); })) {
      std::string known;
      for (const RunTimeScene& each : run_time_scenes()) known += (known.empty() ? "" : ", ") + std::string(each.name);
      return Error{ErrorCode::usage, "stress: --run-time: found scene \"" + name + "\", expected one of " + known, ""};
    }
  std::uint64_t done_count = 0;
  const std::uint64_t total = chosen.size() * options.precisions.size() * options.tick_count;
  std::vector<RunTimeRow> rows;
  for (const Precision precision : options.precisions)
    for (const RunTimeScene* each : chosen) {
      const std::uint64_t before = done_count;
      Result<RunTimeRow> row = run_time_of(*each, precision, options, [&](std::uint64_t count) {
        done_count += count;
        if (options.progress) options.progress(done_count, total);
      });
      if (!row) return row.error();
      done_count = before + options.tick_count;
      rows.push_back(*std::move(row));
    }
  return rows;
}

}  // namespace ticktrue::tool
