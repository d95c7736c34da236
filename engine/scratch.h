// Scratch: what one tick works with and forgets, and what it may keep. Derived from Model and State alone; never
// hashed, never saved.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/limits.h"
#include "base/parallel.h"
#include "engine/broad_phase/sorting.h"
#include "engine/constraints/contact_batch.h"
#include "engine/constraints/hinge_batch.h"
#include "engine/constraints/impacts.h"
#include "engine/constraints/joint.h"
#include "engine/constraints/joint_plan.h"
#include "engine/constraints/pin_batch.h"
#include "engine/constraints/pointer.h"
#include "engine/constraints/solver_kernels.h"
#include "engine/input.h"
#include "engine/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// One convex shape of one body in the world. In (body row, child) order, so that comparing indices compares shape ids.
/// Shapes that can meet nothing in their scene have none.
struct Proxy {
  std::uint32_t body;   // row in State::bodies
  std::uint32_t shape;  // in Model::shapes
  std::uint32_t child;  // index in the body
  bool is_dynamic;
  bool is_static;
  bool is_sensor;
  bool is_line;
  Filter filter;
};

/// Two proxies that may touch, first < second.
struct Pair {
  std::uint32_t first;
  std::uint32_t second;
};

/// Boxes over runs of sorted proxies, and boxes over runs of those, up to one. Level 0 is the proxies themselves.
struct BoxTree {
  std::vector<Box> boxes;                  // [level_start[level] + node]
  std::vector<std::uint32_t> proxies;      // [node of level 0]
  std::vector<std::uint32_t> level_start;  // [level]; one more at the end: the number of boxes
};

/// What aabb_tree keeps: boxes that are too large on purpose, and which of them overlap. As long as every shape is
/// inside its large box, the pairs that may touch are among these.
struct KeptPairs {
  bool is_valid = false;
  Real dt = 0;                  // s, for which `boxes` hold
  Real fall = 0;                // m, likewise
  Real farthest = 0;            // m, likewise
  std::vector<BodyRow> bodies;  // as the boxes below were made
  std::vector<std::uint8_t>
      is_still;  // [body] its pose (where contacts are foreseen: all of it) has the bits of the tick before
  std::vector<std::uint32_t> first_proxy;  // [body], one more at the end
  std::vector<Proxy> proxies;
  std::vector<Box> boxes;              // [proxy] m, hold the shapes with their margins
  std::vector<Box> large_boxes;        // [proxy]
  std::vector<Pair> pairs;             // of large boxes that overlap, by (first, second)
  std::vector<Pair> merged;            // the rows that replace them
  std::vector<std::uint8_t> is_stray;  // [proxy] has left the large box that is in the tree; 2: in this tick
  std::vector<std::uint32_t> strays;
  std::vector<std::uint32_t> leaving;  // proxies that are not inside their large boxes
  bool has_pairs = false;              // `pairs`, large boxes and trees are those of these proxies
  std::uint32_t ticks_held = 0;        // since they were built
  std::uint32_t restless_ticks = 0;    // for so many no pairs are kept
  Real common_side = 0;                // m, of their boxes (neighbour_cells.h)
  BoxTree moving_tree;
  BoxTree static_tree;
};

struct ManifoldPoint {
  Vec2 anchor_a;    // from A's centre of mass, world axes, m
  Vec2 anchor_b;    // from B's centre of mass, m
  Real separation;  // m, < 0 overlaps
  std::uint32_t feature;
};

struct Manifold {
  Vec2 normal;  // from A to B
  int point_count = 0;
  ManifoldPoint points[2];
};

/// A pair that touches, or will soon. Parallel to State::contacts where the pipeline has that table.
struct TouchingPair {
  std::uint32_t body_a;  // row
  std::uint32_t body_b;  // row
  Real friction;
  Real restitution;
  Real size;      // of the smaller shape, m
  Real radius_a;  // of round shapes, m: what turns with the body is the middle, not the surface
  Real radius_b;
  Real tangent_speed;       // m/s, of B's surface seen from A's where the bodies rest, along right_turn(normal)
  Real rolling_resistance;  // m: torque per normal force
  Manifold manifold;
};

