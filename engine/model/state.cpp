// The schema of the state, its image, and the first state of a scene.
// SPDX-License-Identifier: MIT
#include "engine/model/state.h"

#include <cstddef>
#include <limits>

#include "base/limits.h"
#include "engine/math/trig.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr ScalarType real_type = sizeof(Real) == 4 ? ScalarType::f32 : ScalarType::f64;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double id_max = no_reference - 1.0;

Column real(const char* name, std::size_t lane_count, std::size_t offset, double min = -infinity,
            double max = infinity) {
  return {name, real_type, static_cast<std::uint8_t>(lane_count), static_cast<std::uint16_t>(offset), min, max};
}
Column whole(const char* name, ScalarType type, std::size_t lane_count, std::size_t offset, double max,
             int target = -1) {
  return {name, type, static_cast<std::uint8_t>(lane_count), static_cast<std::uint16_t>(offset),
          0,    max,  static_cast<std::int16_t>(target)};
}

Column optional_reference(const char* name, std::size_t offset, int target) {
  Column column = whole(name, ScalarType::u32, 1, offset, id_max, target);
  column.optional = true;
  return column;
}

constexpr std::size_t body_table = 1;

// Rows of a table, which may be a single one.
template <typename Row>
TableRows rows_of(const Row& row) {
  return {reinterpret_cast<const std::uint8_t*>(&row), 1};
}
template <typename Row>
TableRows rows_of(const std::vector<Row>& rows) {
  return {reinterpret_cast<const std::uint8_t*>(rows.data()), static_cast<std::uint32_t>(rows.size())};
}
template <typename Row>
bool load_rows(const TableSchema& table, const ImageTable& image, Row& row) {
  if (image.row_count != 1) return false;
  decode_rows(table, image, reinterpret_cast<std::uint8_t*>(&row));
  return true;
}
template <typename Row>
bool load_rows(const TableSchema& table, const ImageTable& image, std::vector<Row>& rows) {
  rows.resize(image.row_count);
  decode_rows(table, image, reinterpret_cast<std::uint8_t*>(rows.data()));
  return true;
}

/// Whether a table has one row for each body, in their order.
template <typename Row>
bool is_parallel(const std::vector<Row>& rows, const std::vector<BodyRow>& bodies) {
  if (rows.size() != bodies.size()) return false;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].body != bodies[i].id) return false;
  return true;
}

Error image_error(const std::string& what) {
  return {ErrorCode::corrupt, "state image: " + what, ""};
}

/// Checks that the state has a row for each joint of the scene whose bodies exist, and no other row.
Status check_joints(const Model& model, const State& state) {
  std::size_t row = 0;
  std::size_t gear_count = 0;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const JointModel& joint = model.joints[i];
    bool has_bodies = true;
    for_each_body(model, joint,
                  [&](std::uint32_t id) { has_bodies = has_bodies && state.find_body(id) < state.bodies.size(); });
    if (!has_bodies) continue;
    gear_count += joint.gear != no_gear ? 1u : 0u;
    const bool same = row < state.joints.size() && state.joints[row].joint == i &&
                      state.joints[row].kind == static_cast<std::uint32_t>(joint.kind) &&
                      state.joints[row].body_a == joint.body_a && state.joints[row].body_b == joint.body_b;
    if (!same) return image_error("joints[" + std::to_string(row) + "]: is not joint " + std::to_string(i));
    ++row;
  }
  if (row != state.joints.size())
    return image_error("joints: found " + std::to_string(state.joints.size()) + ", expected " + std::to_string(row));
  if (gear_count != state.gears.size())
    return image_error("gears: found " + std::to_string(state.gears.size()) + ", expected " +
                       std::to_string(gear_count));
  return {};
}

/// The largest child index of the model, at least that of a body without chains. Scenes without chains then have equal
/// schemas.
double child_max(const Model& model) {
  const std::size_t count = model.child_count_max;
  return static_cast<double>(count > limits::shape_count_per_body_max ? count : limits::shape_count_per_body_max) - 1;
}

// The columns of each table; the type of its rows chooses.

