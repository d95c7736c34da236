// Checks momentum and energy of a world, and its joint gaps and overlaps by the law of soft constraints.
// SPDX-License-Identifier: MIT
#include "tool/experiment/oracle/physics_checks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "base/limits.h"
#include "tool/experiment/oracle/constraint_law.h"
#include "tool/experiment/shrink.h"
#include "tool/expression/named_table.h"
#include "tool/study/measures.h"
#include "tool/study/table.h"

namespace ticktrue::soak {
namespace {

using engine::Body;
using engine::BodyReport;
using engine::BodyType;
using engine::Joint;
using engine::Point;
using engine::Scene;

constexpr double energy_rise_max = 0.05;   // relative to the largest kinetic energy so far
constexpr std::uint64_t sample_ticks = 8;  // energy is looked at every so many ticks

/// Whether only contacts and joints without stored energy change the energy.
bool is_undriven(const SoakCase& soak_case) {
  const Scene& scene = soak_case.scene;
  const auto moves_itself = [](const Body& body) {
    const bool is_kinematic = body.type == BodyType::kinematic_body;
    return is_kinematic || std::any_of(body.shapes.begin(), body.shapes.end(),
                                       [](const engine::Shape& shape) { return shape.material.tangent_speed != 0; });
  };
  const auto drives = [](const Joint& joint) {
    return joint.motor || joint.spring || joint.linear_spring || engine::traits_of(joint.kind).is_driven;
  };
  return soak_case.inputs.empty() && scene.forces.empty() && !scene.bounds &&
         std::none_of(scene.bodies.begin(), scene.bodies.end(), moves_itself) &&
         std::none_of(scene.joints.begin(), scene.joints.end(), drives);
}

/// Whether a body moves along a line that a body turns which no force can slow down: a kinematic one, or one with a
/// fixed rotation. It then goes outwards as e^(w t), with the spin w of the other body, unless limits hold it, or a
/// spring of a frequency above w. A damper only delays it. `bodies`: those of the scene.
bool has_driven_slide(const Scene& scene, const tool::Bodies& bodies) {
  const auto spin_of = [&scene](std::uint32_t id) {
    const Body& body = scene.bodies[id];
    const bool keeps_spin = body.type == BodyType::kinematic_body || body.fixed_rotation;
    return body.type != BodyType::static_body && keeps_spin ? std::fabs(body.angular_velocity) : 0;
  };
  const auto mass_of = [&bodies](std::uint32_t id) {
    const auto found = std::find_if(bodies.begin(), bodies.end(), [id](const auto& body) { return body.id == id; });
    return found != bodies.end() ? found->mass : 0;
  };
  const auto throws = [&](const Joint& joint, std::uint32_t leader, std::uint32_t other) {
    const double spin = spin_of(leader);
    if (!(spin > 0) || joint.limits) return false;
    if (!joint.spring) return true;
    const double omega2 = joint.spring->absolute ? joint.spring->stiffness / mass_of(other)
                                                 : std::pow(2 * std::numbers::pi * joint.spring->hertz, 2);
    return omega2 < spin * spin;
  };
  return std::any_of(scene.joints.begin(), scene.joints.end(), [&](const Joint& joint) {
    // A slider holds the angle between its bodies; a wheel may turn while its axis does not.
    const bool is_slider = joint.kind == engine::JointKind::prismatic;
    if (!is_slider && joint.kind != engine::JointKind::wheel) return false;
    return throws(joint, joint.body_a, joint.body_b) || (is_slider && throws(joint, joint.body_b, joint.body_a));
  });
}

/// Whether a central force has no bound: it grows without end towards its centre, where a body starts, or it pushes
/// away faster than the distance grows, which takes a body to infinity within a finite time.
bool has_boundless_force(const Scene& scene, const tool::Bodies& bodies) {
  constexpr double near_m = 1e-3;
  return std::any_of(scene.forces.begin(), scene.forces.end(), [&](const engine::Force& force) {
    if (force.kind != engine::ForceKind::central) return false;
    if (force.coefficient < 0 && force.exponent > 1) return true;
    return force.exponent < 0 && std::any_of(bodies.begin(), bodies.end(), [&](const BodyReport& body) {
             if (body.type != BodyType::dynamic_body || (force.body && *force.body != body.id)) return false;
             return std::hypot(body.center.x - force.point.x, body.center.y - force.point.y) < near_m;
           });
  });
}

/// What the rounding of their positions may change in the energy of bodies, J.
double rounding_of_energy(const Scene& scene, const tool::Bodies& bodies) {
  const double unit = scene.settings.precision == engine::Precision::f32 ? 0x1p-23 : 0x1p-52;
  double sum = 0;
  for (const BodyReport& body : bodies)
    if (body.type == BodyType::dynamic_body)
      sum += body.mass * (std::fabs(scene.gravity.x * body.center.x) + std::fabs(scene.gravity.y * body.center.y));
  return unit * sum;
}

/// The most that the contacts of the solver `pgs` did in a tick by pushing overlaps apart, J. The push is part of the
/// velocity and stays. With the normal impulses p, the speeds v before and u after them, and the symmetric matrix K of
/// u - v = K p, the work is p.(u + v) / 2 = p.u - p.K p / 2, so at most p.u. What overlaps by d may have u up to the
/// push.
double work_of_pushes(const engine::Engine& engine, const tool::Bodies& bodies, double dt) {
  constexpr double share = 0.2, slop_m = 0.005, speed_max = 3;  // docs/physics.md
  std::map<std::uint32_t, const BodyReport*> of_id;
  for (const BodyReport& body : bodies) of_id[body.id] = &body;
  double work = 0;
  for (const engine::ContactReport& contact : engine.contacts()) {
    const auto at = [&](std::uint32_t id, const Point& p) {
      const BodyReport& body = *of_id.at(id);
      return contact.normal.x * (body.velocity.x - body.angular_velocity * (p.y - body.center.y)) +
             contact.normal.y * (body.velocity.y + body.angular_velocity * (p.x - body.center.x));
    };
    for (int i = 0; i < contact.point_count; ++i) {
      const double speed = at(contact.body_b, contact.point[i]) - at(contact.body_a, contact.point[i]);
      const double overlap = speed * dt - contact.separation[i];  // before the bodies moved
      const double push = std::min(share * (overlap - slop_m) / dt, speed_max);
      work += contact.normal_force[i] * dt * std::max(0.0, std::min(speed, push));
    }
  }
  return work;
}

/// The ways of bodies by the impulses, forces and torques of inputs alone. An input for a heavy body may be given to a
/// light one. A contact may turn a spin into a speed of the same energy.
class ThrownBodies {
 public:
  explicit ThrownBodies(const SoakCase& soak_case) : inputs_(soak_case.inputs) {}