/// The hot record of a body: one cache line holds two in f32. Solvers gather it, eight at a time.
struct alignas(8 * sizeof(Real)) MovingBody {
  Vec2 velocity;                         // m/s
  Real angular_velocity;                 // rad/s
  alignas(4 * sizeof(Real)) Vec2 moved;  // since the tick began, m
  Rotation turned;                       // since the tick began
};
static_assert(sizeof(MovingBody) == body_record_length * sizeof(Real));

/// What constraints need of a body beside its hot record.
struct BodyMass {
  Real inv_mass;        // 1/kg
  Real inv_inertia;     // 1/(kg m^2)
  std::uint32_t read;   // in Scratch::bodies; of static bodies the resting record
  std::uint32_t write;  // of bodies that impulses do not move the record nobody reads
};

/// A bit to flip in a hot record after a substep.
enum class BodyField : std::uint8_t { position, rotation, velocity, angular_velocity };
struct PlantedFault {
  std::size_t row = 0;
  BodyField field = BodyField::velocity;
  std::size_t lane = 0;
  std::uint32_t bit = 0;
  int substep = 0;
};

/// How velocities change over one step of a given length, without constraints: v' = decay * v + gain * acceleration.
/// Exact for constant acceleration and linear damping.
struct FreeMotion {
  Real linear_decay;
  Real linear_gain;  // s
  Real angular_decay;
  Real angular_gain;  // s
};

/// A linear and an angular part: of an acceleration, or of a change of velocity.
struct Twist {
  Vec2 linear;       // m/s^2 or m/s
  Real angular = 0;  // rad/s^2 or rad/s
};

/// What a scheme with several stages keeps of a body during a substep.
struct StageRow {
  MovingBody start;
  Twist velocities;     // sum over the stages so far, with their weights
  Twist accelerations;  // likewise
};

/// A spring of this tick, with the rows of its bodies. Records at rest stand for the world.
struct SpringRow {
  std::uint32_t body_a;   // record of scratch.bodies
  std::uint32_t body_b;   // record, read
  std::uint32_t write_b;  // record, written
  Vec2 offset;            // from A's centre of mass to B's (or the point of the world) when the tick began, m
  Vec2 arm_a;             // from A's centre of mass when the tick began, world axes, m
  Vec2 arm_b;
  Real inv_mass_a, inv_mass_b;        // 1/kg
  Real inv_inertia_a, inv_inertia_b;  // 1/(kg m^2)
  Real stiffness, damping, rest_length;
};

/// One spring in the linearised equations of implicit_midpoint.
struct SpringBlock {
  std::uint32_t body_a;
  std::uint32_t body_b;
  Vec2 along;
  Vec2 arm_a, arm_b;    // m
  Real stiff_along;     // kg
  Real stiff_across;    // kg
  Real turn_a, turn_b;  // kg m^2
};

/// FreeMotion with the accelerations of one body put in, for one substep: v' = decay * v + gain.
struct alignas(8 * sizeof(Real)) VelocityStep {
  Real gain[4];   // x, y in m/s, angular in rad/s, 0
  Real decay[4];  // x, y, angular, 0
};
static_assert(sizeof(VelocityStep) == body_record_length * sizeof(Real));

/// How far an island is from what its scene allows.
struct Shortfall {
  Real sag;    // at the most substeps, of what is allowed
  Real depth;  // steps from what cannot move to what is farthest from it
};

/// A contact or joint by which a body may be carried.
struct Support {
  std::uint32_t other;  // row
  Real softness;        // m/N at four substeps
  Real arm, other_arm;  // of a joint, from the two centres of mass, m; of a contact 0
  Vec2 middle;          // of a contact, or a joint's anchor, from the body's centre of mass, m
  Real half_width2;     // of a contact with two points, m^2; else 0
  Real turn_softness;   // of what holds the angle, rad/(N m) at four substeps; else 0
};

/// How far a body leans with what carries it.
struct Lean {
  Vec2 way;   // m
  Real turn;  // rad
};

