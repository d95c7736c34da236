// The joints that are solved directly: components of bodies that joints connect, with their order of elimination.
// SPDX-License-Identifier: MIT
// A component consists of dynamic bodies and the joints whose rows hold them together. Bodies that joints do not move
// connect nothing, and neither do contacts. A component is solved by iteration if it has more than `direct_loop_max`
// loops, or a joint without rows here. Joints of bounded force alternate with the direct solve, as contacts do.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/joints/direct/direct_island.h"
#include "engine/joints/joint_model.h"
#include "engine/model/caches.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;

/// A joint and the rows of its bodies; no_reference: the world.
struct DirectPlace {
  std::uint32_t joint;  // in Model::joints
  std::uint32_t body_a;
  std::uint32_t body_b;
  bool operator==(const DirectPlace&) const = default;
};

struct DirectComponent {
  std::vector<std::uint32_t> joints;  // rows in State::joints
  std::vector<std::uint32_t> bodies;  // rows; bodies that joints move come first, ascending
  std::size_t moving_count = 0;
  bool is_free = true;             // each joint acts on two moving bodies, with opposite impulses
  std::vector<JointShape> shapes;  // [joint]
  std::vector<DirectJoint> ends;   // [joint] bodies and numbers of rows alone
  std::uint32_t drive_count = 0;   // of all joints
  std::shared_ptr<const JointGraph> graph;
};

/// The components of a world. Key: the joints that exist, with the rows of their bodies.
class DirectComponents final : public TickCache {
 public:
  static constexpr std::uint32_t none = 0xffffffff;

  DirectComponents() : TickCache(CacheKind::joint_graph) {}

  /// Finds the components, unless they are valid. `places` is overwritten.
  void follow(const Model& model, const State& state, std::vector<DirectPlace>& places);
  void invalidate() override { is_valid_ = false; }
  /// Removes all components.
  void clear();

  std::span<const DirectComponent> components() const { return components_; }
  /// [row of a joint] 1: the joint belongs to a component; empty: there are no components.
  std::span<const std::uint8_t> direct_joints() const { return is_direct_; }
  std::uint32_t component_of(std::size_t row) const { return row < component_of_.size() ? component_of_[row] : none; }

 private:
  bool valid_for(const std::vector<DirectPlace>& places) const { return is_valid_ && places_ == places; }
  void rebuild(const Model& model, const State& state);
  void group_joints(const Model& model, const State& state);
  void finish(const Model& model, const State& state);

  bool is_valid_ = false;
  std::vector<DirectPlace> places_;  // key
  std::vector<DirectComponent> components_;
  std::vector<std::uint8_t> is_direct_;
  std::vector<std::uint32_t> component_of_;  // [row of a body]
};

/// The joints that are solved directly, found without their order of elimination.
struct DirectMarks {
  std::vector<std::uint8_t> is_direct;     // [row of a joint]; empty: none is direct
  std::vector<std::uint32_t> parent;       // [body] union-find
  std::vector<std::uint32_t> edges;        // [body] at a component's root: joints between dynamic bodies
  std::vector<std::uint32_t> sizes;        // [body] at a component's root: dynamic bodies
  std::vector<std::uint8_t> is_iterative;  // [body] at a component's root: some joint has no equations
};

template <typename Visit>
void list_fields(DirectMarks& of, const Visit& visit) {
  auto& [is_direct, parent, edges, sizes, is_iterative] = of;
  visit(is_direct, parent, edges, sizes, is_iterative);
}

/// Fills out.is_direct as DirectComponents::direct_joints would. Requires: the scene has direct joints.
void mark_direct_joints(const Model& model, const State& state, DirectMarks& out);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
