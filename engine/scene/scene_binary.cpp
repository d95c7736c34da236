// Scenes in binary: one writer and one reader, side by side.
// SPDX-License-Identifier: MIT
#include "engine/scene/scene_binary.h"

#include <string>

#include "base/limits.h"

namespace ticktrue::engine {
namespace {

// Version of this encoding alone. docs/engine_setup.md says what each byte means.
constexpr std::uint16_t encoding_version = 2;

// Smallest sizes, in bytes, of what is repeated: a count that could not fit is refused before memory is reserved.
constexpr std::size_t point_size = 16;
constexpr std::size_t shape_size_min = 1 + 5 * 8 + 3 * 4 + 1 + 8;
constexpr std::size_t body_size_min = 4 + 1 + 9 * 8 + 3 + 1 + 4;
constexpr std::size_t text_size_min = 4;
constexpr std::size_t joint_size_min = 4 + 1 + 2 * 4 + 3 * 16 + 2 * 8 + 4 + 16 + 3 * 8 + 1;
constexpr std::size_t force_size_min = 4 + 1 + 2 + 3 * 16 + 7 * 8;

/// Fields of joints up to `collide_connected` are stored for every kind, later ones for the kinds that have them.
bool is_stored(JointKind kind, JointField field) {
  return field <= JointField::collide_connected || has_field(kind, field);
}

class SceneWriter {
 public:
  Bytes write(const Scene& scene) {
    const Settings& settings = scene.settings;
    out_.u16(encoding_version);
    out_.text(scene.name);
    kind(settings.precision);
    out_.f64(settings.dt);
    out_.i32(settings.substeps);
    flag(settings.auto_substeps.has_value());
    if (settings.auto_substeps) {
      out_.f64(settings.auto_substeps->target_error);
      out_.i32(settings.auto_substeps->substeps_max);
    }
    out_.i32(settings.iterations);
    kind(settings.solver);
    kind(settings.integrator);
    kind(settings.broad_phase);
    kind(settings.friction_mix);
    kind(settings.restitution_mix);
    out_.f64(settings.restitution_threshold);
    flag(settings.locate_impacts);
    flag(settings.continuous);
    flag(settings.sleep.has_value());
    if (settings.sleep) {
      out_.f64(settings.sleep->after_s);
      out_.f64(settings.sleep->speed_max);
    }
    flag(settings.events);
    kind(settings.clock.kind);
    out_.i32(settings.clock.ticks_per_frame_max);
    out_.f64(settings.clock.tolerance);
    out_.f64(settings.clock.dt_min);
    out_.f64(settings.clock.dt_max);
    point(scene.gravity);
    count(scene.bodies.size());
    for (const Body& body : scene.bodies) write(body);
    count(scene.joints.size());
    for (const Joint& joint : scene.joints) write(joint);
    count(scene.forces.size());
    for (const Force& force : scene.forces) write(force);
    count(scene.prototypes.size());
    for (const Body& body : scene.prototypes) write(body);
    count(scene.inputs.size());
    for (const InputKind input : scene.inputs) kind(input);
    flag(scene.pointer.has_value());
    if (scene.pointer) write(*scene.pointer);
    flag(scene.bounds.has_value());
    if (scene.bounds) write(*scene.bounds);
    flag(scene.spawned_max.has_value());
    if (scene.spawned_max) out_.u32(*scene.spawned_max);
    return out_.take();
  }

 private:
  template <typename Kind>
  void kind(Kind value) {
    out_.u8(static_cast<std::uint8_t>(value));
  }
  void flag(bool value) { out_.u8(value ? 1 : 0); }
  void count(std::size_t value) { out_.u32(static_cast<std::uint32_t>(value)); }
  void point(const Point& value) {
    out_.f64(value.x);
    out_.f64(value.y);
  }

  void write(const Body& body) {
    out_.text(body.name);
    kind(body.type);
    point(body.position);
    out_.f64(body.angle);
    point(body.velocity);
    out_.f64(body.angular_velocity);
    out_.f64(body.linear_damping);
    out_.f64(body.angular_damping);
    out_.f64(body.gravity_scale);
    flag(body.fixed_rotation);
    flag(body.bullet);
    flag(body.can_sleep);
    flag(body.mass.has_value());
    if (body.mass) {
      out_.f64(body.mass->mass);
      flag(body.mass->inertia.has_value());
      if (body.mass->inertia) out_.f64(*body.mass->inertia);
      flag(body.mass->center.has_value());
      if (body.mass->center) point(*body.mass->center);
    }
    count(body.shapes.size());
    for (const Shape& shape : body.shapes) write(shape);
  }

