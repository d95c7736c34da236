// Runs a scene in an installed Box2D 3 and answers as peer.mjs does: ticktrue_box2d3 SCENE.json | --version.
// SPDX-License-Identifier: MIT
//
// A program of its own, because the libraries of Box2D 2.4.1 and of Box2D 3 have the same name. It is built where CMake
// finds Box2D 3.2 or later. SCENE.json is what box2d3_scene.cpp writes, in units of Box2D. A scene that Box2D 3 cannot
// represent gives one line {"refused": why}. Exit code 1: anything else went wrong.
#include <box2d/box2d.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using nlohmann::json;

// Why Box2D 3 cannot represent a scene.
class Refused : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

b2Vec2 point_of(const json& pair) {
  return {pair.at(0).get<float>(), pair.at(1).get<float>()};
}

std::vector<b2Vec2> points_of(const json& list) {
  std::vector<b2Vec2> points;
  for (const json& each : list) points.push_back(point_of(each));
  return points;
}

using MixMaterials = float(float a, std::uint64_t id_a, float b, std::uint64_t id_b);

struct MixRow {
  const char* name;
  MixMaterials* mix;
};
constexpr MixRow mix_rows[]{
    {"sqrt", [](float a, std::uint64_t, float b, std::uint64_t) { return std::sqrt(a * b); }},
    {"max", [](float a, std::uint64_t, float b, std::uint64_t) { return std::max(a, b); }},
    {"min", [](float a, std::uint64_t, float b, std::uint64_t) { return std::min(a, b); }},
    {"average", [](float a, std::uint64_t, float b, std::uint64_t) { return (a + b) / 2; }},
};

MixMaterials* mix_named(const std::string& name) {
  for (const MixRow& row : mix_rows)
    if (name == row.name) return row.mix;
  throw std::runtime_error("unknown mix rule: found " + name);
}

b2SurfaceMaterial material_of(const json& shape) {
  b2SurfaceMaterial material = b2DefaultSurfaceMaterial();
  material.friction = shape.at("friction");
  material.restitution = shape.at("restitution");
  material.rollingResistance = shape.at("rolling_resistance");
  material.tangentSpeed = shape.at("tangent_speed");
  return material;
}

b2Filter filter_of(const json& shape) {
  b2Filter filter = b2DefaultFilter();
  filter.categoryBits = shape.at("category");
  filter.maskBits = shape.at("mask");
  filter.groupIndex = shape.at("group");
  return filter;
}

void add_chain(b2BodyId body, const json& shape) {
  const std::vector<b2Vec2> points = points_of(shape.at("points"));
  const b2SurfaceMaterial material = material_of(shape);
  b2ChainDef definition = b2DefaultChainDef();
  definition.points = points.data();
  definition.count = static_cast<int>(points.size());
  definition.materials = &material;
  definition.materialCount = 1;
  definition.filter = filter_of(shape);
  definition.isLoop = shape.at("loop");
  b2CreateChain(body, &definition);
}

void add_shape(b2BodyId body, const json& shape, const std::string& place) {
  const std::string kind = shape.at("kind");
  if (kind == "chain") return add_chain(body, shape);
  b2ShapeDef definition = b2DefaultShapeDef();
  definition.updateBodyMass = false;
  definition.material = material_of(shape);
  definition.filter = filter_of(shape);
  const float radius = shape.at("radius");
  if (kind == "circle") {
    const b2Circle circle{point_of(shape.at("center")), radius};
    b2CreateCircleShape(body, &definition, &circle);
  } else if (kind == "box") {
    const b2Vec2 half = point_of(shape.at("half_size"));
    const b2Polygon polygon = b2MakeOffsetRoundedBox(half.x, half.y, point_of(shape.at("center")),
                                                     b2MakeRot(shape.at("angle").get<float>()), radius);
    b2CreatePolygonShape(body, &definition, &polygon);
  } else if (kind == "capsule") {
    const b2Capsule capsule{point_of(shape.at("points").at(0)), point_of(shape.at("points").at(1)), radius};
    b2CreateCapsuleShape(body, &definition, &capsule);
  } else if (kind == "segment") {
    const b2Segment segment{point_of(shape.at("points").at(0)), point_of(shape.at("points").at(1))};
    b2CreateSegmentShape(body, &definition, &segment);
  } else if (kind == "polygon") {
    const std::vector<b2Vec2> points = points_of(shape.at("points"));
    const b2Hull hull = b2ComputeHull(points.data(), static_cast<int>(points.size()));
    if (hull.count != static_cast<int>(points.size()))
      throw Refused(place + "/vertices: Box2D 3 welds or drops some: found " + std::to_string(hull.count) +
                    " left, expected " + std::to_string(points.size()));
    const b2Polygon polygon = b2MakePolygon(&hull, radius);
    b2CreatePolygonShape(body, &definition, &polygon);
  } else {
    throw std::runtime_error(place + ": unknown shape: found " + kind);
  }
}

