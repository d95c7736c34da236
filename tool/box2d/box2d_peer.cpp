// Builds and steps a scene in Box2D 2.4.1. Only the files called box2d_* include Box2D.
// SPDX-License-Identifier: MIT
#include "tool/box2d/box2d_peer.h"

#if !defined(TICKTRUE_HAS_BOX2D)

namespace ticktrue::tool {

Result<std::unique_ptr<Box2dPeer>> make_box2d_peer(const engine::Scene&, const Box2dOptions&) {
  return Error{ErrorCode::unsupported, "Box2D: not in this build: found none, expected 2.4.1",
               "install libbox2d-dev and configure again with -DTICKTRUE_WITH_BOX2D=ON"};
}

std::string box2d_version() {
  return {};
}

}  // namespace ticktrue::tool

#else

#include <box2d/box2d.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>

#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "tool/box2d/box2d_joints.h"
#include "tool/box2d/box2d_shapes.h"
#include "tool/box2d/box2d_units.h"
#include "tool/box2d/length_scale.h"

namespace ticktrue::tool {
namespace {

using engine::BodyReport;
using engine::BodyType;
using engine::ContactReport;
using engine::MixRule;
using engine::Point;
using engine::Shape;

float mix(MixRule rule, float a, float b) {
  switch (rule) {
    case MixRule::geometric_mean:
      return b2Sqrt(a * b);
    case MixRule::maximum:
      return std::max(a, b);
    case MixRule::minimum:
      return std::min(a, b);
    case MixRule::average:
      return (a + b) / 2;
  }
  return 0;
}

double tangent_speed_of(b2Fixture* fixture) {
  const auto* shape = reinterpret_cast<const Shape*>(fixture->GetUserData().pointer);
  return shape == nullptr ? 0 : shape->material.tangent_speed;
}

// Mixes materials by the rules of the scene. Box2D itself only mixes by square root and maximum.
class Mixer : public b2ContactListener {
 public:
  Mixer(MixRule friction, MixRule restitution, double scale)
      : friction_(friction), restitution_(restitution), scale_(scale) {}
  void BeginContact(b2Contact* contact) override {
    b2Fixture* a = contact->GetFixtureA();
    b2Fixture* b = contact->GetFixtureB();
    contact->SetFriction(mix(friction_, a->GetFriction(), b->GetFriction()));
    contact->SetRestitution(mix(restitution_, a->GetRestitution(), b->GetRestitution()));
    // Box2D's tangent has the same direction, but the opposite sign of speed: Box2D drives towards plus this speed.
    contact->SetTangentSpeed(-static_cast<float>(scale_ * (tangent_speed_of(a) + tangent_speed_of(b))));
  }

 private:
  MixRule friction_;
  MixRule restitution_;
  double scale_;
};

std::uint32_t id_of(b2Fixture* fixture) {
  return static_cast<std::uint32_t>(fixture->GetBody()->GetUserData().pointer);
}

// The part of the gap between two shapes that Box2D's separation omits, for one shape, Box2D m.
double skin_of(b2Fixture* fixture, double scale) {
  const b2Shape* shape = fixture->GetShape();
  if (shape->GetType() != b2Shape::e_polygon) return 0;
  const auto* ours = reinterpret_cast<const Shape*>(fixture->GetUserData().pointer);
  return static_cast<double>(shape->m_radius) - ours->radius * scale;
}

class Box2dWorld final : public Box2dPeer {
 public:
  Box2dWorld(const engine::Scene& scene, const Box2dOptions& options, double scale)
      : scene_(scene),
        options_(options),
        units_{scale},
        dt_(static_cast<float>(scene.settings.dt / options.steps_per_tick)),
        mixer_(scene.settings.friction_mix, scene.settings.restitution_mix, scale),
        world_(units_.scaled(scene.gravity)),
        joints_(world_, units_, dt_) {
    world_.SetContactListener(&mixer_);
    world_.SetAllowSleeping(options.sleep && scene.settings.sleep.has_value());
    world_.SetContinuousPhysics(scene.settings.continuous);
  }

  // Errors: unsupported.
  Status build() {
    if (!scene_.forces.empty())
      return Error{ErrorCode::unsupported, scene_.name + ": /forces: Box2D 2.4.1 has no force elements", {}};
    bodies_.reserve(scene_.bodies.size());
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i)
      if (Status added = add_body(i); !added) return added;
    for (std::size_t i = 0; i < scene_.joints.size(); ++i) {
      const engine::Joint& joint = scene_.joints[i];
      const std::string place = fmt::format("{}: /joints/{}", scene_.name, i);
      b2Body* a = engine::has_body_a(joint.kind) ? bodies_[joint.body_a].body : nullptr;
      if (Status added = joints_.add(joint, a, bodies_[joint.body_b].body, place); !added) return added;
    }
    return {};
  }

