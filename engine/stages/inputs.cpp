// Input events: bodies are spawned and removed, forces and impulses act, pointers press, drag and release.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "engine/math/trig.h"
#include "engine/narrow_phase/narrow_phase.h"
#include "engine/stages/stages.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

Real to_real(double value) {
  return stored(static_cast<Real>(value));
}
Vec2 to_vec2(double x, double y) {
  return {to_real(x), to_real(y)};
}

void wake_joint(const Model& model, State& state, const JointRow& joint) {
  for_each_body(model, model.joints[joint.joint], [&](std::uint32_t id) { state.wake(state.find_body(id)); });
}

template <typename Vector, typename Predicate>
void erase_where(Vector& rows, Predicate predicate) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (!predicate(rows[i])) rows[count++] = rows[i];
  rows.resize(count);
}

bool joins_body(const Model& model, const JointRow& joint, std::uint32_t id) {
  bool found = false;
  for_each_body(model, model.joints[joint.joint], [&](std::uint32_t own) { found = found || own == id; });
  return found;
}

/// Removes the joints of a body, and gears of these joints, since a gear has all their bodies.
void remove_joints(const Model& model, State& state, std::uint32_t body) {
  std::size_t gear = 0;
  std::size_t gear_count = 0;
  for (const JointRow& joint : state.joints) {
    if (model.joints[joint.joint].gear == no_gear) continue;
    if (!joins_body(model, joint, body)) state.gears[gear_count++] = state.gears[gear];
    ++gear;
  }
  state.gears.resize(gear_count);
  erase_where(state.joints, [&](const JointRow& joint) { return joins_body(model, joint, body); });
}

/// Counts an input to something that was removed before.
void ignore(State& state) {
  if (state.world.ignored_inputs != no_reference) ++state.world.ignored_inputs;
}

/// The row of an input's body, which is woken. Null if the body was removed; the input is then counted as ignored.
BodyRow* find(State& state, const Input& input) {
  const std::size_t row = state.find_body(input.body);
  if (row < state.bodies.size()) {
    state.wake(row);
    return &state.bodies[row];
  }
  ignore(state);
  return nullptr;
}

void add_body(const Model& model, State& state, TickLists& tick, std::uint32_t prototype, const Input& pose) {
  if (model.scene.spawned_max) {
    std::size_t spawned = 0;
    std::size_t oldest = state.bodies.size();
    for (std::size_t row = state.bodies.size(); row-- > 0;)
      if (state.bodies[row].source >= model.first_prototype) {
        ++spawned;
        oldest = row;
      }
    if (spawned >= *model.scene.spawned_max && spawned > 0) remove_body(model, state, tick, oldest);
  }
  const std::uint32_t source = model.first_prototype + prototype;
  const BodyModel& constants = model.bodies[source];
  const SinCos rotation = pose_sin_cos(pose.values[2]);
  BodyRow row{};
  row.id = state.world.next_id++;
  row.source = source;
  row.rotation = {to_real(rotation.cos), to_real(rotation.sin)};
  row.position = stored(to_vec2(pose.values[0], pose.values[1]) + rotate(row.rotation, constants.center));
  if (constants.type != BodyType::static_body) {
    row.velocity = to_vec2(pose.values[3], pose.values[4]);
    row.angular_velocity = to_real(pose.values[5]);
  }
  add_body_row(model, state, row);
  if (!tick.force.empty()) {
    tick.force.push_back({0, 0});
    tick.torque.push_back(0);
  }
}

void allocate_forces(const State& state, TickLists& tick) {
  if (!tick.force.empty()) return;
  tick.force.assign(state.bodies.size(), Vec2{0, 0});
  tick.torque.assign(state.bodies.size(), Real(0));
}

void do_spawn(const Model& model, State& state, TickLists& tick, const Input& input) {
  add_body(model, state, tick, input.prototype, input);
}

void do_remove(const Model& model, State& state, TickLists& tick, const Input& input) {
  if (find(state, input) != nullptr) remove_body(model, state, tick, state.find_body(input.body));
}

void do_impulse(const Model& model, State& state, TickLists&, const Input& input) {
  BodyRow* body = find(state, input);
  if (body == nullptr) return;
  const BodyModel& constants = model.bodies[body->source];
  const Vec2 impulse = to_vec2(input.values[0], input.values[1]);
  const Vec2 arm = rotate(body->rotation, to_vec2(input.values[2], input.values[3]));
  body->velocity = stored(body->velocity + constants.inv_mass * impulse);
  body->angular_velocity = stored(body->angular_velocity + constants.inv_inertia * cross(arm, impulse));
}

void do_force(const Model&, State& state, TickLists& tick, const Input& input) {
  const BodyRow* body = find(state, input);
  if (body == nullptr) return;
  allocate_forces(state, tick);
  const std::size_t row = state.find_body(input.body);
  const Vec2 force = to_vec2(input.values[0], input.values[1]);
  const Vec2 arm = rotate(body->rotation, to_vec2(input.values[2], input.values[3]));
  tick.force[row] = tick.force[row] + force;
  tick.torque[row] += cross(arm, force);
}

void do_torque(const Model&, State& state, TickLists& tick, const Input& input) {
  if (find(state, input) == nullptr) return;
  allocate_forces(state, tick);
  tick.torque[state.find_body(input.body)] += static_cast<Real>(input.values[0]);
}

void do_set_velocity(const Model& model, State& state, TickLists& tick, const Input& input) {
  BodyRow* body = find(state, input);
  if (body == nullptr) return;
  if (is_moving(*body) && model.bodies[body->source].type == BodyType::kinematic_body)
    tick.moved_before.push_back(body->id);
  body->velocity = to_vec2(input.values[0], input.values[1]);
  body->angular_velocity = to_real(input.values[2]);
}