// ---- Joints ----

// The fields of a joint's definition. Every given field must be taken.
class JointFields {
 public:
  explicit JointFields(const json& fields) : fields_(fields) {}
  template <typename Value>
  void take(const char* name, Value& value) {
    const auto found = fields_.find(name);
    if (found == fields_.end()) return;
    value = found->template get<Value>();
    ++taken_count_;
  }
  void take_spring(auto& definition) {
    take("enableSpring", definition.enableSpring);
    take("hertz", definition.hertz);
    take("dampingRatio", definition.dampingRatio);
  }
  void take_motor(auto& definition) {
    take("enableLimit", definition.enableLimit);
    take("enableMotor", definition.enableMotor);
    take("motorSpeed", definition.motorSpeed);
  }
  bool all_taken() const { return taken_count_ == fields_.size(); }

 private:
  const json& fields_;
  std::size_t taken_count_ = 0;
};

using CreateJoint = void(b2WorldId world, const b2JointDef& base, JointFields& fields);

void add_revolute(b2WorldId world, const b2JointDef& base, JointFields& fields) {
  b2RevoluteJointDef definition = b2DefaultRevoluteJointDef();
  definition.base = base;
  fields.take_spring(definition);
  fields.take_motor(definition);
  fields.take("lowerAngle", definition.lowerAngle);
  fields.take("upperAngle", definition.upperAngle);
  fields.take("maxMotorTorque", definition.maxMotorTorque);
  b2CreateRevoluteJoint(world, &definition);
}

void add_prismatic(b2WorldId world, const b2JointDef& base, JointFields& fields) {
  b2PrismaticJointDef definition = b2DefaultPrismaticJointDef();
  definition.base = base;
  fields.take_spring(definition);
  fields.take_motor(definition);
  fields.take("lowerTranslation", definition.lowerTranslation);
  fields.take("upperTranslation", definition.upperTranslation);
  fields.take("maxMotorForce", definition.maxMotorForce);
  b2CreatePrismaticJoint(world, &definition);
}

void add_wheel(b2WorldId world, const b2JointDef& base, JointFields& fields) {
  b2WheelJointDef definition = b2DefaultWheelJointDef();
  definition.base = base;
  fields.take_spring(definition);
  fields.take_motor(definition);
  fields.take("lowerTranslation", definition.lowerTranslation);
  fields.take("upperTranslation", definition.upperTranslation);
  fields.take("maxMotorTorque", definition.maxMotorTorque);
  b2CreateWheelJoint(world, &definition);
}

void add_distance(b2WorldId world, const b2JointDef& base, JointFields& fields) {
  b2DistanceJointDef definition = b2DefaultDistanceJointDef();
  definition.base = base;
  fields.take_spring(definition);
  fields.take_motor(definition);
  fields.take("length", definition.length);
  fields.take("minLength", definition.minLength);
  fields.take("maxLength", definition.maxLength);
  fields.take("maxMotorForce", definition.maxMotorForce);
  b2CreateDistanceJoint(world, &definition);
}