  /// To be called before each tick.
  void add_tick(const tool::Bodies& bodies, std::uint64_t tick, double dt) {
    for (; at_ < inputs_.size() && inputs_[at_].tick <= tick; ++at_) {
      const engine::Input& input = inputs_[at_];
      const bool is_torque = input.kind == engine::InputKind::torque;
      const bool lasts = is_torque || input.kind == engine::InputKind::force;
      if (!lasts && input.kind != engine::InputKind::impulse) continue;
      const auto& values = input.values;
      const double push = is_torque ? 0 : std::hypot(values[0], values[1]);
      for (const BodyReport& body : bodies) {
        if (body.id != input.body || !(body.mass > 0)) continue;
        // The point of an impulse or force is in the frame of its body.
        const double c = std::cos(body.angle), s = std::sin(body.angle);
        const Point arm{c * values[2] - s * values[3], s * values[2] + c * values[3]};
        const double twist = std::fabs(is_torque ? values[0] : arm.x * values[1] - arm.y * values[0]);
        Thrown& thrown = thrown_[body.id];
        thrown.speed += push / body.mass * (lasts ? dt : 1);
        if (!(body.inertia > 0)) continue;
        thrown.spin += twist / body.inertia * (lasts ? dt : 1);
        thrown.speed += twist / std::sqrt(body.mass * body.inertia) * (lasts ? dt : 1);
      }
    }
    for (auto& [id, thrown] : thrown_) thrown.way += thrown.speed * dt;
  }
  /// Whether inputs alone bring a body beyond the place or speed that a scene may have, or half of it.
  bool some_are_out() const {
    return std::any_of(thrown_.begin(), thrown_.end(), [](const auto& each) {
      const Thrown& thrown = each.second;
      return thrown.way > 0.5 * limits::coordinate_max_m ||
             std::max(thrown.speed, thrown.spin) > 0.5 * limits::speed_max;
    });
  }