TableSchema schema_of(const Model&, const std::string& name, const WorldRow&) {
  return {name,
          {
              whole("tick", ScalarType::u64, 1, offsetof(WorldRow, tick), static_cast<double>(limits::tick_count_max)),
              {"time", ScalarType::f64, 1, offsetof(WorldRow, time), 0, infinity},
              real("gravity", 2, offsetof(WorldRow, gravity)),
              whole("next_id", ScalarType::u32, 1, offsetof(WorldRow, next_id), id_max),
              whole("ignored_inputs", ScalarType::u32, 1, offsetof(WorldRow, ignored_inputs), no_reference),
          },
          sizeof(WorldRow),
          0};
}

TableSchema schema_of(const Model& model, const std::string& name, const std::vector<BodyRow>&) {
  return {name,
          {
              whole("id", ScalarType::u32, 1, offsetof(BodyRow, id), id_max),
              whole("source", ScalarType::u32, 1, offsetof(BodyRow, source),
                    static_cast<double>(model.bodies.empty() ? 0 : model.bodies.size() - 1)),
              real("position", 2, offsetof(BodyRow, position)),
              real("rotation", 2, offsetof(BodyRow, rotation), -2, 2),
              real("velocity", 2, offsetof(BodyRow, velocity)),
              real("angular_velocity", 1, offsetof(BodyRow, angular_velocity)),
          },
          sizeof(BodyRow),
          1};
}

TableSchema schema_of(const Model& model, const std::string& name, const std::vector<ContactRow>&) {
  return {name,
          {
              whole("body_a", ScalarType::u32, 1, offsetof(ContactRow, body_a), id_max, body_table),
              whole("child_a", ScalarType::u32, 1, offsetof(ContactRow, child_a), child_max(model)),
              whole("body_b", ScalarType::u32, 1, offsetof(ContactRow, body_b), id_max, body_table),
              whole("child_b", ScalarType::u32, 1, offsetof(ContactRow, child_b), child_max(model)),
              whole("feature", ScalarType::u32, 2, offsetof(ContactRow, feature), no_feature),
              real("normal_force", 2, offsetof(ContactRow, normal_force), 0),
              real("tangent_force", 2, offsetof(ContactRow, tangent_force)),
          },
          sizeof(ContactRow),
          4};
}

TableSchema schema_of(const Model&, const std::string& name, const std::vector<PointerRow>&) {
  return {name,
          {
              whole("player", ScalarType::u32, 1, offsetof(PointerRow, player), limits::player_count_max - 1),
              whole("body", ScalarType::u32, 1, offsetof(PointerRow, body), id_max, body_table),
              real("anchor", 2, offsetof(PointerRow, anchor)),
              real("target", 2, offsetof(PointerRow, target)),
              real("force", 2, offsetof(PointerRow, force)),
          },
          sizeof(PointerRow),
          1};
}

TableSchema schema_of(const Model& model, const std::string& name, const std::vector<TouchRow>&) {
  const bool of_sensors = name == "sensors";
  return {
      name,
      {
          whole(of_sensors ? "sensor" : "body_a", ScalarType::u32, 1, offsetof(TouchRow, body_a), id_max, body_table),
          whole(of_sensors ? "sensor_child" : "child_a", ScalarType::u32, 1, offsetof(TouchRow, child_a),
                child_max(model)),
          whole(of_sensors ? "visitor" : "body_b", ScalarType::u32, 1, offsetof(TouchRow, body_b), id_max, body_table),
          whole(of_sensors ? "visitor_child" : "child_b", ScalarType::u32, 1, offsetof(TouchRow, child_b),
                child_max(model)),
      },
      sizeof(TouchRow),
      4};
}

TableSchema schema_of(const Model& model, const std::string& name, const std::vector<EventRow>&) {
  constexpr std::size_t touch = offsetof(EventRow, touch);
  return {name,
          {
              whole("kind", ScalarType::u32, 1, offsetof(EventRow, kind), event_kind_count - 1),
              whole("body_a", ScalarType::u32, 1, touch + offsetof(TouchRow, body_a), id_max),
              whole("child_a", ScalarType::u32, 1, touch + offsetof(TouchRow, child_a), child_max(model)),
              whole("body_b", ScalarType::u32, 1, touch + offsetof(TouchRow, body_b), id_max),
              whole("child_b", ScalarType::u32, 1, touch + offsetof(TouchRow, child_b), child_max(model)),
          },
          sizeof(EventRow),
          5};
}