void add_weld(b2WorldId world, const b2JointDef& base, JointFields& fields) {
  b2WeldJointDef definition = b2DefaultWeldJointDef();
  definition.base = base;
  fields.take("angularHertz", definition.angularHertz);
  fields.take("angularDampingRatio", definition.angularDampingRatio);
  fields.take("linearHertz", definition.linearHertz);
  fields.take("linearDampingRatio", definition.linearDampingRatio);
  b2CreateWeldJoint(world, &definition);
}

struct JointRow {
  const char* name;
  CreateJoint* create;
  b2JointDef (*base)();
};
constexpr JointRow joint_rows[]{
    {"revolute", add_revolute, [] { return b2DefaultRevoluteJointDef().base; }},
    {"prismatic", add_prismatic, [] { return b2DefaultPrismaticJointDef().base; }},
    {"wheel", add_wheel, [] { return b2DefaultWheelJointDef().base; }},
    {"distance", add_distance, [] { return b2DefaultDistanceJointDef().base; }},
    {"weld", add_weld, [] { return b2DefaultWeldJointDef().base; }},
};

// ---- The world ----

struct PeerBody {
  b2BodyId handle = b2_nullBodyId;
  bool is_static = false;
  bool is_dynamic = false;
  bool is_removed = false;
  b2Vec2 center{};  // of mass, in the body's frame
};

class PeerWorld {
 public:
  explicit PeerWorld(const json& scene) : scene_(scene) {
    step_time_ = scene.at("dt").get<float>() / static_cast<float>(scene.at("steps_per_tick").get<int>());
    substeps_ = scene.at("substeps");
    b2WorldDef definition = b2DefaultWorldDef();
    definition.gravity = point_of(scene.at("gravity"));
    definition.enableSleep = false;
    definition.enableContinuous = scene.at("continuous");
    definition.restitutionThreshold = scene.at("restitution_threshold");
    definition.workerCount = 0;
    definition.frictionCallback = mix_named(scene.at("friction_mix"));
    definition.restitutionCallback = mix_named(scene.at("restitution_mix"));
    speed_max_ = 0.9999f * definition.maximumLinearSpeed;
    spin_max_ = 0.9999f * 0.25f * B2_PI * static_cast<float>(substeps_) / step_time_;  // 45 degrees a substep
    world_ = b2CreateWorld(&definition);
    for (const json& body : scene.at("bodies")) add_body(body);
    for (std::size_t i = 0; i < scene.at("joints").size(); ++i) add_joint(scene.at("joints")[i], i);
  }
  PeerWorld(const PeerWorld&) = delete;
  PeerWorld& operator=(const PeerWorld&) = delete;
  ~PeerWorld() { b2DestroyWorld(world_); }

  void step(std::uint64_t tick) {
    const int count = scene_.at("steps_per_tick");
    for (int i = 0; i < count; ++i) {
      const std::clock_t start = std::clock();
      b2World_Step(world_, step_time_, substeps_);
      step_time_ms_ += static_cast<double>(std::clock() - start) * 1e3 / CLOCKS_PER_SEC;  // of the processor
    }
    look(tick, scene_.at("bounds"));
  }

  json bodies() const {
    json numbers = json::array();
    for (std::size_t id = 0; id < bodies_.size(); ++id) {
      const PeerBody& body = bodies_[id];
      if (body.is_static || body.is_removed) continue;
      const auto at = b2Body_GetPosition(body.handle);
      const b2Rot turn = b2Body_GetRotation(body.handle);
      const b2Vec2 velocity = b2Body_GetLinearVelocity(body.handle);
      for (const double number :
           {double(id), double(at.x), double(at.y), double(turn.c), double(turn.s), double(velocity.x),
            double(velocity.y), double(b2Body_GetAngularVelocity(body.handle))})
        numbers.push_back(number);
    }
    return numbers;
  }