/// What ticks keep for the next one. Each part says of itself for what it holds, so that a tick gives the same bits
/// with it, without it, and with that of any other run of the same model (docs/decisions/0014).
struct Kept {
  KeptPairs pairs;
  std::vector<TouchingPair> touching;  // of the tick before, row by row those of State::contacts
  bool has_touching = false;           // and no contact, body or margin has changed since
  JointPlan joints;
};

/// Makes the next tick build everything anew.
inline void forget(Kept& kept) {
  kept.pairs.is_valid = false;
  kept.has_touching = false;
  kept.joints.is_of_scene = false;
}

inline constexpr std::uint32_t no_group = 0xffffffff;

/// Islands solved together, with the same number of substeps. Ranges of Scratch::group_rows, group_contacts and
/// ContactBatches::batches and ::runs.
struct SolveGroup {
  int substeps = 1;
  bool has_landings = false;
  std::uint32_t joint_sweeps = 1;  // over its joints before bodies move
  Real h = 0;                      // s, of a substep
  ContactStiffness stiffness;
  std::uint32_t first_row = 0, row_end = 0;
  std::uint32_t first_contact = 0, contact_end = 0;
  std::uint32_t first_batch = 0, batch_end = 0;
  std::uint32_t first_run = 0, run_end = 0;
};

/// A contact that hits a body at rest in this tick.
struct Landing {
  std::uint32_t contact;  // in `touching`
  Real closing;           // m/s, before the pass
  Real allowed;           // m, how far the bodies may move meanwhile
};

/// A contact point that pushes, or holds by friction, as a row J of the velocities of its two bodies.
struct PushingRow {
  std::uint32_t batch, lane, point;  // where its impulse is
  std::uint32_t body_a, body_b;      // rows
  std::uint32_t read_a, read_b;      // records
  std::uint32_t place_a, place_b;    // in ImpulseStep::bodies, or no_body
  double along_a[3], along_b[3];     // x, y, angular
  double off;                        // J v less what is wanted, m/s
  double stiffness;                  // kg
  double impulse, change;            // N s
  double friction;                   // coefficient
  bool is_friction;                  // with the row before as its normal
};

/// All contacts of a group that push, solved at once.
struct ImpulseStep {
  std::vector<PushingRow> rows;
  std::vector<double> whole;              // [row] changes before they are cut
  std::vector<std::uint32_t> start;       // [body] in `neighbours`
  std::vector<std::uint32_t> neighbours;  // bodies
  std::vector<std::uint8_t> is_start;     // [body] touches something immovable
  std::vector<std::uint32_t> place;       // [body] in `bodies`, or no_body
  std::vector<std::uint32_t> bodies;
  std::vector<std::uint32_t> first;    // [unknown] column of the first entry of its row
  std::vector<std::size_t> row_start;  // [unknown] in `matrix`
  std::vector<double> matrix;
  std::vector<double> velocity, total;  // [unknown]
};

/// Where a range of pairs is sorted.
struct PairSorter {
  std::vector<Pair> pairs;
  std::vector<Pair> by_second;
  std::vector<std::uint32_t> start;  // [proxy]
};

/// Where a box in the order of cells comes from.
struct SweptPlace {
  std::uint32_t proxy;
  std::uint32_t cell;
};

/// The cells of the uniform grid that a proxy's box overlaps, both ends included.
struct CellRange {
  std::int32_t first_x;
  std::int32_t first_y;
  std::int32_t last_x;
  std::int32_t last_y;
};

/// A proxy in one cell.
struct CellEntry {
  std::int32_t x;
  std::int32_t y;
  std::uint32_t proxy;
};

/// Where a proxy is in this tick.
struct Circle {
  Vec2 center;  // world, m
  Real radius;  // with margin, m
};

/// What a chunk has added to a list.
struct ListPart {
  std::size_t first;  // where it wrote
  std::size_t room;   // there; the rest is elsewhere
  std::size_t count;
  std::size_t place;  // in the list
};

/// The most that a joint's force turns its bodies with, N m.
struct JointTorques {
  Real a;
  Real b;
};

/// The first and the last joint that moves a body: in the plan's places, before they are sorted.
struct JointEnds {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
  std::uint32_t count = 0;  // of its joints
};

