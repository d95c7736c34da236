// Removes parts of a world, and searches for the smallest world that still fails.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shrink.h"

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <string_view>
#include <tuple>
#include <utility>

#include "engine/scene/scene_fields.h"
#include "tool/experiment/ddmin.h"

namespace ticktrue::soak {
namespace {

using engine::Input;
using engine::InputKind;
using engine::Scene;
using Indices = std::vector<std::size_t>;

constexpr std::uint32_t gone = 0xffffffff;

/// The new index of each of `count` old indices; `gone` for a removed index.
std::vector<std::uint32_t> renumbering(std::size_t count, const Indices& remaining) {
  std::vector<std::uint32_t> to(count, gone);
  for (std::size_t i = 0; i < remaining.size(); ++i) to[remaining[i]] = static_cast<std::uint32_t>(i);
  return to;
}

template <typename T>
std::vector<T> select(const std::vector<T>& all, const Indices& remaining) {
  std::vector<T> some;
  for (const std::size_t i : remaining) some.push_back(all[i]);
  return some;
}

/// The settings that define how the engine computes. The other settings define the behaviour of the world.
auto method_of(const engine::Settings& settings) {
  return std::tie(settings.precision, settings.dt, settings.substeps, settings.auto_substeps, settings.iterations,
                  settings.solver, settings.integrator, settings.broad_phase, settings.locate_impacts, settings.joints,
                  settings.substep_loads, settings.substep_budget);
}

bool has_body(const Input& input) {
  return info_of(engine::input_kinds, input.kind).has_body;
}

class Shrinker {
 public:
  Shrinker(const SoakCase& failing, const CaseFails& still_fails, const ShrinkOptions& options)
      : smallest_(failing), still_fails_(still_fails), options_(options) {}

  ShrinkResult run() {
    if (options_.first_wrong_tick) shorten_to(*options_.first_wrong_tick + 1);
    std::size_t size = 0;
    do {
      size = size_of(smallest_);
      remove_inputs();
      remove_bodies();
      remove_joints();
      remove_forces();
      remove_prototypes();
      set_defaults();
      if (!options_.keeps_course) search_ticks();
    } while (size_of(smallest_) < size && !is_over());
    return {std::move(smallest_), test_count_};
  }

 private:
  static std::size_t size_of(const SoakCase& soak_case) {
    const Scene& scene = soak_case.scene;
    return soak_case.inputs.size() + scene.bodies.size() + scene.joints.size() + scene.forces.size() +
           scene.prototypes.size() + static_cast<std::size_t>(soak_case.tick_count);
  }

  bool is_over() const { return test_count_ >= options_.test_count_max || (options_.is_over && options_.is_over()); }

  bool fails(const SoakCase& candidate) {
    if (is_over() || candidate.tick_count == 0 || !engine::check_scene(candidate.scene, "shrink")) return false;
    ++test_count_;
    return still_fails_(candidate);
  }
  bool take_if_fails(SoakCase candidate) {
    if (!fails(candidate)) return false;
    smallest_ = std::move(candidate);
    return true;
  }

  bool shorten_to(std::uint64_t tick_count) {
    if (tick_count >= smallest_.tick_count) return false;
    SoakCase candidate = smallest_;
    candidate.tick_count = tick_count;
    std::erase_if(candidate.inputs, [&](const Input& input) { return input.tick >= tick_count; });
    return take_if_fails(std::move(candidate));
  }
  /// Tries half of the ticks, then smaller steps. A world may fail at several ticks, so the search does not assume a
  /// single limit.
  void search_ticks() {
    for (std::uint64_t step = smallest_.tick_count / 2; step > 0; step /= 2)
      while (step < smallest_.tick_count && shorten_to(smallest_.tick_count - step)) {
      }
  }

  void remove_from_list(std::size_t count, SoakCase (*with)(const SoakCase&, const Indices&)) {
    const SoakCase before = smallest_;
    const Indices remaining = ddmin(count, [&](const Indices& some) { return fails(with(before, some)); });
    if (remaining.size() < count) smallest_ = with(before, remaining);
  }
  void remove_inputs() { remove_from_list(smallest_.inputs.size(), with_inputs); }
  void remove_bodies() { remove_from_list(smallest_.scene.bodies.size(), with_bodies); }
  void remove_joints() { remove_from_list(smallest_.scene.joints.size(), with_joints); }
  void remove_forces() {
    remove_from_list(smallest_.scene.forces.size(), [](const SoakCase& all, const Indices& remaining) {
      SoakCase some = all;
      some.scene.forces = select(all.scene.forces, remaining);
      return some;
    });
  }

