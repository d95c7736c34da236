// Components of jointed bodies, and the joints of a scene in the form of the direct solver.
// SPDX-License-Identifier: MIT
#include "engine/joints/direct/direct_components.h"

#include <algorithm>
#include <numeric>

#include "engine/joints/joint_order.h"
#include "engine/math/union_find.h"
#include "engine/model/model.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The role of a joint in a component.
enum class JointRole : std::uint8_t {
  rows,       // solved directly
  force,      // bounded or soft: an outside force on the component
  iterative,  // has rigid rows without equations here
};

JointRole role_of(const JointModel& joint) {
  if (joint.gear != no_gear) return JointRole::iterative;
  if (!has_equations(joint.kind)) return JointRole::force;
  if (joint.kind != JointKind::weld || joint.rigid) return JointRole::rows;
  return joint.rigid_angle ? JointRole::iterative : JointRole::force;
}

Place place_of(Vec2 v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y)};
}

JointShape shape_of(const JointModel& joint) {
  JointShape shape;
  shape.kind = joint.kind;
  shape.anchor_a = place_of(joint.anchor_a);
  shape.anchor_b = place_of(joint.anchor_b);
  shape.axis = place_of(joint.axis);
  shape.reference_c = static_cast<double>(joint.reference.c);
  shape.reference_s = static_cast<double>(joint.reference.s);
  shape.length = static_cast<double>(joint.length);
  shape.ground_a = place_of(joint.ground_a);
  shape.ground_b = place_of(joint.ground_b);
  shape.ratio = static_cast<double>(joint.ratio);
  shape.is_driven = joint.spring.exists || joint.has_limits || joint.has_motor;
  if (joint.kind == JointKind::wheel) {
    shape.is_driven = joint.spring.exists || joint.has_limits;
    shape.turns_driven = joint.has_motor;
  }
  if (joint.kind == JointKind::distance) shape.is_driven = !joint.rigid;
  // A weld with an angular spring is a revolute joint with a spring.
  if (joint.kind == JointKind::weld && !joint.rigid_angle) shape.kind = JointKind::revolute;
  return shape;
}

bool is_dynamic_body(const Model& model, const State& state, std::uint32_t row) {
  return row != no_reference && model.bodies[state.bodies[row].source].type == BodyType::dynamic_body;
}

}  // namespace

void DirectComponents::clear() {
  invalidate();
  places_.clear();
  components_.clear();
  is_direct_.clear();
  component_of_.clear();
}

void DirectComponents::follow(const Model& model, const State& state, std::vector<DirectPlace>& places) {
  places.clear();
  for (const JointRow& joint : state.joints) {
    const std::uint32_t body_a = model.joints[joint.joint].body_a;
    places.push_back({joint.joint, body_a == no_reference ? no_reference : row_of_body(state, body_a),
                      row_of_body(state, joint.body_b)});
  }
  const bool is_hit = valid_for(places);
  count_use(is_hit);
  if (is_hit) return;
  places_ = places;
  rebuild(model, state);
}

void DirectComponents::rebuild(const Model& model, const State& state) {
  is_valid_ = true;
  components_.clear();
  is_direct_.assign(places_.size(), 0);
  component_of_.assign(state.bodies.size(), none);
  group_joints(model, state);
  finish(model, state);
}

/// Fills the joints of all components, and the bodies of components that are not left to iteration.
void DirectComponents::group_joints(const Model& model, const State& state) {
  std::vector<std::uint32_t> parent(state.bodies.size());
  std::iota(parent.begin(), parent.end(), std::uint32_t{0});
  // Unites the dynamic bodies of a joint. Returns one of them, or no_reference.
  const auto unite_bodies_of = [&](const JointModel& joint) {
    std::uint32_t last = no_reference;
    for_each_body(model, joint, [&](std::uint32_t id) {
      const std::uint32_t row = row_of_body(state, id);
      if (!is_dynamic_body(model, state, row)) return;
      if (last != no_reference) unite(parent, last, row);
      last = row;
    });
    return last;
  };
  std::vector<std::uint32_t> members(places_.size(), no_reference);  // [joint] a dynamic body of it
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    const JointModel& joint = model.joints[places_[i].joint];
    if (role_of(joint) != JointRole::force) members[i] = unite_bodies_of(joint);
  }
  std::vector<std::uint32_t> of_root(state.bodies.size(), none);
  std::vector<bool> is_left_out;
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    if (members[i] == no_reference) continue;
    std::uint32_t& component = of_root[find_root(parent, members[i])];
    if (component == none) {
      component = static_cast<std::uint32_t>(components_.size());
      components_.emplace_back();
      is_left_out.push_back(false);
    }
    components_[component].joints.push_back(i);
    if (role_of(model.joints[places_[i].joint]) == JointRole::iterative) is_left_out[component] = true;
  }
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    const std::uint32_t component = of_root[find_root(parent, row)];
    if (component == none || !is_dynamic_body(model, state, row)) continue;
    component_of_[row] = component;
    if (!is_left_out[component]) components_[component].bodies.push_back(row);
  }
}