  // For each touching pair: ids, normal from A to B, number of points, and for two points place, separation and force.
  json contacts() const {
    json numbers = json::array();
    std::vector<b2ContactData> found;
    for (std::size_t id = 0; id < bodies_.size(); ++id) {
      if (bodies_[id].is_removed || !bodies_[id].is_dynamic) continue;
      found.resize(static_cast<std::size_t>(b2Body_GetContactCapacity(bodies_[id].handle)));
      const int count = b2Body_GetContactData(bodies_[id].handle, found.data(), static_cast<int>(found.size()));
      for (int i = 0; i < count; ++i) {
        const b2BodyId body_a = b2Shape_GetBody(found[i].shapeIdA);
        const std::size_t a = id_of(body_a);
        const std::size_t b = id_of(b2Shape_GetBody(found[i].shapeIdB));
        const std::size_t other = a == id ? b : a;
        if (bodies_[other].is_dynamic && other < id) continue;  // reported before
        add_contact(numbers, a, b, b2Body_GetWorldCenter(body_a), found[i].manifold);
      }
    }
    return numbers;
  }

  std::uint64_t clamped_tick() const { return clamped_tick_; }
  double step_time_ms() const { return step_time_ms_; }

 private:
  std::size_t id_of(b2BodyId handle) const { return reinterpret_cast<std::uintptr_t>(b2Body_GetUserData(handle)); }

  void add_body(const json& body) {
    const std::string type = body.at("type");
    PeerBody out;
    out.is_static = type == "static";
    out.is_dynamic = type == "dynamic";
    out.center = point_of(body.at("center"));
    b2BodyDef definition = b2DefaultBodyDef();
    definition.type = out.is_static ? b2_staticBody : out.is_dynamic ? b2_dynamicBody : b2_kinematicBody;
    definition.position = b2ToPos(point_of(body.at("position")));
    definition.rotation = b2MakeRot(body.at("angle").get<float>());
    definition.linearDamping = body.at("linear_damping");
    definition.angularDamping = body.at("angular_damping");
    definition.gravityScale = body.at("gravity_scale");
    definition.isBullet = body.at("bullet");
    definition.enableSleep = false;
    definition.userData = reinterpret_cast<void*>(std::uintptr_t{bodies_.size()});
    out.handle = b2CreateBody(world_, &definition);
    const std::string place = "/bodies/" + std::to_string(bodies_.size()) + "/shapes/";
    std::size_t index = 0;
    for (const json& shape : body.at("shapes")) add_shape(out.handle, shape, place + std::to_string(index++));
    if (out.is_dynamic) {
      if (body.at("fixed_rotation").get<bool>()) b2Body_SetMotionLocks(out.handle, {false, false, true});
      b2MassData mass{};
      mass.mass = body.at("mass");
      mass.rotationalInertia = body.at("inertia");  // about the centre of mass
      mass.center = out.center;
      b2Body_SetMassData(out.handle, mass);
    }
    if (!out.is_static) {
      b2Body_SetLinearVelocity(out.handle, point_of(body.at("velocity")));
      b2Body_SetAngularVelocity(out.handle, body.at("spin"));
    }
    bodies_.push_back(out);
  }

  void add_joint(const json& joint, std::size_t index) {
    const std::string kind = joint.at("kind");
    for (const JointRow& row : joint_rows) {
      if (kind != row.name) continue;
      b2JointDef base = row.base();
      base.bodyIdA = bodies_.at(joint.at("body_a").get<std::size_t>()).handle;
      base.bodyIdB = bodies_.at(joint.at("body_b").get<std::size_t>()).handle;
      base.collideConnected = joint.at("collide_connected");
      base.localFrameA = {point_of(joint.at("anchor_a")), b2MakeRot(joint.at("angle_a").get<float>())};
      base.localFrameB = {point_of(joint.at("anchor_b")), b2MakeRot(joint.at("angle_b").get<float>())};
      JointFields fields(joint.at("fields"));
      row.create(world_, base, fields);
      if (fields.all_taken()) return;
      throw std::runtime_error("/joints/" + std::to_string(index) + ": Box2D 3 lacks a field of " + kind);
    }
    throw std::runtime_error("/joints/" + std::to_string(index) + ": unknown joint: found " + kind);
  }