struct Scratch {
  Kept kept;
  Parallel parallel;                                    // the engine's
  std::size_t pair_count_max = limits::pair_count_max;  // likewise

  // Lists made in chunks are written where the chunk's part of the range begins, then put together.
  std::vector<std::uint32_t> part_counts;  // [chunk]
  std::vector<ListPart> parts;             // [chunk]

  // inputs
  std::vector<Input> inputs;
  std::vector<Vec2> force;   // [body] N, from this tick's inputs; empty if there are none
  std::vector<Real> torque;  // [body] N m

  // broad_phase
  std::span<const Proxy> proxies;  // those of `kept`, or the rows below
  std::vector<Proxy> proxy_rows;
  std::vector<Box> boxes;           // [proxy] m, hold the shapes with their margins; not filled by aabb_tree
  std::vector<Circle> circles;      // [proxy], bounding_circle
  std::vector<Pair> pairs;          // by (first, second)
  bool has_too_many_pairs = false;  // more than pair_count_max boxes overlap: none are listed, the tick cannot be done
  std::vector<Pair> unsorted_pairs;
  std::vector<std::vector<Pair>> pair_parts;  // [chunk] aabb_tree, neighbour_cells
  std::vector<PairSorter> pair_sorters;       // [part]
  std::vector<std::uint32_t> counts;
  std::vector<SortEntry> sort_entries;  // sweep_and_prune, aabb_tree
  std::vector<SortEntry> sort_buffer;
  std::vector<Box> swept_boxes;            // sweep_and_prune: in sweep order; neighbour_cells: by cell
  std::vector<SweptPlace> swept_places;    // neighbour_cells: whose boxes those are
  std::vector<CellRange> cell_ranges;      // uniform_grid, [proxy]
  std::vector<CellEntry> cell_entries;     // uniform_grid, by bucket, dynamic ones first
  std::vector<std::uint32_t> cell_starts;  // uniform_grid, [bucket]; neighbour_cells, [cell]
  std::vector<std::uint32_t> large;        // uniform_grid, neighbour_cells: proxies in no cell, ascending

  // narrow_phase
  std::vector<TouchingPair> touching;
  std::vector<ContactRow> contacts;          // the rows that replace State::contacts
  std::vector<TouchingPair> touching_apart;  // where chunks write what does not fit, and to where all are moved
  std::vector<TouchingPair> touching_moved;
  std::vector<ContactRow> contacts_apart;
  std::vector<ContactRow> contacts_moved;

  // impacts
  std::vector<ImpactPair> impacts;                    // that may come in this tick
  std::vector<std::vector<ImpactPair>> impact_parts;  // [chunk]
  std::vector<std::uint8_t> is_fast;                  // [body] may pass through something in this tick
  std::vector<ImpactPath> paths;                      // [body], of those in `impacts`
  std::vector<std::uint32_t> hit_rows;                // in the present substep
  std::vector<std::uint32_t> active_impacts;          // those of the group that is being solved
  std::vector<ImpactEvent> impact_events;             // a heap, earliest first
  std::vector<std::uint32_t> impact_starts;           // [body] in impacts_of_bodies
  std::vector<std::uint32_t> impacts_of_bodies;
  bool offsets_in_use = false;  // the integrator fills velocity_offsets