  void write(const Shape& shape) {
    kind(shape.kind);
    out_.f64(shape.density);
    out_.f64(shape.material.friction);
    out_.f64(shape.material.restitution);
    out_.f64(shape.material.tangent_speed);
    out_.f64(shape.material.rolling_resistance);
    out_.u32(shape.filter.category);
    out_.u32(shape.filter.mask);
    out_.i32(shape.filter.group);
    flag(shape.sensor);
    switch (shape.kind) {
      case ShapeKind::circle:
        point(shape.center);
        out_.f64(shape.radius);
        break;
      case ShapeKind::box:
        point(shape.center);
        out_.f64(shape.angle);
        point(shape.half_size);
        out_.f64(shape.radius);
        break;
      case ShapeKind::polygon:
      case ShapeKind::capsule:
        vertices(shape);
        out_.f64(shape.radius);
        break;
      case ShapeKind::segment:
        vertices(shape);
        break;
      case ShapeKind::chain:
        vertices(shape);
        flag(shape.loop);
        break;
    }
  }

  void vertices(const Shape& shape) {
    count(shape.vertices.size());
    for (const Point& vertex : shape.vertices) point(vertex);
  }

  void write(const JointSpring& spring) {
    flag(spring.absolute);
    out_.f64(spring.absolute ? spring.stiffness : spring.hertz);
    out_.f64(spring.absolute ? spring.damping : spring.damping_ratio);
  }

  void write(const Joint& joint) {
    out_.text(joint.name);
    kind(joint.kind);
    for_each_joint_field([&](JointField field, const char*, auto member, const FieldRange&) {
      if (is_stored(joint.kind, field)) write(joint.*member);
    });
  }
  void write(std::uint32_t value) { out_.u32(value); }
  void write(double value) { out_.f64(value); }
  void write(bool value) { flag(value); }
  void write(const Point& value) { point(value); }
  void write(const Range& range) {
    out_.f64(range.lower);
    out_.f64(range.upper);
  }
  void write(const JointMotor& motor) {
    out_.f64(motor.speed);
    out_.f64(motor.force_max);
  }
  template <typename Value>
  void write(const std::optional<Value>& value) {
    flag(value.has_value());
    if (value) write(*value);
  }

  void write(const Force& force) {
    out_.text(force.name);
    kind(force.kind);
    flag(force.body.has_value());
    if (force.body) out_.u32(*force.body);
    flag(force.other.has_value());
    if (force.other) out_.u32(*force.other);
    point(force.anchor);
    point(force.point);
    point(force.vector);
    out_.f64(force.torque);
    out_.f64(force.coefficient);
    out_.f64(force.angular_coefficient);
    out_.f64(force.exponent);
    out_.f64(force.stiffness);
    out_.f64(force.damping);
    out_.f64(force.rest_length);
  }

  void write(const PointerSettings& pointer) {
    count(pointer.spawns.size());
    for (const std::string& name : pointer.spawns) out_.text(name);
    out_.f64(pointer.hertz);
    out_.f64(pointer.damping_ratio);
    out_.f64(pointer.force_max_per_kg);
    flag(pointer.window.has_value());
    if (pointer.window) write(*pointer.window);
  }

  void write(const Bounds& bounds) {
    point(bounds.lower);
    point(bounds.upper);
  }

  ByteWriter out_;
};

/// Reads what SceneWriter writes. Stores the first error; after it, reads give zeros and lists end.
class SceneReader {
 public:
  explicit SceneReader(ByteView bytes) : in_(bytes) {}