/// Orders the components that are solved directly, and removes the other components.
void DirectComponents::finish(const Model& model, const State& state) {
  std::vector<std::uint32_t> index(state.bodies.size());  // [row] in the component's bodies
  std::vector<std::uint32_t> new_number(components_.size(), none);
  std::uint32_t count = 0;
  for (std::uint32_t old = 0; old < components_.size(); ++old) {
    DirectComponent& component = components_[old];
    component.moving_count = component.bodies.size();
    if (component.moving_count == 0) continue;
    std::vector<std::uint8_t> turns;
    for (std::uint32_t i = 0; i < component.bodies.size(); ++i) {
      index[component.bodies[i]] = i;
      turns.push_back(model.bodies[state.bodies[component.bodies[i]].source].inv_inertia > 0 ? 1 : 0);
    }
    const auto index_of = [&](std::uint32_t row) {
      if (row == no_reference) return no_direct_body;
      if (component_of_[row] == old) return index[row];
      const auto begin = component.bodies.begin() + static_cast<std::ptrdiff_t>(component.moving_count);
      const auto found = std::find(begin, component.bodies.end(), row);
      const auto at = static_cast<std::uint32_t>(found - component.bodies.begin());
      if (found == component.bodies.end()) component.bodies.push_back(row);
      return at;
    };
    std::vector<GraphJoint> joints;
    for (const std::uint32_t joint : component.joints) {
      JointShape shape = shape_of(model.joints[places_[joint].joint]);
      DirectJoint ends;
      ends.body_a = index_of(places_[joint].body_a);
      ends.body_b = index_of(places_[joint].body_b);
      shape.meets_in_middle = ends.body_a < component.moving_count && ends.body_b < component.moving_count;
      const auto body_turns = [&](std::uint32_t body) { return body < turns.size() && turns[body] != 0; };
      joints.push_back(
          graph_joint(shape, ends, component.moving_count, body_turns(ends.body_a), body_turns(ends.body_b)));
      component.is_free = component.is_free && is_internal(shape, ends, component.moving_count);
      const JointEquations rows = equations_of(shape, Pose{}, Pose{});
      ends.equations.rigid_count = rows.rigid_count;
      ends.equations.row_count = rows.row_count;
      ends.first_drive = component.drive_count;
      component.drive_count += rows.row_count - rows.rigid_count;
      component.shapes.push_back(shape);
      component.ends.push_back(ends);
    }
    const auto moving_count = static_cast<std::uint32_t>(component.moving_count);
    if (count_loops(moving_count, joints) > direct_loop_max) continue;
    component.graph = std::make_shared<const JointGraph>(make_joint_graph(moving_count, joints, turns));
    for (const std::uint32_t joint : component.joints) is_direct_[joint] = 1;
    new_number[old] = count++;
  }
  for (std::uint32_t& component : component_of_)
    if (component != none) component = new_number[component];
  std::erase_if(components_, [](const DirectComponent& component) { return component.graph == nullptr; });
}

void mark_direct_joints(const Model& model, const State& state, DirectMarks& out) {
  const std::size_t count = state.bodies.size();
  out.parent.resize(count);
  std::iota(out.parent.begin(), out.parent.end(), std::uint32_t{0});
  out.edges.assign(count, 0);
  out.sizes.assign(count, 0);
  out.is_iterative.assign(count, 0);
  out.is_direct.assign(state.joints.size(), 0);
  // Calls visit(row) for each dynamic body of a joint. Returns the last one, or no_reference.
  const auto for_each_moving = [&](const JointModel& joint, auto visit) {
    std::uint32_t last = no_reference;
    for_each_body(model, joint, [&](std::uint32_t id) {
      const std::uint32_t row = row_of_body(state, id);
      if (!is_dynamic_body(model, state, row)) return;
      visit(last, row);
      last = row;
    });
    return last;
  };
  const auto for_each_rigid = [&](auto visit) {
    for (std::size_t i = 0; i < state.joints.size(); ++i) {
      const JointModel& joint = model.joints[state.joints[i].joint];
      if (const JointRole role = role_of(joint); role != JointRole::force) visit(i, joint, role);
    }
  };
  for_each_rigid([&](std::size_t, const JointModel& joint, JointRole) {
    for_each_moving(joint, [&](std::uint32_t last, std::uint32_t row) {
      if (last != no_reference) unite(out.parent, last, row);
    });
  });
  for (std::uint32_t row = 0; row < count; ++row)
    if (is_dynamic_body(model, state, row)) ++out.sizes[find_root(out.parent, row)];
  for_each_rigid([&](std::size_t, const JointModel& joint, JointRole role) {
    const std::uint32_t member = for_each_moving(joint, [&](std::uint32_t last, std::uint32_t row) {
      if (last != no_reference) ++out.edges[find_root(out.parent, row)];
    });
    if (member != no_reference && role == JointRole::iterative) out.is_iterative[find_root(out.parent, member)] = 1;
  });
  for_each_rigid([&](std::size_t i, const JointModel& joint, JointRole) {
    const std::uint32_t member = for_each_moving(joint, [](std::uint32_t, std::uint32_t) {});
    if (member == no_reference) return;
    const std::uint32_t root = find_root(out.parent, member);
    const bool has_many_loops = out.edges[root] + 1 > out.sizes[root] + direct_loop_max;
    out.is_direct[i] = out.is_iterative[root] == 0 && !has_many_loops ? 1 : 0;
  });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