  // islands
  std::vector<SolveGroup> groups;              // ascending by substeps; sleeping islands are in none
  std::span<const std::uint32_t> moving_rows;  // of the group that is being solved
  std::uint32_t group_index = 0;               // of that group
  std::vector<std::uint8_t> is_tied;           // [body] something touches it in this tick, or may
  std::vector<std::uint32_t> loose_rows;       // of the group that is being solved
  std::vector<std::uint32_t> group_rows;       // bodies that move, of each group; kinematic ones are in all of them
  std::vector<std::uint32_t> group_contacts;   // in `touching`
  std::vector<std::uint32_t> group_keys;       // [body] islands: what decides its group
  std::vector<std::uint32_t> body_group;       // [body] index in `groups`; no_group: asleep or static
  std::vector<BodyType> body_types;            // [body] islands
  std::vector<std::uint32_t> island_parent;    // [body] union-find
  std::vector<std::uint32_t> island_level;     // [body] at the island's first row: substeps
  std::vector<std::uint8_t> island_awake;      // [body] at the island's first row
  std::vector<std::uint8_t> island_lands;      // [body] at the island's first row
  std::vector<Landing> landings;
  std::vector<Twist> landing_velocities;  // [body] before the last passes
  std::uint32_t landing_work_left = 0;    // in contacts that may still be solved for landings in this tick
  ImpulseStep impulse_step;
  std::vector<Support> supports;
  std::vector<std::uint32_t> support_start;  // [body] in `supports`
  std::vector<std::uint32_t> support_depth;  // [body] steps from what carries it
  std::vector<std::uint32_t> support_order;  // bodies by depth
  std::vector<Real> load;                    // [body] N
  std::vector<Real> pull;                    // [body] m/s^2, of the joints that it whirls at
  std::vector<Real> sag;                     // [body] m, expected at four substeps
  std::vector<Vec2> load_moment;             // [body] N m, load times where it is
  std::vector<Real> handed_down;             // [body] N, of what others have put on it
  std::vector<Lean> leans;                   // [body] expected at four substeps
  std::vector<Real> give;                    // [body] the same against what carries it alone, of the smaller of the two
  std::vector<Shortfall> shortfalls;         // [body] at the island's first row
  std::vector<Real> mass_factor;             // [body] how much heavier constraints see it; with automatic substeps

  // events
  std::vector<TouchRow> now_touching;      // the rows that replace State::touching, then State::sensors
  std::vector<TouchRow> removed_touching;  // rows of bodies that were removed in this tick
  std::vector<TouchRow> removed_sensors;
  std::vector<TouchRow> touch_buffer;

  // solver
  const SolverKernels* kernels = nullptr;  // the model's
  std::optional<PlantedFault> planted;     // for this tick
  std::vector<MovingBody> bodies;
  std::vector<BodyMass> masses;               // [body]
  std::vector<FreeMotion> free_motion;        // [source], for steps of free_motion_step
  Real free_motion_step = 0;                  // s; 0: not computed yet
  std::vector<VelocityStep> velocity_steps;   // [body]
  std::vector<Twist> constant_accelerations;  // [body] gravity, forces of this tick's inputs, constant elements
  std::vector<Twist> accelerations;           // [record] at the present stage
  std::vector<Twist> velocity_offsets;        // [body] velocity at the end of the substep, less the drift velocity
  std::vector<Twist> predicted;               // [body] velocity at the end of the substep, without constraints
  std::vector<Twist> previous_accelerations;  // [body] of the substep before; empty unless the integrator needs them
  std::vector<StageRow> stages;               // [body]
  std::vector<SpringRow> springs;             // [spring whose bodies are there]
  std::vector<std::uint32_t> central_rows;    // [central force] row of its one body, or no_reference
  std::vector<SpringBlock> spring_blocks;
  std::vector<Twist> newton[5];   // [record] diagonal, solution, residual, direction, product
  std::uint32_t unconverged = 0;  // substeps whose equations were not solved
  ContactBatches contact_batches;
  std::vector<PointerPull> pulls;
  std::vector<JointWork> joints;  // those of the group that are solved by themselves
  PinBatches pins;
  HingeBatches hinges;
  bool is_woven = false;  // the passes over the group's joints are
  std::vector<JointPlace> sorted_places;
  std::vector<JointEnds> joint_ends;        // [body]
  std::vector<std::uint32_t> body_levels;   // [body] level of the next joint that moves it
  std::vector<JointTorques> joint_torques;  // [place of the plan]
  std::vector<Real> body_torques;           // [body] the most that its joints' forces turn it with, N m
  std::vector<std::uint32_t> level_starts;  // [level and way] in the plan's places
};

/// Fills everything that a tick must not read before writing it with bytes that make wrong results loud (NaN, huge
/// indices). Builds with TICKTRUE_POISON call it before each tick.
void poison(Scratch& scratch);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