  // Finds bodies whose motion Box2D cut, and removes those that left the bounds.
  void look(std::uint64_t tick, const json& bounds) {
    for (PeerBody& body : bodies_) {
      if (body.is_removed || body.is_static) continue;
      const b2Vec2 velocity = b2Body_GetLinearVelocity(body.handle);
      const bool is_cut = std::hypot(velocity.x, velocity.y) >= speed_max_ ||
                          std::fabs(b2Body_GetAngularVelocity(body.handle)) >= spin_max_;
      if (clamped_tick_ == 0 && is_cut) clamped_tick_ = tick;
      if (bounds.is_null()) continue;
      const auto center = b2Body_GetWorldPoint(body.handle, body.center);
      if (center.x >= bounds[0].get<double>() && center.y >= bounds[1].get<double>() &&
          center.x <= bounds[2].get<double>() && center.y <= bounds[3].get<double>())
        continue;
      b2DestroyBody(body.handle);
      body.is_removed = true;
    }
  }

  // Box2D also lists points that are near each other only. Such a point has no impulse.
  void add_contact(json& numbers, std::size_t a, std::size_t b, b2Pos center_a, const b2Manifold& manifold) const {
    constexpr float slop = 0.005f;
    const double substep = static_cast<double>(step_time_) / substeps_;
    std::vector<double> points;
    for (int i = 0; i < manifold.pointCount; ++i) {
      const b2ManifoldPoint& point = manifold.points[i];
      if (point.separation > slop && !(point.normalImpulse > 0)) continue;
      const auto at = b2OffsetPos(center_a, point.anchorA);
      points.insert(points.end(),
                    {double(at.x), double(at.y), double(point.separation), point.normalImpulse / substep});
    }
    if (points.empty()) return;
    const double count = static_cast<double>(points.size() / 4);
    points.resize(8, 0);
    for (const double number : {double(a), double(b), double(manifold.normal.x), double(manifold.normal.y), count})
      numbers.push_back(number);
    for (const double number : points) numbers.push_back(number);
  }

  const json& scene_;
  b2WorldId world_ = b2_nullWorldId;
  float step_time_ = 0;
  int substeps_ = 0;
  float speed_max_ = 0;
  float spin_max_ = 0;
  std::vector<PeerBody> bodies_;  // by id
  std::uint64_t clamped_tick_ = 0;
  double step_time_ms_ = 0;
};

void print_line(const json& line) {
  std::printf("%s\n", line.dump().c_str());
}

std::string library_version() {
  const b2Version version = b2GetVersion();
  return std::to_string(version.major) + "." + std::to_string(version.minor) + "." + std::to_string(version.revision);
}

json run_scene(const json& scene, bool report) {
  PeerWorld world(scene);
  if (report) print_line({{"schema", "ticktrue.box2d3/1"}, {"package", library_version()}});
  const std::uint64_t tick_count = scene.at("ticks");
  const std::uint64_t body_interval = scene.at("body_interval");
  for (std::uint64_t tick = 1; tick <= tick_count; ++tick) {
    world.step(tick);
    if (!report || tick % body_interval != 0) continue;
    json line{{"tick", tick}, {"bodies", world.bodies()}};
    const std::uint64_t left = tick_count - tick;
    if (left < scene.at("contact_window").get<std::uint64_t>() &&
        left % scene.at("contact_interval").get<std::uint64_t>() == 0)
      line["contacts"] = world.contacts();
    print_line(line);
  }
  const double time_ms = tick_count > 0 ? world.step_time_ms() / static_cast<double>(tick_count) : 0;
  return {{"done", true}, {"clamped_tick", world.clamped_tick()}, {"ms_per_tick", time_ms}};
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::runtime_error("usage: ticktrue_box2d3 SCENE.json | --version");
    if (std::string(argv[1]) == "--version") {
      std::printf("%s\n", library_version().c_str());
      return 0;
    }
    std::ifstream file(argv[1], std::ios::binary);
    const json scene = json::parse(file);
    // The first run fills the machine's caches, as the first run in node does.
    if (scene.at("warm_up").get<bool>()) run_scene(scene, false);
    print_line(run_scene(scene, true));
    return 0;
  } catch (const Refused& why) {
    print_line({{"refused", why.what()}});
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ticktrue_box2d3: %s\n", error.what());
    return 1;
  }
}