TableSchema schema_of(const Model& model, const std::string& name, const std::vector<JointRow>&) {
  return {name,
          {
              whole("joint", ScalarType::u32, 1, offsetof(JointRow, joint),
                    static_cast<double>(model.joints.empty() ? 0 : model.joints.size() - 1)),
              whole("kind", ScalarType::u32, 1, offsetof(JointRow, kind), joint_kinds.size() - 1.0),
              optional_reference("body_a", offsetof(JointRow, body_a), body_table),
              whole("body_b", ScalarType::u32, 1, offsetof(JointRow, body_b), id_max, body_table),
              real("motor_speed", 1, offsetof(JointRow, motor_speed)),
              real("motor_force_max", 1, offsetof(JointRow, motor_force_max), 0),
              real("linear_force", 2, offsetof(JointRow, linear_force)),
              real("torque", 1, offsetof(JointRow, torque)),
              real("spring_force", 1, offsetof(JointRow, spring_force)),
              real("lower_force", 1, offsetof(JointRow, lower_force), 0),
              real("upper_force", 1, offsetof(JointRow, upper_force), 0),
              real("motor_force", 1, offsetof(JointRow, motor_force)),
          },
          sizeof(JointRow),
          1};
}

TableSchema schema_of(const Model&, const std::string& name, const std::vector<GearRow>&) {
  return {name,
          {
              real("coordinate_a", 1, offsetof(GearRow, coordinate_a)),
              real("coordinate_b", 1, offsetof(GearRow, coordinate_b)),
          },
          sizeof(GearRow),
          0};
}

TableSchema schema_of(const Model&, const std::string& name, const std::vector<SleepRow>&) {
  return {name,
          {
              whole("body", ScalarType::u32, 1, offsetof(SleepRow, body), id_max, body_table),
              whole("asleep", ScalarType::u32, 1, offsetof(SleepRow, asleep), 1),
              real("calm", 1, offsetof(SleepRow, calm), 0),
          },
          sizeof(SleepRow),
          1};
}

TableSchema schema_of(const Model&, const std::string& name, const std::vector<LoadRow>&) {
  return {name,
          {
              whole("body", ScalarType::u32, 1, offsetof(LoadRow, body), id_max, body_table),
              whole("wanted", ScalarType::u32, 1, offsetof(LoadRow, wanted), limits::substep_count_max),
              real("calm", 1, offsetof(LoadRow, calm), 0),
          },
          sizeof(LoadRow),
          1};
}

TableSchema schema_of(const Model&, const std::string& name, const BudgetRow&) {
  return {name,
          {
              whole("cut_ticks", ScalarType::u32, 1, offsetof(BudgetRow, cut_ticks), no_reference),
              whole("limited_ticks", ScalarType::u32, 1, offsetof(BudgetRow, limited_ticks), no_reference),
              whole("saved_work", ScalarType::u64, 1, offsetof(BudgetRow, saved_work), saved_work_max),
          },
          sizeof(BudgetRow),
          0};
}

TableSchema schema_of(const Model&, const std::string& name, const std::vector<SubstepRow>&) {
  return {name,
          {
              whole("body", ScalarType::u32, 1, offsetof(SubstepRow, body), id_max, body_table),
              {"count", ScalarType::u32, 1, offsetof(SubstepRow, count), 1, limits::substep_count_max},
              whole("calm_ticks", ScalarType::u32, 1, offsetof(SubstepRow, idle_ticks), limits::substep_count_max),
          },
          sizeof(SubstepRow),
          1};
}

TableSchema schema_of(const Model&, const std::string& name, const std::vector<AccelerationRow>&) {
  return {name,
          {
              real("linear", 2, offsetof(AccelerationRow, linear)),
              real("angular", 1, offsetof(AccelerationRow, angular)),
          },
          sizeof(AccelerationRow),
          0};
}