  Result<Scene> read() {
    const std::uint16_t version = in_.u16();
    if (in_.ok() && version != encoding_version)
      return Error{ErrorCode::incompatible,
                   "setup: unknown encoding of the scene: found version " + std::to_string(version) + ", expected " +
                       std::to_string(encoding_version),
                   "use a newer ticktrue"};
    Scene scene;
    Settings& settings = scene.settings;
    scene.name = in_.text(limits::name_size_max);
    settings.precision = kind<Precision>(precisions.size());
    settings.dt = in_.f64();
    settings.substeps = in_.i32();
    if (flag()) {
      AutoSubsteps& automatic = settings.auto_substeps.emplace();
      automatic.target_error = in_.f64();
      automatic.substeps_max = in_.i32();
    }
    settings.iterations = in_.i32();
    settings.solver = kind<SolverKind>(solvers.size());
    settings.integrator = kind<IntegratorKind>(integrators.size());
    settings.broad_phase = kind<BroadPhaseKind>(broad_phases.size());
    settings.friction_mix = kind<MixRule>(mix_rules.size());
    settings.restitution_mix = kind<MixRule>(mix_rules.size());
    settings.restitution_threshold = in_.f64();
    settings.locate_impacts = flag();
    settings.continuous = flag();
    if (flag()) {
      SleepSettings& sleep = settings.sleep.emplace();
      sleep.after_s = in_.f64();
      sleep.speed_max = in_.f64();
    }
    settings.events = flag();
    settings.clock.kind = kind<ClockKind>(clock_kinds.size());
    settings.clock.ticks_per_frame_max = in_.i32();
    settings.clock.tolerance = in_.f64();
    settings.clock.dt_min = in_.f64();
    settings.clock.dt_max = in_.f64();
    scene.gravity = point();
    scene.bodies.resize(count(limits::body_count_max, body_size_min));
    for (Body& body : scene.bodies) read(body);
    scene.joints.resize(count(limits::joint_count_max, joint_size_min));
    for (Joint& joint : scene.joints) read(joint);
    scene.forces.resize(count(limits::force_count_max, force_size_min));
    for (Force& force : scene.forces) read(force);
    scene.prototypes.resize(count(limits::prototype_count_max, body_size_min));
    for (Body& body : scene.prototypes) read(body);
    scene.inputs.resize(count(input_kinds.size(), 1));
    for (InputKind& input : scene.inputs) input = kind<InputKind>(input_kinds.size());
    if (flag()) read(scene.pointer.emplace());
    if (flag()) read(scene.bounds.emplace());
    if (flag()) scene.spawned_max = in_.u32();

    if (!limit_message_.empty()) return Error{ErrorCode::limit, limit_message_, ""};
    if (!in_.ok())
      return Error{ErrorCode::corrupt, "setup: the scene in it cannot be read: it ends early or holds an unknown value",
                   ""};
    if (!in_.at_end())
      return Error{ErrorCode::corrupt,
                   "setup: bytes left over after the scene: found " + std::to_string(in_.remaining()) + ", expected 0",
                   ""};
    if (Status status = check_scene(scene, "setup"); !status) return status.error();
    return scene;
  }

 private:
  template <typename Kind>
  Kind kind(std::size_t row_count) {
    const std::uint8_t value = in_.u8();
    if (value < row_count) return static_cast<Kind>(value);
    in_.fail();
    return Kind{};
  }
  bool flag() {
    const std::uint8_t value = in_.u8();
    if (value > 1) in_.fail();
    return in_.ok() && value == 1;
  }
  /// Zero, and a failed reader, where so many cannot be.
  std::size_t count(std::size_t max, std::size_t size_min) {
    const std::uint32_t value = in_.u32();
    if (value > max && limit_message_.empty() && in_.ok())
      limit_message_ = "setup: offset " + std::to_string(in_.offset()) + ": too many: found " + std::to_string(value) +
                       ", expected at most " + std::to_string(max);
    if (value > max || value > in_.remaining() / size_min) in_.fail();
    return in_.ok() ? value : 0;
  }
  Point point() {
    Point value;
    value.x = in_.f64();
    value.y = in_.f64();
    return value;
  }

  void read(Body& body) {
    body.name = in_.text(limits::name_size_max);
    body.type = kind<BodyType>(body_types.size());
    body.position = point();
    body.angle = in_.f64();
    body.velocity = point();
    body.angular_velocity = in_.f64();
    body.linear_damping = in_.f64();
    body.angular_damping = in_.f64();
    body.gravity_scale = in_.f64();
    body.fixed_rotation = flag();
    body.bullet = flag();
    body.can_sleep = flag();
    if (flag()) {
      ExplicitMass& mass = body.mass.emplace();
      mass.mass = in_.f64();
      if (flag()) mass.inertia = in_.f64();
      if (flag()) mass.center = point();
    }
    body.shapes.resize(count(limits::shape_count_per_body_max, shape_size_min));
    for (Shape& shape : body.shapes) read(shape);
  }