  void step() override {
    ++tick_;
    for (int i = 0; i < options_.steps_per_tick; ++i) {
      joints_.set_stiffness();
      world_.Step(dt_, options_.velocity_iterations, options_.position_iterations);
      if (clamped_tick_ == 0 && is_clamped()) clamped_tick_ = tick_;
    }
    remove_escaped();
  }

  std::vector<BodyReport> bodies() const override {
    std::vector<BodyReport> reports;
    reports.reserve(bodies_.size());
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const b2Body* body = bodies_[i].body;
      if (!body) continue;
      BodyReport report;
      report.id = static_cast<std::uint32_t>(i);
      report.name = scene_.bodies[i].name;
      report.type = scene_.bodies[i].type;
      report.center = units_.unscaled(body->GetWorldPoint(bodies_[i].local_center));
      report.origin = units_.unscaled(body->GetPosition());
      report.angle = std::remainder(static_cast<double>(body->GetAngle()), 2 * engine::pi);
      report.velocity = units_.unscaled(body->GetLinearVelocityFromLocalPoint(bodies_[i].local_center));
      report.angular_velocity = static_cast<double>(body->GetAngularVelocity());
      report.mass = bodies_[i].mass;
      report.inertia = bodies_[i].inertia;
      report.shapes = &scene_.bodies[i].shapes;
      reports.push_back(std::move(report));
    }
    return reports;
  }

  std::vector<ContactReport> contacts() const override {
    std::vector<ContactReport> reports;
    for (b2Contact* contact = world_.GetContactList(); contact; contact = contact->GetNext()) {
      if (!contact->IsTouching()) continue;
      const b2Manifold* manifold = contact->GetManifold();
      b2WorldManifold world_manifold;
      contact->GetWorldManifold(&world_manifold);
      b2Fixture* a = contact->GetFixtureA();
      b2Fixture* b = contact->GetFixtureB();
      ContactReport report;
      report.body_a = id_of(a);
      report.body_b = id_of(b);
      report.normal = {static_cast<double>(world_manifold.normal.x), static_cast<double>(world_manifold.normal.y)};
      report.point_count = manifold->pointCount;
      for (int i = 0; i < manifold->pointCount; ++i) {
        report.point[i] = units_.unscaled(world_manifold.points[i]);
        report.separation[i] =
            (static_cast<double>(world_manifold.separations[i]) + skin_of(a, units_.scale) + skin_of(b, units_.scale)) /
            units_.scale;
        report.normal_force[i] =
            static_cast<double>(manifold->points[i].normalImpulse) / static_cast<double>(dt_) / units_.scale;
      }
      reports.push_back(report);
    }
    return reports;
  }

  std::size_t body_count() const override {
    return static_cast<std::size_t>(world_.GetBodyCount()) - (joints_.has_anchorage() ? 1 : 0);
  }
  std::size_t contact_count() const override {
    std::size_t count = 0;
    for (b2Contact* contact = world_.GetContactList(); contact; contact = contact->GetNext())
      if (contact->IsTouching()) ++count;
    return count;
  }
  double length_scale() const override { return units_.scale; }
  double skin() const override {
    return (options_.match_skin ? static_cast<double>(b2_linearSlop) : 2 * static_cast<double>(b2_polygonRadius)) /
           units_.scale;
  }
  std::size_t thin_shape_count() const override {
    std::size_t count = 0;
    for (const engine::Body& body : scene_.bodies)
      for (const Shape& shape : body.shapes) count += is_thin(body, shape, units_) ? 1 : 0;
    return count;
  }
  std::size_t clamped_tick() const override { return clamped_tick_; }

 private:
  struct Entry {
    b2Body* body = nullptr;     // null once removed
    b2Vec2 local_center{0, 0};  // centre of mass in the body's frame, Box2D m
    double mass = 0;
    double inertia = 0;
  };