 private:
  struct Thrown {
    double speed = 0;  // m/s
    double spin = 0;   // rad/s
    double way = 0;    // m
  };
  const std::vector<engine::Input>& inputs_;
  std::size_t at_ = 0;
  std::map<std::uint32_t, Thrown> thrown_;  // [body id]
};

/// The number of constraint rows that act on each body, by id.
std::map<std::uint32_t, double> constraint_rows(const Scene& scene, const StateView& state) {
  std::map<std::uint32_t, double> rows;
  const auto for_values = [&](std::string_view name, std::size_t column, auto use) {
    const auto found = state.schema->find_table(name);
    if (!found) return;
    const TableSchema& table = state.schema->tables[*found];
    for (std::size_t row = 0; row < state.tables[*found].row_count; ++row) {
      std::uint32_t value = 0;
      std::memcpy(&value, state.tables[*found].data + row * table.row_size + table.columns[column].offset,
                  sizeof value);
      use(value);
    }
  };
  for (const std::size_t column : {0u, 2u})  // body_a and body_b; two points, each with a normal and a tangent row
    for_values("contacts", column, [&](std::uint32_t id) { rows[id] += 4; });
  for_values("joints", 0, [&](std::uint32_t joint) {
    engine::for_each_body(scene, scene.joints[joint], [&](std::uint32_t body) { rows[body] += 6; });
  });
  return rows;
}

constexpr double thesis_static_mass_kg = 1999;  // engine/solvers/impulse.cpp: 2000, minus the rounding of f32

double epsilon_of(engine::Precision precision) {
  return precision == engine::Precision::f32 ? double{std::numeric_limits<float>::epsilon()}
                                             : std::numeric_limits<double>::epsilon();
}

double substeps_max(const Scene& scene) {
  return scene.settings.auto_substeps ? scene.settings.auto_substeps->substeps_max : scene.settings.substeps;
}

/// Largest velocity inside a tick, at least 1 m/s. The velocity that separates overlapping bodies is removed at the end
/// of the substep, and is only visible in the displacement. Impulses on one body may also cancel each other.
double speed_inside(const Scene& scene, const tool::Bodies& before, const tool::Bodies& after) {
  double way = 0;
  for (std::size_t i = 0; i < before.size() && i < after.size(); ++i)
    way = std::max(way, std::hypot(after[i].center.x - before[i].center.x, after[i].center.y - before[i].center.y));
  return std::max({1.0, tool::fastest(before), tool::fastest(after), way * substeps_max(scene) / scene.settings.dt});
}

/// The impulses of joints on each body in a substep, N s, by id. Torques of limits and motors are counted as forces.
/// Joints that contradict each other have large impulses which cancel: no velocity at the end of a tick shows them.
std::map<std::uint32_t, double> joint_impulses(const Scene& scene, const StateView& state) {
  std::map<std::uint32_t, double> impulses;
  const tool::NamedTable joints(state, "joints");
  for (std::uint32_t row = 0; row < joints.row_count(); ++row) {
    double force = std::hypot(joints.value(row, "linear_force", 0), joints.value(row, "linear_force", 1));
    for (const char* column : {"spring_force", "lower_force", "upper_force", "motor_force"})
      force += std::fabs(joints.value(row, column));
    engine::for_each_body(scene, scene.joints[joints.whole(row, "joint")], [&](std::uint32_t body) {
      impulses[body] += force * scene.settings.dt / scene.settings.substeps;
    });
  }
  return impulses;
}

double momentum_bound(const Scene& scene, const StateView& state, const tool::Bodies& before,
                      const tool::Bodies& after) {
  const double speed = speed_inside(scene, before, after);
  auto impulses = joint_impulses(scene, state);
  const double passes =
      scene.settings.solver == engine::SolverKind::pgs ? scene.settings.iterations : 4 * substeps_max(scene);
  const auto rows = constraint_rows(scene, state);
  // A solver without contacts in the state may resolve each body against every other body.
  const engine::SolverInfo& solver = info_of(engine::solvers, scene.settings.solver);
  const bool has_unseen = solver.solves_constraints && !solver.reads_contacts && !after.empty();
  const double rows_unseen = has_unseen ? static_cast<double>(after.size() - 1) : 0;
  double sum = 0;
  for (const BodyReport& body : after) {
    const auto found = rows.find(body.id);
    const double changes = passes * (1 + static_cast<double>(rows_unseen) + (found == rows.end() ? 0 : found->second));
    sum += std::max(body.mass * speed, impulses[body.id]) * changes * 3 * epsilon_of(scene.settings.precision);
  }
  return sum;
}

std::string cause_of(const Scene& scene, const BaseRun& base) {
  const auto has = [&](const char* table) {
    return std::find(base.tables_with_rows.begin(), base.tables_with_rows.end(), table) != base.tables_with_rows.end();
  };
  return std::string(info_of(engine::solvers, scene.settings.solver).name) + " " +
         std::string(info_of(engine::integrators, scene.settings.integrator).name) +
         (has("joints")     ? " with joints"
          : has("contacts") ? " with contacts"
                            : " free");
}

}  // namespace

std::optional<SoakCase> in_free_space(const SoakCase& soak_case) {
  std::vector<std::size_t> dynamic;
  for (std::size_t i = 0; i < soak_case.scene.bodies.size(); ++i)
    if (soak_case.scene.bodies[i].type == BodyType::dynamic_body) dynamic.push_back(i);
  if (dynamic.size() < 2) return std::nullopt;
  SoakCase space = with_bodies(soak_case, dynamic);
  std::vector<std::size_t> joints;
  for (std::size_t i = 0; i < space.scene.joints.size(); ++i)
    if (engine::traits_of(space.scene.joints[i].kind).conserves_momentum) joints.push_back(i);
  space = with_joints(space, joints);
  space.inputs.clear();
  Scene& scene = space.scene;
  scene.forces.clear();
  scene.gravity = {};
  scene.bounds.reset();
  scene.settings.sleep.reset();
  for (Body& body : scene.bodies) body.linear_damping = 0;
  if (!check_scene(scene, "free space")) return std::nullopt;
  return space;
}

std::optional<Finding> check_momentum(const RunContext& context, const BaseRun& base) {
  const auto space = in_free_space(context.soak_case);
  if (!space) return std::nullopt;
  const auto made = context.make(space->scene, {});
  if (!made) return std::nullopt;
  engine::Engine& engine = **made;
  const Variant variant{CheckKind::momentum};
  const CaseInputs no_inputs(*space);
  tool::Bodies before = engine.bodies();
  // The solver `impulse` treats a heavy body as static, so a body that hits the heavy body loses momentum.
  const bool is_heavy = std::any_of(before.begin(), before.end(),
                                    [](const BodyReport& body) { return body.mass >= thesis_static_mass_kg; });
  if (is_heavy && space->scene.settings.solver == engine::SolverKind::impulse) return std::nullopt;
  for (std::uint64_t tick = 0; tick < base.tick_count; ++tick) {
    if (auto failed = step_tick(engine, no_inputs.at(tick), tick, variant)) {
      if (failed->is_beyond) return std::nullopt;  // a tick that exceeds the limits ends the world, and is no fault
      return failed;
    }
    if (find_non_finite(engine.state())) return std::nullopt;  // check `finite` examines another world
    tool::Bodies after = engine.bodies();
    const Point p = tool::momentum_of(before), q = tool::momentum_of(after);
    const double change = std::max(std::abs(q.x - p.x), std::abs(q.y - p.y));
    const double bound = momentum_bound(space->scene, engine.state(), before, after);
    if (!(change <= bound)) {
      Finding finding;
      finding.variant = variant;
      finding.tick = tick;
      finding.what = "momentum in free space changes by " + tool::full_number(change) +
                     " N s in a tick: expected at most " + tool::full_number(bound);
      return finding;
    }
    before = std::move(after);
  }
  return std::nullopt;
}

PhysicsCounts count_physics(const RunContext& context, const BaseRun& base) {
  PhysicsCounts counts;
  const Scene& scene = context.soak_case.scene;
  counts.cause = cause_of(scene, base);
  counts.is_judged = promises_accuracy(scene.settings);
  const auto made = context.make(scene, {});
  if (!made) return counts;
  engine::Engine& engine = **made;
  const bool must_stay =
      counts.is_judged && !has_driven_slide(scene, engine.bodies()) && !has_boundless_force(scene, engine.bodies());
  counts.broken[4] = base.joints_failed && must_stay;
  const std::string end = " at tick " + std::to_string(base.tick_count);
  if (counts.broken[4]) counts.texts.push_back("a value is not finite" + end);
  const bool is_closed = is_undriven(context.soak_case);
  double lowest = std::numeric_limits<double>::infinity();
  double lowest_explained = lowest;  // with the energy that joints store, without the work of pushes that stay
  double kinetic = 0;
  double pushed = 0;  // J, the work of pushes that stay
  std::optional<ConstraintLaw> law;
  if (counts.is_judged) law.emplace(scene);
  ThrownBodies thrown(context.soak_case);
  for (std::uint64_t tick = 0; tick < base.tick_count; ++tick) {
    const TickInput input = context.inputs.at(tick);
    if (base.ran_away && must_stay) thrown.add_tick(engine.bodies(), tick, input.dt);
    if (step_tick(engine, input, tick, {})) break;
    if (law) law->look(engine, input.dt);
    if (is_closed && scene.settings.solver == engine::SolverKind::pgs)
      pushed += work_of_pushes(engine, engine.bodies(), input.dt);
    if (tick % sample_ticks != sample_ticks - 1) continue;
    const tool::Bodies bodies = engine.bodies();
    const double energy = tool::energy_of(scene, bodies);
    kinetic = std::max(kinetic, tool::kinetic_energy(bodies));
    const double explained = energy + (law ? law->stored_energy() : 0) - pushed;
    lowest = std::min(lowest, energy);
    lowest_explained = std::min(lowest_explained, explained);
    const double allowed = energy_rise_max * kinetic + rounding_of_energy(scene, bodies);
    if (counts.broken[0] || !is_closed || !(energy > lowest + allowed)) continue;
    if (!(explained > lowest_explained + allowed)) continue;  // joints give back what stretched them
    counts.broken[0] = true;
    counts.texts.push_back("energy rises by " + tool::short_number(energy - lowest) + " J until tick " +
                           std::to_string(tick) + ": expected at most " + tool::short_number(allowed));
  }
  if (base.ran_away && must_stay)  // the tick in which it does is not among those of the base run
    thrown.add_tick(engine.bodies(), base.tick_count, context.inputs.at(base.tick_count).dt);
  counts.broken[3] = base.ran_away && must_stay && !thrown.some_are_out();
  if (counts.broken[3]) counts.texts.insert(counts.texts.begin(), "a body runs away" + end);
  if (!law) return counts;
  counts.broken[1] = law->gap().has_value();
  counts.broken[2] = law->overlap().has_value();
  if (law->gap()) counts.texts.push_back(gap_text(*law->gap()));
  if (law->overlap()) counts.texts.push_back(overlap_text(*law->overlap()));
  return counts;
}

}  // namespace ticktrue::soak