void do_set_gravity(const Model&, State& state, TickLists&, const Input& input) {
  state.world.gravity = to_vec2(input.values[0], input.values[1]);
  for (std::size_t row = 0; row < state.bodies.size(); ++row) state.wake(row);
}

void do_release(const Model&, State& state, TickLists&, const Input& input) {
  erase_where(state.pointers, [&](const PointerRow& row) { return row.player == input.player; });
}

void do_press(const Model& model, State& state, TickLists& tick, const Input& input) {
  do_release(model, state, tick, input);
  const Vec2 at = to_vec2(input.values[0], input.values[1]);
  bool occupied = false;
  // The newest body is in front.
  for (std::size_t row = state.bodies.size(); row-- > 0;) {
    const BodyRow& body = state.bodies[row];
    const BodyModel& constants = model.bodies[body.source];
    bool hit = false;
    for (std::uint32_t child = 0; child < constants.shape_count && !hit; ++child) {
      const ShapeModel& shape = model.shape(constants, child);
      hit = !shape.is_sensor && contains(model, shape, body, at);
    }
    if (!hit) continue;
    occupied = true;
    if (constants.type != BodyType::dynamic_body) continue;
    const Vec2 anchor = stored(rotate_back(body.rotation, at - body.position));
    const PointerRow pointer{input.player, body.id, anchor, at, {0, 0}};
    std::size_t place = state.pointers.size();
    while (place > 0 && state.pointers[place - 1].player > pointer.player) --place;
    state.pointers.insert(state.pointers.begin() + static_cast<std::ptrdiff_t>(place), pointer);
    return;
  }
  if (occupied || model.pointer_spawns.empty()) return;
  Input pose;
  pose.values[0] = input.values[0];
  pose.values[1] = input.values[1];
  // Prototypes are spawned in turn. No id is used twice, so ids count the spawned bodies.
  const std::size_t turn = (state.world.next_id - model.first_prototype) % model.pointer_spawns.size();
  add_body(model, state, tick, model.pointer_spawns[turn], pose);
}

void do_drag(const Model&, State& state, TickLists&, const Input& input) {
  for (PointerRow& row : state.pointers)
    if (row.player == input.player) row.target = to_vec2(input.values[0], input.values[1]);
}

void do_set_motor(const Model& model, State& state, TickLists&, const Input& input) {
  for (JointRow& row : state.joints)
    if (row.joint == input.joint) {
      row.motor_speed = to_real(input.values[0]);
      row.motor_force_max = to_real(input.values[1]);
      wake_joint(model, state, row);
      return;
    }
  ignore(state);
}

void do_end(const Model&, State&, TickLists&, const Input&) {}  // the recorder stops before this tick

struct InputFunction {
  InputKind kind;
  void (*act)(const Model& model, State& state, TickLists& tick, const Input& input);
};
constexpr std::array<InputFunction, input_kinds.size()> input_functions{{
    {InputKind::spawn, do_spawn},
    {InputKind::remove, do_remove},
    {InputKind::impulse, do_impulse},
    {InputKind::force, do_force},
    {InputKind::torque, do_torque},
    {InputKind::set_velocity, do_set_velocity},
    {InputKind::set_gravity, do_set_gravity},
    {InputKind::press, do_press},
    {InputKind::drag, do_drag},
    {InputKind::release, do_release},
    {InputKind::end, do_end},
    {InputKind::set_motor, do_set_motor},
}};

}  // namespace

void remove_body(const Model& model, State& state, TickLists& tick, std::size_t row) {
  const std::uint32_t id = state.bodies[row].id;
  for (const ContactRow& contact : state.contacts) {
    if (contact.body_a == id) state.wake(state.find_body(contact.body_b));
    if (contact.body_b == id) state.wake(state.find_body(contact.body_a));
  }
  for (const JointRow& joint : state.joints)
    if (joins_body(model, joint, id)) wake_joint(model, state, joint);
  for (const SpringForce& spring : model.springs)
    if (spring.body == id || spring.other == id)
      for (const std::uint32_t end : {spring.body, spring.other})
        if (const std::size_t at = state.find_body(end); at < state.bodies.size()) state.wake(at);
  erase_body_row(state, row);
  if (!tick.force.empty()) {
    tick.force.erase(tick.force.begin() + static_cast<std::ptrdiff_t>(row));
    tick.torque.erase(tick.torque.begin() + static_cast<std::ptrdiff_t>(row));
  }
  erase_where(state.contacts, [id](const ContactRow& contact) { return contact.body_a == id || contact.body_b == id; });
  erase_where(state.pointers, [id](const PointerRow& pointer) { return pointer.body == id; });
  remove_joints(model, state, id);
  // The ends of touches are events of this tick.
  const auto move_touches = [id](std::vector<TouchRow>& rows, std::vector<TouchRow>& removed) {
    const auto has_body = [id](const TouchRow& touch) { return touch.body_a == id || touch.body_b == id; };
    for (const TouchRow& touch : rows)
      if (has_body(touch)) removed.push_back(touch);
    erase_where(rows, has_body);
  };
  move_touches(state.touching, tick.removed_touching);
  move_touches(state.sensors, tick.removed_sensors);
}

void apply_inputs(const Model& model, State& state, TickLists& tick, Real) {
  tick.first_new_id = state.world.next_id;
  for (const Input& input : tick.inputs) info_of(input_functions, input.kind).act(model, state, tick, input);
  // total order: by id
  std::sort(tick.moved_before.begin(), tick.moved_before.end());
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
