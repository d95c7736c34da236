// State: everything that can influence a later tick, as packed rows with named columns.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "base/state/state_view.h"
#include "engine/model/model.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct WorldRow {
  std::uint64_t tick;            // ticks done
  double time;                   // s, sum of their dt
  Vec2 gravity;                  // m/s^2
  std::uint32_t next_id;         // id of the next body; no id is used twice
  std::uint32_t ignored_inputs;  // inputs to bodies that were already removed
};

struct BodyRow {
  std::uint32_t id;
  std::uint32_t source;  // in Model::bodies
  Vec2 position;         // of the centre of mass, world, m
  Rotation rotation;
  Vec2 velocity;          // of the centre of mass, m/s
  Real angular_velocity;  // rad/s
};
inline bool is_moving(const BodyRow& body) {
  return body.velocity.x != 0 || body.velocity.y != 0 || body.angular_velocity != 0;
}

/// A contact of two children (convex shapes of bodies), with its forces for warm starting. The row exists if and only
/// if the narrow phase found a point within the speculative margin. Rows ascend by (body_a, child_a, body_b, child_b).
struct ContactRow {
  std::uint32_t body_a;   // id, the smaller one
  std::uint32_t child_a;  // index of the shape in its body
  std::uint32_t body_b;   // id
  std::uint32_t child_b;
  std::uint32_t feature[2];  // per point; no_feature if there is no second point
  Real normal_force[2];      // N, mean over the last substep
  Real tangent_force[2];     // N
};
inline constexpr std::uint32_t no_feature = 0xffffffff;

/// Two children that touch. Rows ascend by all four.
struct TouchRow {
  std::uint32_t body_a;   // id; of a contact the smaller one, of an overlap the sensor's
  std::uint32_t child_a;  // index of the shape in its body
  std::uint32_t body_b;   // id; of an overlap the visitor's
  std::uint32_t child_b;
};

enum class EventKind : std::uint32_t { contact_begin, contact_end, sensor_begin, sensor_end };
inline constexpr std::uint32_t event_kind_count = 4;

/// A contact or overlap that began or ended in this tick. Rows ascend by (kind, touch); its bodies may no longer exist.
struct EventRow {
  std::uint32_t kind;  // EventKind
  TouchRow touch;
};

/// A pointer that holds a body: the state of a mouse joint.
struct PointerRow {
  std::uint32_t player;
  std::uint32_t body;  // id
  Vec2 anchor;         // the held point, in the body's frame, from its centre of mass, m
  Vec2 target;         // the pointer, world, m
  Vec2 force;          // N, of the last substep, for warm starting
};

/// A joint of the scene, while its bodies exist.
struct JointRow {
  std::uint32_t joint;   // index in Scene::joints
  std::uint32_t kind;    // JointKind
  std::uint32_t body_a;  // id; no_reference: the world
  std::uint32_t body_b;  // id
  Real motor_speed;      // m/s or rad/s, of B relative to A
  Real motor_force_max;  // N or N m
  Vec2 linear_force;     // N, mean over the last substep, as the others; joints/joint_*.cpp list the forces of a kind
  Real torque;           // N m
  Real spring_force;     // N or N m
  Real lower_force;
  Real upper_force;
  Real motor_force;
};

/// The coordinates of the two joints of a gear: angles with all turns, so that a gear stays in mesh for many turns.
/// Parallel to the gears of State::joints.
struct GearRow {
  Real coordinate_a;  // rad or m
  Real coordinate_b;
};

/// The idle time of a body. Parallel to the bodies.
struct SleepRow {
  std::uint32_t body;    // id
  std::uint32_t asleep;  // 1: its island sleeps
  Real calm;             // s
};

/// Substeps of the body's island. Parallel to the bodies.
struct SubstepRow {
  std::uint32_t body;        // id
  std::uint32_t count;       // substeps per tick
  std::uint32_t idle_ticks;  // for which fewer would have been enough
};

/// The substeps that the measured loads of the last tick need, with SubstepLoads::measured. Parallel to the bodies.
struct LoadRow {
  std::uint32_t body;    // id
  std::uint32_t wanted;  // substeps; 0 before the first tick
  Real calm;             // s, for which the body has hardly moved; an island is held after one second
};

inline constexpr double saved_work_max = 0x1p53;

/// The ticks that Settings::substep_budget has changed so far, and the work that it has saved.
struct BudgetRow {
  std::uint32_t cut_ticks;      // ticks in which a shock was left before it had settled
  std::uint32_t limited_ticks;  // ticks in which an island had fewer substeps than its loads need
  std::uint64_t saved_work;     // contacts that past ticks might have solved for resting impacts
};

/// Accelerations of a body in the last substep, for thesis_verlet. Parallel to the bodies.
struct AccelerationRow {
  Vec2 linear;   // m/s^2
  Real angular;  // rad/s^2
};