  void read(Shape& shape) {
    shape.kind = kind<ShapeKind>(shape_kinds.size());
    shape.density = in_.f64();
    shape.material.friction = in_.f64();
    shape.material.restitution = in_.f64();
    shape.material.tangent_speed = in_.f64();
    shape.material.rolling_resistance = in_.f64();
    shape.filter.category = in_.u32();
    shape.filter.mask = in_.u32();
    shape.filter.group = in_.i32();
    shape.sensor = flag();
    switch (shape.kind) {
      case ShapeKind::circle:
        shape.center = point();
        shape.radius = in_.f64();
        break;
      case ShapeKind::box:
        shape.center = point();
        shape.angle = in_.f64();
        shape.half_size = point();
        shape.radius = in_.f64();
        break;
      case ShapeKind::polygon:
      case ShapeKind::capsule:
        read_vertices(shape, limits::polygon_vertex_count_max);
        shape.radius = in_.f64();
        break;
      case ShapeKind::segment:
        read_vertices(shape, limits::polygon_vertex_count_max);
        break;
      case ShapeKind::chain:
        read_vertices(shape, limits::chain_vertex_count_max);
        shape.loop = flag();
        break;
    }
  }

  void read_vertices(Shape& shape, std::size_t max) {
    shape.vertices.resize(count(max, point_size));
    for (Point& vertex : shape.vertices) vertex = point();
  }

  void read(JointSpring& spring) {
    spring.absolute = flag();
    (spring.absolute ? spring.stiffness : spring.hertz) = in_.f64();
    (spring.absolute ? spring.damping : spring.damping_ratio) = in_.f64();
  }

  void read(Joint& joint) {
    joint.name = in_.text(limits::name_size_max);
    joint.kind = kind<JointKind>(joint_kinds.size());
    for_each_joint_field([&](JointField field, const char*, auto member, const FieldRange&) {
      if (is_stored(joint.kind, field)) read(joint.*member);
    });
  }
  void read(std::uint32_t& value) { value = in_.u32(); }
  void read(double& value) { value = in_.f64(); }
  void read(bool& value) { value = flag(); }
  void read(Point& value) { value = point(); }
  void read(Range& range) {
    range.lower = in_.f64();
    range.upper = in_.f64();
  }
  void read(JointMotor& motor) {
    motor.speed = in_.f64();
    motor.force_max = in_.f64();
  }
  template <typename Value>
  void read(std::optional<Value>& value) {
    if (flag()) read(value.emplace());
  }

  void read(Force& force) {
    force.name = in_.text(limits::name_size_max);
    force.kind = kind<ForceKind>(force_kinds.size());
    if (flag()) force.body = in_.u32();
    if (flag()) force.other = in_.u32();
    force.anchor = point();
    force.point = point();
    force.vector = point();
    force.torque = in_.f64();
    force.coefficient = in_.f64();
    force.angular_coefficient = in_.f64();
    force.exponent = in_.f64();
    force.stiffness = in_.f64();
    force.damping = in_.f64();
    force.rest_length = in_.f64();
  }

  void read(PointerSettings& pointer) {
    pointer.spawns.resize(count(limits::prototype_count_max, text_size_min));
    for (std::string& name : pointer.spawns) name = in_.text(limits::name_size_max);
    pointer.hertz = in_.f64();
    pointer.damping_ratio = in_.f64();
    pointer.force_max_per_kg = in_.f64();
    if (flag()) read(pointer.window.emplace());
  }

  void read(Bounds& bounds) {
    bounds.lower = point();
    bounds.upper = point();
  }

  ByteReader in_;
  std::string limit_message_;
};

}  // namespace

Bytes encode_scene(const Scene& scene) {
  return SceneWriter().write(scene);
}

Result<Scene> decode_scene(ByteView bytes) {
  if (bytes.size() > limits::setup_size_max)
    return Error{ErrorCode::limit,
                 "setup: too large: found " + std::to_string(bytes.size()) + " bytes, expected at most " +
                     std::to_string(limits::setup_size_max),
                 ""};
  return SceneReader(bytes).read();
}

}  // namespace ticktrue::engine