TableSchema schema_of(const Model&, const std::string& name, const IntegratorRow&) {
  return {name,
          {whole("unconverged", ScalarType::u32, 1, offsetof(IntegratorRow, unconverged), no_reference)},
          sizeof(IntegratorRow),
          0};
}

/// Whether the bodies of a row, which exist, have the row's children.
bool has_children(const Model& model, const State& state, const TouchRow& row) {
  const BodyModel& a = model.bodies[state.bodies[state.find_body(row.body_a)].source];
  const BodyModel& b = model.bodies[state.bodies[state.find_body(row.body_b)].source];
  return row.child_a < a.shape_count && row.child_b < b.shape_count;
}

}  // namespace

std::size_t State::find_body(std::uint32_t id) const {
  if (bodies.empty() || id > bodies.back().id) return bodies.size();
  // A body's row is its id less the number of missing ids below. The search covers as many rows as bodies were removed.
  const std::size_t missing = bodies.back().id + std::size_t{1} - bodies.size();
  std::size_t low = id > missing ? id - missing : 0;
  std::size_t high = id + std::size_t{1} < bodies.size() ? id + std::size_t{1} : bodies.size();
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (bodies[middle].id < id)
      low = middle + 1;
    else
      high = middle;
  }
  return low < bodies.size() && bodies[low].id == id ? low : bodies.size();
}

StateSchema make_schema(const Model& model, StateTables tables) {
  StateSchema schema;
  const State unset;
  for_each_table(unset, tables,
                 [&](const char* name, const auto& rows) { schema.tables.push_back(schema_of(model, name, rows)); });
  const Status status = check_schema(schema);
  TICKTRUE_ASSERT(status.has_value());
  return schema;
}

void update_view(const State& state, StateTables tables, StateView& view) {
  view.tables.clear();
  for_each_table(state, tables, [&](const char*, const auto& rows) { view.tables.push_back(rows_of(rows)); });
}

Status load_state(const Model& model, const StateSchema& schema, StateTables tables, ByteView image, State& state) {
  const Result<std::vector<ImageTable>> parts = check_image(schema, image);
  if (!parts) return parts.error();
  State loaded;
  Status status;
  std::size_t table = 0;
  for_each_table(loaded, tables, [&](const char* name, auto& rows) {
    const ImageTable& part = (*parts)[table];
    if (!load_rows(schema.tables[table], part, rows) && status)
      status = image_error(std::string("table ") + name + ": rows: found " + std::to_string(part.row_count) +
                           ", expected 1");
    ++table;
  });
  if (!status) return status;
  if (tables.accelerations && loaded.accelerations.size() != loaded.bodies.size())
    return image_error("table accelerations: rows: found " + std::to_string(loaded.accelerations.size()) +
                       ", expected one for each of the " + std::to_string(loaded.bodies.size()) + " bodies");

  if (loaded.bodies.size() > limits::body_count_max) return image_error("table bodies: too many rows");
  if (!loaded.bodies.empty() && loaded.bodies.back().id >= loaded.world.next_id)
    return image_error("world[0].next_id: found " + std::to_string(loaded.world.next_id) +
                       ", expected more than the last body's id " + std::to_string(loaded.bodies.back().id));
  for (const BodyRow& body : loaded.bodies) {
    const Real norm = body.rotation.c * body.rotation.c + body.rotation.s * body.rotation.s;
    if (!(norm > Real(0.5) && norm < Real(2)))
      return image_error("bodies: id " + std::to_string(body.id) + ": rotation is no rotation");
  }
  for (std::size_t row = 0; row < loaded.contacts.size(); ++row) {
    const ContactRow& contact = loaded.contacts[row];
    const BodyModel& a = model.bodies[loaded.bodies[loaded.find_body(contact.body_a)].source];
    const BodyModel& b = model.bodies[loaded.bodies[loaded.find_body(contact.body_b)].source];
    if (contact.body_a >= contact.body_b || contact.child_a >= a.shape_count || contact.child_b >= b.shape_count)
      return image_error("contacts[" + std::to_string(row) + "]: names a shape that its body has not");
  }
  for (const TouchRow& row : loaded.touching)
    if (row.body_a >= row.body_b || !has_children(model, loaded, row))
      return image_error("touching: names a shape that its body has not");
  for (const TouchRow& row : loaded.sensors)
    if (row.body_a == row.body_b || !has_children(model, loaded, row))
      return image_error("sensors: names a shape that its body has not");
  for (const EventRow& row : loaded.events)
    if (row.touch.body_a >= loaded.world.next_id || row.touch.body_b >= loaded.world.next_id)
      return image_error("events: names a body that never was");
  for (const PointerRow& pointer : loaded.pointers)
    if (model.bodies[loaded.bodies[loaded.find_body(pointer.body)].source].type != BodyType::dynamic_body)
      return image_error("pointers: player " + std::to_string(pointer.player) + " holds a body that is not dynamic");
  if (tables.joints)
    if (const Status joints = check_joints(model, loaded); !joints) return joints;
  if ((tables.sleep && !is_parallel(loaded.sleep, loaded.bodies)) ||
      (tables.substeps && !is_parallel(loaded.substeps, loaded.bodies)) ||
      (tables.loads && !is_parallel(loaded.loads, loaded.bodies)))
    return image_error("sleep, substeps, loads: expected a row for each body, in order");
  state = std::move(loaded);
  return {};
}