  /// Removes prototypes that are never spawned.
  void remove_prototypes() {
    SoakCase candidate = smallest_;
    Indices remaining;
    for (std::size_t i = 0; i < candidate.scene.prototypes.size(); ++i) {
      const auto spawns = [&](const Input& input) { return input.kind == InputKind::spawn && input.prototype == i; };
      const bool is_spawned = std::any_of(candidate.inputs.begin(), candidate.inputs.end(), spawns);
      const std::string& name = candidate.scene.prototypes[i].name;
      const bool is_pressed = candidate.scene.pointer && std::count(candidate.scene.pointer->spawns.begin(),
                                                                    candidate.scene.pointer->spawns.end(), name) > 0;
      if (is_spawned || is_pressed) remaining.push_back(i);
    }
    if (remaining.size() == candidate.scene.prototypes.size()) return;
    const auto to = renumbering(candidate.scene.prototypes.size(), remaining);
    candidate.scene.prototypes = select(candidate.scene.prototypes, remaining);
    for (Input& input : candidate.inputs)
      if (input.kind == InputKind::spawn) input.prototype = static_cast<std::uint16_t>(to[input.prototype]);
    take_if_fails(std::move(candidate));
  }

  template <typename Change>
  void try_change(const Change& change) {
    SoakCase candidate = smallest_;
    change(candidate);
    if (candidate.scene == smallest_.scene && candidate.inputs == smallest_.inputs) return;
    if (options_.keeps_method && method_of(candidate.scene.settings) != method_of(smallest_.scene.settings)) return;
    take_if_fails(std::move(candidate));
  }
  /// Tries the default of one field after another. `each(candidate, change)` changes all objects of a case.
  template <typename Struct, typename Each>
  void try_defaults(const Each& each, std::initializer_list<std::string_view> others = {}) {
    const Struct unset;
    engine::Fields<Struct>::list([&](const engine::FieldInfo& field, auto member) {
      if (std::find(others.begin(), others.end(), field.name) != others.end()) return;
      const auto change = [&](Struct& object) { std::invoke(member, object) = std::invoke(member, unset); };
      try_change([&](SoakCase& candidate) { each(candidate, change); });
    });
  }

  void set_defaults() {
    const auto each_body = [](SoakCase& candidate, const auto& change) {
      for (engine::Body& body : candidate.scene.bodies) change(body);
      for (engine::Body& body : candidate.scene.prototypes) change(body);
    };
    const auto each_shape = [&](SoakCase& candidate, const auto& change) {
      each_body(candidate, [&](engine::Body& body) {
        for (engine::Shape& shape : body.shapes) change(shape);
      });
    };
    const auto settings = [](SoakCase& candidate, const auto& change) { change(candidate.scene.settings); };
    try_defaults<engine::Settings>(settings);
    set_default_scene();
    try_defaults<engine::Body>(each_body, {"name", "type", "position", "angle", "velocity", "shapes"});
    try_defaults<engine::Shape>(each_shape);
  }
  void set_default_scene() {
    try_change([](SoakCase& candidate) { candidate.scene.bounds.reset(); });
    try_change([](SoakCase& candidate) { candidate.scene.spawned_max.reset(); });
    if (!options_.keeps_course) try_change([](SoakCase& candidate) { candidate.scene.gravity = {}; });
    try_change([](SoakCase& candidate) {
      const auto uses_pointer = [](InputKind kind) { return info_of(engine::input_kinds, kind).is_of_pointer; };
      candidate.scene.pointer.reset();
      std::erase_if(candidate.scene.inputs, uses_pointer);
      std::erase_if(candidate.inputs, [&](const Input& input) { return uses_pointer(input.kind); });
    });
    try_change([](SoakCase& candidate) {
      std::erase_if(candidate.scene.inputs, [&](InputKind kind) {
        const auto is_of = [&](const Input& input) { return input.kind == kind; };
        return std::none_of(candidate.inputs.begin(), candidate.inputs.end(), is_of);
      });
    });
    try_change([](SoakCase& candidate) {
      for (engine::Joint& joint : candidate.scene.joints) joint.limits.reset();
    });
    try_change([](SoakCase& candidate) {
      for (engine::Joint& joint : candidate.scene.joints) joint.motor.reset();
    });
    try_change([](SoakCase& candidate) {
      for (engine::Joint& joint : candidate.scene.joints) joint.collide_connected = false;
    });
  }