  Status add_body(std::size_t index) {
    const engine::Body& description = scene_.bodies[index];
    const std::string place = fmt::format("{}: /bodies/{}", scene_.name, index);
    const double reach = std::max(std::fabs(description.position.x), std::fabs(description.position.y)) * units_.scale;
    if (reach > box2d_coordinate_max_m)
      return Error{ErrorCode::unsupported,
                   fmt::format("{}/position: too far out for Box2D's floats: found {:g} m, expected at most {:g} m",
                               place, reach / units_.scale, box2d_coordinate_max_m / units_.scale),
                   {}};
    const engine::MassProperties mass = engine::body_mass(description);

    b2BodyDef definition;
    definition.type = description.type == BodyType::static_body      ? b2_staticBody
                      : description.type == BodyType::kinematic_body ? b2_kinematicBody
                                                                     : b2_dynamicBody;
    definition.position = units_.scaled(description.position);
    // Box2D stores the total angle in a float: after thousands of turns small rotations would be lost.
    definition.angle = static_cast<float>(std::remainder(description.angle, 2 * engine::pi));
    definition.linearDamping = static_cast<float>(description.linear_damping);
    definition.angularDamping = static_cast<float>(description.angular_damping);
    definition.gravityScale = static_cast<float>(description.gravity_scale);
    definition.fixedRotation = description.fixed_rotation;
    definition.bullet = description.bullet;
    definition.allowSleep = description.can_sleep;
    definition.userData.pointer = index;
    Entry entry;
    entry.body = world_.CreateBody(&definition);
    entry.local_center = units_.scaled(mass.center);
    entry.mass = mass.mass;
    entry.inertia = mass.inertia;
    for (std::size_t s = 0; s < description.shapes.size(); ++s)
      if (Status added =
              add_box2d_shape(entry.body, description, description.shapes[s], scene_.settings.restitution_threshold,
                              options_, units_, fmt::format("{}/shapes/{}", place, s));
          !added)
        return added;

    if (description.type == BodyType::dynamic_body) {
      b2MassData data;
      data.mass = static_cast<float>(mass.mass);
      data.center = entry.local_center;
      // Box2D expects the inertia about the body's origin, and subtracts the share of the offset.
      data.I =
          static_cast<float>(mass.inertia * units_.scale * units_.scale) + data.mass * b2Dot(data.center, data.center);
      entry.body->SetMassData(&data);
    }
    if (description.type != BodyType::static_body) {
      // A scene gives the velocity of the centre of mass. Box2D's kinematic bodies turn about their origin instead.
      b2Vec2 velocity = units_.scaled(description.velocity);
      const float spin = static_cast<float>(description.angular_velocity);
      if (description.type == BodyType::kinematic_body)
        velocity -= b2Cross(spin, entry.body->GetWorldVector(entry.local_center));
      entry.body->SetLinearVelocity(velocity);
      entry.body->SetAngularVelocity(spin);
    }
    bodies_.push_back(entry);
    return {};
  }

  // Box2D limits the displacement and rotation of a body in one step to b2_maxTranslation and b2_maxRotation. Box2D
  // writes the limited velocity back, so a clamped body has a speed at the limit.
  bool is_clamped() const {
    const float speed_max = 0.9999f * b2_maxTranslation / dt_;
    const float spin_max = 0.9999f * b2_maxRotation / dt_;
    for (const Entry& entry : bodies_) {
      if (!entry.body || entry.body->GetType() == b2_staticBody) continue;
      if (entry.body->GetLinearVelocity().LengthSquared() >= speed_max * speed_max ||
          std::fabs(entry.body->GetAngularVelocity()) >= spin_max)
        return true;
    }
    return false;
  }

  void remove_escaped() {
    if (!scene_.bounds) return;
    for (Entry& entry : bodies_) {
      if (!entry.body || entry.body->GetType() == b2_staticBody) continue;
      const Point center = units_.unscaled(entry.body->GetWorldPoint(entry.local_center));
      const bool inside = center.x >= scene_.bounds->lower.x && center.x <= scene_.bounds->upper.x &&
                          center.y >= scene_.bounds->lower.y && center.y <= scene_.bounds->upper.y;
      if (inside) continue;
      joints_.forget(entry.body);
      world_.DestroyBody(entry.body);
      entry.body = nullptr;
    }
  }

  engine::Scene scene_;
  Box2dOptions options_;
  Box2dUnits units_;
  float dt_;  // s, of a step
  Mixer mixer_;
  mutable b2World world_;      // mutable: Box2D returns the user data of fixtures only without const
  std::vector<Entry> bodies_;  // by id
  Box2dJoints joints_;
  std::size_t tick_ = 0;
  std::size_t clamped_tick_ = 0;
};

// Box2D fills a table of contact functions at its first contact, without a lock. This function fills it once before
// threads use it.
void fill_contact_table() {
  static std::once_flag done;
  std::call_once(done, [] {
    b2World world(b2Vec2(0, 0));
    b2CircleShape circle;
    circle.m_radius = 1;
    b2BodyDef definition;
    definition.type = b2_dynamicBody;
    for (int i = 0; i < 2; ++i) world.CreateBody(&definition)->CreateFixture(&circle, 1);
    world.Step(0.01f, 1, 1);
  });
}

}  // namespace

Result<std::unique_ptr<Box2dPeer>> make_box2d_peer(const engine::Scene& scene, const Box2dOptions& options) {
  fill_contact_table();
  auto peer = std::make_unique<Box2dWorld>(scene, options, choose_length_scale(scene));
  if (Status built = peer->build(); !built) return built.error();
  return std::unique_ptr<Box2dPeer>(std::move(peer));
}

std::string box2d_version() {
  // Box2D 2.4.1 still reports version 2.4.0. The restitution thresholds of fixtures, used above, exist since 2.4.1.
  const int revision =
      b2_version.major == 2 && b2_version.minor == 4 && b2_version.revision == 0 ? 1 : b2_version.revision;
  return fmt::format("{}.{}.{}", b2_version.major, b2_version.minor, revision);
}

}  // namespace ticktrue::tool

#endif