State initial_state(const Model& model) {
  State state;
  const Scene& scene = model.scene;
  state.world.gravity = stored(Vec2{static_cast<Real>(scene.gravity.x), static_cast<Real>(scene.gravity.y)});
  state.world.next_id = static_cast<std::uint32_t>(scene.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const SinCos rotation = pose_sin_cos(body.angle);
    const double center_x = model.bodies[i].center.x;
    const double center_y = model.bodies[i].center.y;
    BodyRow row{};
    row.id = static_cast<std::uint32_t>(i);
    row.source = static_cast<std::uint32_t>(i);
    row.position = stored(Vec2{static_cast<Real>(body.position.x + rotation.cos * center_x - rotation.sin * center_y),
                               static_cast<Real>(body.position.y + rotation.sin * center_x + rotation.cos * center_y)});
    row.rotation = stored(Rotation{static_cast<Real>(rotation.cos), static_cast<Real>(rotation.sin)});
    if (body.type != BodyType::static_body) {
      row.velocity = stored(Vec2{static_cast<Real>(body.velocity.x), static_cast<Real>(body.velocity.y)});
      row.angular_velocity = stored(static_cast<Real>(body.angular_velocity));
    }
    add_body_row(model, state, row);
  }
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const JointModel& joint = model.joints[i];
    JointRow row{};
    row.joint = static_cast<std::uint32_t>(i);
    row.kind = static_cast<std::uint32_t>(joint.kind);
    row.body_a = joint.body_a;
    row.body_b = joint.body_b;
    row.motor_speed = stored(joint.motor_speed);
    row.motor_force_max = stored(joint.motor_force_max);
    state.joints.push_back(row);
    if (joint.gear == no_gear) continue;
    const GearModel& gear = model.gears[joint.gear];
    state.gears.push_back({stored(static_cast<Real>(gear.start[0])), stored(static_cast<Real>(gear.start[1]))});
  }
  return state;
}

void add_body_row(const Model& model, State& state, const BodyRow& body) {
  state.bodies.push_back(body);
  const Settings& settings = model.scene.settings;
  if (settings.sleep) state.sleep.push_back({body.id, 0, 0});
  if (keeps_accelerations(model)) state.accelerations.push_back({});
  if (settings.auto_substeps) state.substeps.push_back({body.id, static_cast<std::uint32_t>(settings.substeps), 0});
  if (settings.substep_loads == SubstepLoads::measured) state.loads.push_back({body.id, 0, 0});
}

void erase_body_row(State& state, std::size_t row) {
  const auto at = static_cast<std::ptrdiff_t>(row);
  state.bodies.erase(state.bodies.begin() + at);
  if (!state.accelerations.empty()) state.accelerations.erase(state.accelerations.begin() + at);
  if (!state.sleep.empty()) state.sleep.erase(state.sleep.begin() + at);
  if (!state.substeps.empty()) state.substeps.erase(state.substeps.begin() + at);
  if (!state.loads.empty()) state.loads.erase(state.loads.begin() + at);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