/// Statistics of implicit integrators.
struct IntegratorRow {
  std::uint32_t unconverged;  // substeps whose equations were not solved to the tolerance
};

static_assert(sizeof(WorldRow) == 24 + 2 * sizeof(Real));
static_assert(sizeof(BodyRow) == 8 + 7 * sizeof(Real));
static_assert(sizeof(ContactRow) == 24 + 4 * sizeof(Real));
static_assert(sizeof(TouchRow) == 16);
static_assert(sizeof(EventRow) == 20);
static_assert(sizeof(PointerRow) == 8 + 6 * sizeof(Real));
static_assert(sizeof(JointRow) == 16 + 9 * sizeof(Real));
static_assert(sizeof(GearRow) == 2 * sizeof(Real));
static_assert(sizeof(SleepRow) == 8 + sizeof(Real));
static_assert(sizeof(SubstepRow) == 12);
static_assert(sizeof(LoadRow) == 8 + sizeof(Real));
static_assert(sizeof(BudgetRow) == 16);
static_assert(sizeof(AccelerationRow) == 3 * sizeof(Real));
static_assert(sizeof(IntegratorRow) == 4);

/// The tables that a pipeline owns.
struct StateTables {
  bool world = true;
  bool bodies = true;
  bool contacts = false;
  bool pointers = false;
  bool touching = false;
  bool sensors = false;
  bool events = false;
  bool joints = false;
  bool gears = false;
  bool sleep = false;
  bool substeps = false;
  bool loads = false;
  bool budget = false;
  bool accelerations = false;
  bool integrator = false;
};
struct State {
  WorldRow world{};
  std::vector<BodyRow> bodies;  // ascending by id
  std::vector<ContactRow> contacts;
  std::vector<PointerRow> pointers;  // ascending by player
  std::vector<TouchRow> touching;    // contacts with a point of no or negative separation
  std::vector<TouchRow> sensors;     // overlaps with sensors
  std::vector<EventRow> events;      // of this tick
  std::vector<JointRow> joints;      // ascending by joint
  std::vector<GearRow> gears;        // of `joints`, in their order
  std::vector<SleepRow> sleep;       // [body], or empty
  std::vector<SubstepRow> substeps;  // [body], or empty
  std::vector<LoadRow> loads;        // [body], or empty
  BudgetRow budget{};
  std::vector<AccelerationRow> accelerations;  // [body], or empty
  IntegratorRow integrator{};

  /// Index of the body's row, or bodies.size().
  std::size_t find_body(std::uint32_t id) const;

  /// Wakes the body's island.
  void wake(std::size_t row) {
    if (!sleep.empty()) sleep[row].calm = 0;
    if (!loads.empty()) loads[row].calm = 0;
  }
};

/// The list of tables, in the order of the schema: calls visit(name, rows) for each owned table. `rows` is a vector of
/// `state`, or its one row.
template <typename StateType, typename Visit>
void for_each_table(StateType& state, const StateTables& owned, Visit visit) {
  if (owned.world) visit("world", state.world);
  if (owned.bodies) visit("bodies", state.bodies);
  if (owned.contacts) visit("contacts", state.contacts);
  if (owned.pointers) visit("pointers", state.pointers);
  if (owned.touching) visit("touching", state.touching);
  if (owned.sensors) visit("sensors", state.sensors);
  if (owned.events) visit("events", state.events);
  if (owned.joints) visit("joints", state.joints);
  if (owned.gears) visit("gears", state.gears);
  if (owned.sleep) visit("sleep", state.sleep);
  if (owned.substeps) visit("substeps", state.substeps);
  if (owned.loads) visit("loads", state.loads);
  if (owned.budget) visit("budget", state.budget);
  if (owned.accelerations) visit("accelerations", state.accelerations);
  if (owned.integrator) visit("integrator", state.integrator);
}

/// Whether the model's integrator stores accelerations in the state.
inline bool keeps_accelerations(const Model& model) {
  return model.scene.settings.integrator == IntegratorKind::thesis_verlet;
}
StateSchema make_schema(const Model& model, StateTables tables);

/// Points `view` at the rows of `state`. `view.schema` must be set.
void update_view(const State& state, StateTables tables, StateView& view);

/// Replaces `state` by an image. Errors: corrupt; `state` is then unchanged.
Status load_state(const Model& model, const StateSchema& schema, StateTables tables, ByteView image, State& state);

State initial_state(const Model& model);

/// Appends a body and its rows in the tables that are parallel to the bodies. Requires: an id above all others.
void add_body_row(const Model& model, State& state, const BodyRow& body);
/// Erases a body and its rows in these tables. The caller removes other rows that refer to the body.
void erase_body_row(State& state, std::size_t row);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
