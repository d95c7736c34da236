// Scenes in binary: one writer and one reader, side by side.
// SPDX-License-Identifier: MIT
#include "engine/scene_binary.h"

#include <string>

#include "base/limits.h"

namespace ticktrue::engine {
namespace {

// Version of this encoding alone. docs/engine_setup.md says what each byte means.
constexpr std::uint16_t encoding_version = 1;

// Smallest sizes, in bytes, of what is repeated: a count that could not fit is refused before memory is reserved.
constexpr std::size_t point_size = 16;
constexpr std::size_t shape_size_min = 1 + 3 * 8 + 8;
constexpr std::size_t body_size_min = 4 + 1 + 9 * 8 + 1 + 1 + 4;
constexpr std::size_t text_size_min = 4;

class SceneWriter {
 public:
  Bytes write(const Scene& scene) {
    const Settings& settings = scene.settings;
    out_.u16(encoding_version);
    out_.text(scene.name);
    kind(settings.precision);
    out_.f64(settings.dt);
    out_.i32(settings.substeps);
    kind(settings.solver);
    kind(settings.integrator);
    kind(settings.broad_phase);
    kind(settings.friction_mix);
    kind(settings.restitution_mix);
    out_.f64(settings.restitution_threshold);
    point(scene.gravity);
    count(scene.bodies.size());
    for (const Body& body : scene.bodies) write(body);
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
    switch (shape.kind) {
      case ShapeKind::circle:
        point(shape.center);
        out_.f64(shape.radius);
        break;
      case ShapeKind::box:
        point(shape.center);
        out_.f64(shape.angle);
        point(shape.half_size);
        break;
      case ShapeKind::polygon:
        count(shape.vertices.size());
        for (const Point& vertex : shape.vertices) point(vertex);
        break;
    }
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

/// Reads what SceneWriter writes. The first thing that is wrong is kept; after it, reads give zeros and lists end.
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
    settings.solver = kind<SolverKind>(solvers.size());
    settings.integrator = kind<IntegratorKind>(integrators.size());
    settings.broad_phase = kind<BroadPhaseKind>(broad_phases.size());
    settings.friction_mix = kind<MixRule>(mix_rules.size());
    settings.restitution_mix = kind<MixRule>(mix_rules.size());
    settings.restitution_threshold = in_.f64();
    scene.gravity = point();
    scene.bodies.resize(count(limits::body_count_max, body_size_min));
    for (Body& body : scene.bodies) read(body);
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
    switch (shape.kind) {
      case ShapeKind::circle:
        shape.center = point();
        shape.radius = in_.f64();
        break;
      case ShapeKind::box:
        shape.center = point();
        shape.angle = in_.f64();
        shape.half_size = point();
        break;
      case ShapeKind::polygon:
        shape.vertices.resize(count(limits::polygon_vertex_count_max, point_size));
        for (Point& vertex : shape.vertices) vertex = point();
        break;
    }
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
