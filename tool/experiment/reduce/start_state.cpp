// Makes scenes from states.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/start_state.h"

#include <algorithm>
#include <map>
#include <string>

namespace ticktrue::reduce {
namespace {

using engine::Body;
using engine::BodyReport;
using engine::BodyType;
using engine::Input;
using engine::InputKind;
using engine::Scene;
using soak::SoakCase;

class LaterStart {
 public:
  LaterStart(const SoakCase& session, const engine::Engine& engine)
      : session_(session), engine_(engine), tick_(engine.tick()) {}

  SoakCase make() {
    SoakCase later = session_;
    later.tick_count = session_.tick_count - std::min(session_.tick_count, tick_);
    set_bodies(later.scene);
    set_joints(later.scene);
    set_forces(later.scene);
    apply_past_inputs(later.scene);
    set_inputs(later);
    return later;
  }

 private:
  /// The description of a body in the scene, or of the prototype whose name its name begins with.
  const Body* description_of(const BodyReport& report) const {
    const Scene& scene = session_.scene;
    if (report.id < scene.bodies.size()) return &scene.bodies[report.id];
    const std::string name = report.name.substr(0, report.name.rfind('#'));
    for (const Body& prototype : scene.prototypes)
      if (prototype.name == name) return &prototype;
    return nullptr;
  }

  void set_bodies(Scene& scene) {
    scene.bodies.clear();
    for (const BodyReport& report : engine_.bodies()) {
      const Body* description = description_of(report);
      if (description == nullptr) continue;
      Body body = *description;
      if (report.id >= session_.scene.bodies.size()) body.name.clear();
      if (body.type != BodyType::static_body) {
        body.position = report.origin;
        body.angle = report.angle;
        body.velocity = report.velocity;
        body.angular_velocity = report.angular_velocity;
      }
      index_of_[report.id] = static_cast<std::uint32_t>(scene.bodies.size());
      scene.bodies.push_back(std::move(body));
    }
    new_count_ = static_cast<std::uint32_t>(scene.bodies.size());
  }

  bool is_left(std::uint32_t id) const { return index_of_.count(id) != 0; }

  void set_joints(Scene& scene) {
    scene.joints.clear();
    for (const engine::Joint& joint : session_.scene.joints) {
      bool keeps = true;
      engine::for_each_body(session_.scene, joint, [&](std::uint32_t body) { keeps = keeps && is_left(body); });
      joint_index_.push_back(gone);
      if (!keeps) continue;
      joint_index_.back() = static_cast<std::uint32_t>(scene.joints.size());
      engine::Joint& now = scene.joints.emplace_back(joint);
      if (engine::joins_joints(joint.kind)) {
        now.joint_a = joint_index_[joint.joint_a];
        now.joint_b = joint_index_[joint.joint_b];
        continue;
      }
      now.body_b = index_of_[joint.body_b];
      if (engine::has_body_a(joint.kind)) now.body_a = index_of_[joint.body_a];
    }
  }

  void set_forces(Scene& scene) {
    std::erase_if(scene.forces, [&](const engine::Force& force) {
      return (force.body && !is_left(*force.body)) || (force.other && !is_left(*force.other));
    });
    for (engine::Force& force : scene.forces) {
      if (force.body) force.body = index_of_[*force.body];
      if (force.other) force.other = index_of_[*force.other];
    }
  }

  /// Applies the lasting effects of earlier inputs: gravity and motors.
  void apply_past_inputs(Scene& scene) const {
    for (const Input& input : session_.inputs) {
      if (input.tick >= tick_) continue;
      if (input.kind == InputKind::set_gravity) scene.gravity = {input.values[0], input.values[1]};
      if (input.kind != InputKind::set_motor || input.joint >= joint_index_.size()) continue;
      const std::uint32_t joint = joint_index_[input.joint];
      if (joint != gone) scene.joints[joint].motor = engine::JointMotor{input.values[0], input.values[1]};
    }
  }

  void set_inputs(SoakCase& later) {
    const auto first_id = static_cast<std::uint32_t>(session_.scene.bodies.size());
    std::uint32_t spawned_count = 0;
    later.inputs.clear();
    for (const Input& input : session_.inputs)
      if (input.kind == InputKind::spawn && input.tick < tick_) ++spawned_count;
    for (Input input : session_.inputs) {
      if (input.tick < tick_) continue;
      input.tick -= tick_;
      const engine::InputInfo& info = info_of(engine::input_kinds, input.kind);
      if (info.has_joint) {
        if (input.joint >= joint_index_.size() || joint_index_[input.joint] == gone) continue;
        input.joint = joint_index_[input.joint];
      }
      if (info.has_body && is_left(input.body)) {
        input.body = index_of_[input.body];
      } else if (info.has_body) {
        if (input.body < first_id + spawned_count) continue;  // its body no longer exists
        input.body = new_count_ + (input.body - first_id - spawned_count);
      }
      later.inputs.push_back(input);
    }
  }

  static constexpr std::uint32_t gone = 0xffffffff;

  const SoakCase& session_;
  const engine::Engine& engine_;
  std::uint64_t tick_;
  std::map<std::uint32_t, std::uint32_t> index_of_;  // new index, by id
  std::vector<std::uint32_t> joint_index_;           // [old joint index]: new index
  std::uint32_t new_count_ = 0;
};

}  // namespace

SoakCase begin_at_state(const SoakCase& session, const engine::Engine& engine) {
  return LaterStart(session, engine).make();
}

}  // namespace ticktrue::reduce