  SoakCase smallest_;
  const CaseFails& still_fails_;
  const ShrinkOptions& options_;
  std::size_t test_count_ = 0;
};

}  // namespace

SoakCase with_bodies(const SoakCase& soak_case, const Indices& remaining) {
  SoakCase some = soak_case;
  Scene& scene = some.scene;
  const std::size_t count = scene.bodies.size();
  const auto to = renumbering(count, remaining);
  scene.bodies = select(scene.bodies, remaining);
  Indices joints;
  for (std::size_t i = 0; i < scene.joints.size(); ++i) {
    bool keeps = true;
    engine::for_each_body(scene, scene.joints[i], [&](std::uint32_t body) { keeps = keeps && to[body] != gone; });
    if (keeps) joints.push_back(i);
  }
  some = with_joints(some, joints);
  for (engine::Joint& joint : scene.joints) {
    if (engine::joins_joints(joint.kind)) continue;
    if (engine::has_body_a(joint.kind)) joint.body_a = to[joint.body_a];
    joint.body_b = to[joint.body_b];
  }
  std::erase_if(scene.forces, [&](const engine::Force& force) {
    return (force.body && to[*force.body] == gone) || (force.other && to[*force.other] == gone);
  });
  for (engine::Force& force : scene.forces) {
    if (force.body) force.body = to[*force.body];
    if (force.other) force.other = to[*force.other];
  }
  std::erase_if(some.inputs,
                [&](const Input& input) { return has_body(input) && input.body < count && to[input.body] == gone; });
  const auto fewer = static_cast<std::uint32_t>(count - remaining.size());
  for (Input& input : some.inputs)
    if (has_body(input)) input.body = input.body < count ? to[input.body] : input.body - fewer;
  return some;
}

SoakCase with_joints(const SoakCase& soak_case, const Indices& remaining) {
  SoakCase some = soak_case;
  std::vector<std::uint8_t> is_kept(soak_case.scene.joints.size(), 0);
  for (const std::size_t i : remaining) is_kept[i] = 1;
  const std::vector<std::uint32_t> to = keep_joints(some.scene, is_kept);
  const auto is_of_joint = [](const Input& input) { return info_of(engine::input_kinds, input.kind).has_joint; };
  std::erase_if(some.inputs, [&](const Input& input) {
    return is_of_joint(input) && (input.joint >= to.size() || to[input.joint] == engine::no_joint);
  });
  for (Input& input : some.inputs)
    if (is_of_joint(input)) input.joint = to[input.joint];
  return some;
}

SoakCase with_inputs(const SoakCase& soak_case, const Indices& remaining) {
  SoakCase some = soak_case;
  // Spawns create bodies in order, with ids after those of the scene.
  const auto first_id = static_cast<std::uint32_t>(soak_case.scene.bodies.size());
  Indices spawns;
  std::vector<bool> is_remaining(soak_case.inputs.size());
  for (const std::size_t i : remaining) is_remaining[i] = true;
  std::size_t spawn_count = 0;
  for (std::size_t i = 0; i < soak_case.inputs.size(); ++i) {
    if (soak_case.inputs[i].kind != InputKind::spawn) continue;
    if (is_remaining[i]) spawns.push_back(spawn_count);
    ++spawn_count;
  }
  const auto to = renumbering(spawn_count, spawns);
  some.inputs = select(soak_case.inputs, remaining);
  const auto spawn_of = [&](const Input& input) { return std::size_t{input.body} - first_id; };
  const auto is_of_spawned = [&](const Input& input) {
    return has_body(input) && input.body >= first_id && spawn_of(input) < spawn_count;
  };
  std::erase_if(some.inputs, [&](const Input& input) { return is_of_spawned(input) && to[spawn_of(input)] == gone; });
  for (Input& input : some.inputs)
    if (is_of_spawned(input)) input.body = first_id + to[spawn_of(input)];
  return some;
}

ShrinkResult shrink(const SoakCase& failing, const CaseFails& still_fails, const ShrinkOptions& options) {
  return Shrinker(failing, still_fails, options).run();
}

}  // namespace ticktrue::soak
