// Builds and steps a scene in Box2D 2.4.1: the only file that includes Box2D.
// SPDX-License-Identifier: MIT
#include "verifier/box2d_peer.h"

#if !defined(TICKTRUE_HAS_BOX2D)

namespace ticktrue::verifier {

Result<std::unique_ptr<Box2dPeer>> make_box2d_peer(const engine::Scene&, const Box2dOptions&) {
  return Error{ErrorCode::unsupported, "Box2D: not in this build: found none, expected 2.4.1",
               "install libbox2d-dev and configure again with -DTICKTRUE_WITH_BOX2D=ON"};
}

std::string box2d_version() {
  return {};
}

}  // namespace ticktrue::verifier

#else

#include <box2d/box2d.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <optional>

#include "engine/geometry/hull.h"
#include "engine/math/trig.h"

namespace ticktrue::verifier {
namespace {

using engine::BodyReport;
using engine::BodyType;
using engine::ContactReport;
using engine::JointKind;
using engine::MixRule;
using engine::Point;
using engine::Shape;
using engine::ShapeKind;

// Box2D is tuned for moving bodies of 0.1 m to 10 m: slop 5 mm, skin 1 cm, bounce threshold 1 m/s.
constexpr double tuned_size_min_m = 0.1;
constexpr double tuned_size_max_m = 10;
constexpr double thickness_min_m = 3 * static_cast<double>(b2_polygonRadius);  // thinner: mostly skin
constexpr double coordinate_max_m = 2e4;  // a float resolves 2 mm there, not half of Box2D's slop

// Largest extent of a shape, twice its bounding radius about its own centre.
double extent_of(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::circle:
      return 2 * shape.radius;
    case ShapeKind::box:
      return 2 * std::sqrt(shape.half_size.x * shape.half_size.x + shape.half_size.y * shape.half_size.y);
    case ShapeKind::polygon:
    case ShapeKind::capsule:
    case ShapeKind::segment:
    case ShapeKind::chain:
      break;
  }
  double extent = 0;
  for (const Point& a : shape.vertices)
    for (const Point& b : shape.vertices) extent = std::max(extent, std::hypot(a.x - b.x, a.y - b.y));
  return extent;
}

// Smallest width of a shape over all directions. `hull` is counter-clockwise.
double thickness_of(const Shape& shape, const std::vector<Point>& hull) {
  if (shape.kind == ShapeKind::circle) return 2 * shape.radius;
  if (shape.kind == ShapeKind::box) return 2 * std::min(shape.half_size.x, shape.half_size.y);
  if (shape.kind == ShapeKind::capsule) return 2 * shape.radius;
  double thickness = extent_of(shape);
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point& a = hull[i];
    const Point& b = hull[(i + 1) % hull.size()];
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    double width = 0;
    for (const Point& p : hull)
      width = std::max(width, ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) / length);
    thickness = std::min(thickness, width);
  }
  return thickness;
}

// Brings the median moving body into the range Box2D is tuned for; a power of two, so that it rounds nothing.
double choose_length_scale(const engine::Scene& scene) {
  std::vector<double> extents;
  for (const engine::Body& body : scene.bodies) {
    if (body.type != BodyType::dynamic_body) continue;
    double extent = 0;
    for (const Shape& shape : body.shapes) extent = std::max(extent, extent_of(shape));
    extents.push_back(extent);
  }
  if (extents.empty()) return 1;
  std::nth_element(extents.begin(), extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2), extents.end());
  const double median = extents[extents.size() / 2];
  double scale = 1;
  if (median > tuned_size_max_m)
    while (median * scale > 2) scale /= 2;
  if (median < tuned_size_min_m)
    while (median * scale < 1) scale *= 2;
  return scale;
}

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

// Mixes materials as the scene says; Box2D by itself knows sqrt and max only.
class Mixer : public b2ContactListener {
 public:
  Mixer(MixRule friction, MixRule restitution, double scale)
      : friction_(friction), restitution_(restitution), scale_(scale) {}
  void BeginContact(b2Contact* contact) override {
    b2Fixture* a = contact->GetFixtureA();
    b2Fixture* b = contact->GetFixtureB();
    contact->SetFriction(mix(friction_, a->GetFriction(), b->GetFriction()));
    contact->SetRestitution(mix(restitution_, a->GetRestitution(), b->GetRestitution()));
    // Box2D's tangent is ours; it drives towards plus this speed, we towards minus the sum.
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

// What Box2D's separations leave out of the gap between the geometry of two shapes, Box2D m.
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
        scale_(scale),
        dt_(static_cast<float>(scene.settings.dt / options.steps_per_tick)),
        mixer_(scene.settings.friction_mix, scene.settings.restitution_mix, scale),
        world_(scaled(scene.gravity)) {
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
    for (std::size_t i = 0; i < scene_.joints.size(); ++i)
      if (Status added = add_joint(i); !added) return added;
    return {};
  }

  void step() override {
    ++tick_;
    for (int i = 0; i < options_.steps_per_tick; ++i) {
      for (const Sprung& sprung : sprung_) set_stiffness(sprung);
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
      report.center = unscaled(body->GetWorldPoint(bodies_[i].local_center));
      report.origin = unscaled(body->GetPosition());
      report.angle = std::remainder(static_cast<double>(body->GetAngle()), 2 * engine::pi);
      report.velocity = unscaled(body->GetLinearVelocityFromLocalPoint(bodies_[i].local_center));
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
        report.point[i] = unscaled(world_manifold.points[i]);
        report.separation[i] =
            (static_cast<double>(world_manifold.separations[i]) + skin_of(a, scale_) + skin_of(b, scale_)) / scale_;
        report.normal_force[i] =
            static_cast<double>(manifold->points[i].normalImpulse) / static_cast<double>(dt_) / scale_;
      }
      reports.push_back(report);
    }
    return reports;
  }

  std::size_t body_count() const override {
    return static_cast<std::size_t>(world_.GetBodyCount()) - (anchorage_ ? 1 : 0);
  }
  std::size_t contact_count() const override {
    std::size_t count = 0;
    for (b2Contact* contact = world_.GetContactList(); contact; contact = contact->GetNext())
      if (contact->IsTouching()) ++count;
    return count;
  }
  double length_scale() const override { return scale_; }
  double skin() const override {
    return (options_.match_skin ? static_cast<double>(b2_linearSlop) : 2 * static_cast<double>(b2_polygonRadius)) /
           scale_;
  }
  std::size_t clamped_tick() const override { return clamped_tick_; }

 private:
  struct Entry {
    b2Body* body = nullptr;     // null once removed
    b2Vec2 local_center{0, 0};  // centre of mass in the body's frame, Box2D m
    double mass = 0;
    double inertia = 0;
  };

  b2Vec2 scaled(const Point& p) const { return {static_cast<float>(p.x * scale_), static_cast<float>(p.y * scale_)}; }
  Point unscaled(const b2Vec2& v) const {
    return {static_cast<double>(v.x) / scale_, static_cast<double>(v.y) / scale_};
  }

  Status add_body(std::size_t index) {
    const engine::Body& description = scene_.bodies[index];
    const std::string place = fmt::format("{}: /bodies/{}", scene_.name, index);
    const double reach = std::max(std::fabs(description.position.x), std::fabs(description.position.y)) * scale_;
    if (reach > coordinate_max_m)
      return Error{ErrorCode::unsupported,
                   fmt::format("{}/position: too far out for Box2D's floats: found {:g} m, expected at most {:g} m",
                               place, reach / scale_, coordinate_max_m / scale_),
                   {}};
    const engine::MassProperties mass = engine::body_mass(description);

    b2BodyDef definition;
    definition.type = description.type == BodyType::static_body      ? b2_staticBody
                      : description.type == BodyType::kinematic_body ? b2_kinematicBody
                                                                     : b2_dynamicBody;
    definition.position = scaled(description.position);
    // Box2D adds turns up in a float: after thousands of them it would lose small ones.
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
    entry.local_center = scaled(mass.center);
    entry.mass = mass.mass;
    entry.inertia = mass.inertia;
    for (std::size_t s = 0; s < description.shapes.size(); ++s)
      if (Status added =
              add_shape(entry.body, description, description.shapes[s], fmt::format("{}/shapes/{}", place, s));
          !added)
        return added;

    if (description.type == BodyType::dynamic_body) {
      b2MassData data;
      data.mass = static_cast<float>(mass.mass);
      data.center = entry.local_center;
      // Box2D wants the inertia about the body's origin and subtracts the offset's share again.
      data.I = static_cast<float>(mass.inertia * scale_ * scale_) + data.mass * b2Dot(data.center, data.center);
      entry.body->SetMassData(&data);
    }
    if (description.type != BodyType::static_body) {
      // Ours is the velocity of the centre of mass. Box2D's kinematic bodies turn about their origin instead.
      b2Vec2 velocity = scaled(description.velocity);
      const float spin = static_cast<float>(description.angular_velocity);
      if (description.type == BodyType::kinematic_body)
        velocity -= b2Cross(spin, entry.body->GetWorldVector(entry.local_center));
      entry.body->SetLinearVelocity(velocity);
      entry.body->SetAngularVelocity(spin);
    }
    bodies_.push_back(entry);
    return {};
  }

  Status add_shape(b2Body* body, const engine::Body& description, const Shape& shape, const std::string& place) {
    b2CircleShape circle;
    b2PolygonShape polygon;
    b2EdgeShape edge;
    b2ChainShape chain;
    if (Status known = check_known(shape, place); !known) return known;
    b2FixtureDef definition;
    definition.userData.pointer = reinterpret_cast<std::uintptr_t>(&shape);
    definition.isSensor = shape.sensor;
    definition.filter.categoryBits = static_cast<std::uint16_t>(shape.filter.category);
    definition.filter.maskBits = static_cast<std::uint16_t>(shape.filter.mask);
    definition.filter.groupIndex = static_cast<std::int16_t>(shape.filter.group);
    definition.friction = static_cast<float>(shape.material.friction);
    definition.restitution = static_cast<float>(shape.material.restitution);
    definition.restitutionThreshold = static_cast<float>(scene_.settings.restitution_threshold * scale_);

    std::vector<Point> hull;
    if (shape.kind == ShapeKind::polygon) {
      Result<std::vector<Point>> built = engine::build_hull(shape.vertices);
      if (!built) return built.error();
      hull = std::move(*built);
    }
    const double thickness = thickness_of(shape, hull) * scale_;
    const bool has_skin = shape.kind == ShapeKind::box || shape.kind == ShapeKind::polygon;
    if (description.type == BodyType::dynamic_body && has_skin && !shape.sensor && thickness < thickness_min_m)
      return Error{
          ErrorCode::unsupported,
          fmt::format("{}: too thin for Box2D's skin of {:g} m: found {:g} m, expected at least {:g} m", place,
                      static_cast<double>(b2_polygonRadius) / scale_, thickness / scale_, thickness_min_m / scale_),
          {}};
    switch (shape.kind) {
      case ShapeKind::circle:
        circle.m_p = scaled(shape.center);
        circle.m_radius = static_cast<float>(shape.radius * scale_);
        definition.shape = &circle;
        break;
      case ShapeKind::box:
        polygon.SetAsBox(static_cast<float>(shape.half_size.x * scale_), static_cast<float>(shape.half_size.y * scale_),
                         scaled(shape.center), static_cast<float>(shape.angle));
        definition.shape = &polygon;
        break;
      case ShapeKind::polygon: {
        if (hull.size() > b2_maxPolygonVertices)
          return Error{ErrorCode::unsupported,
                       fmt::format("{}/vertices: too many for Box2D: found {}, expected at most {}", place, hull.size(),
                                   b2_maxPolygonVertices),
                       {}};
        b2Vec2 vertices[b2_maxPolygonVertices];
        for (std::size_t i = 0; i < hull.size(); ++i) vertices[i] = scaled(hull[i]);
        // Box2D welds vertices this close and, with fewer than three left, replaces the polygon by a box.
        const float weld = 0.5f * b2_linearSlop;
        for (std::size_t i = 0; i < hull.size(); ++i)
          for (std::size_t j = 0; j < i; ++j)
            if (b2Distance(vertices[i], vertices[j]) <= 1.01f * weld)
              return Error{ErrorCode::unsupported,
                           fmt::format("{}/vertices: Box2D would weld two of them: found {:g} m apart, expected over "
                                       "{:g} m",
                                       place, static_cast<double>(b2Distance(vertices[i], vertices[j])) / scale_,
                                       static_cast<double>(weld) / scale_),
                           {}};
        polygon.Set(vertices, static_cast<int32>(hull.size()));
        if (polygon.m_count != static_cast<int32>(hull.size()))
          return Error{ErrorCode::unsupported,
                       fmt::format("{}/vertices: Box2D drops some as collinear: found {} left, expected {}", place,
                                   polygon.m_count, hull.size()),
                       {}};
        definition.shape = &polygon;
        break;
      }
      case ShapeKind::capsule:
        set_octagon(polygon, shape);
        definition.shape = &polygon;
        break;
      case ShapeKind::segment:
        edge.SetTwoSided(scaled(shape.vertices[0]), scaled(shape.vertices[1]));
        definition.shape = &edge;
        break;
      case ShapeKind::chain: {
        std::vector<b2Vec2> points;
        for (const Point& p : shape.vertices) points.push_back(scaled(p));
        const auto count = static_cast<int32>(points.size());
        const auto last = points.size() - 1;
        if (shape.loop)
          chain.CreateLoop(points.data(), count);
        else  // its ends want a neighbour: one straight on
          chain.CreateChain(points.data(), count, 2 * points[0] - points[1], 2 * points[last] - points[last - 1]);
        definition.shape = &chain;
        break;
      }
    }
    // Polygons rest with their skins half a slop each inside each other: that is then where ours touch.
    const double rounding = shape.kind == ShapeKind::capsule ? 0 : shape.radius;  // an octagon has its width already
    if ((rounding > 0 || options_.match_skin) && definition.shape == &polygon)
      polygon.m_radius = static_cast<float>(rounding * scale_) + 0.5f * b2_linearSlop;
    body->CreateFixture(&definition);
    return {};
  }

  // Four points around either end of a capsule.
  void set_octagon(b2PolygonShape& polygon, const Shape& capsule) const {
    const Point& a = capsule.vertices[0];
    const Point& b = capsule.vertices[1];
    const double along = std::atan2(b.y - a.y, b.x - a.x);
    b2Vec2 vertices[b2_maxPolygonVertices];
    for (int i = 0; i < b2_maxPolygonVertices; ++i) {
      const Point& end = i < 4 ? b : a;
      const double angle = along + (i < 4 ? 0 : engine::pi) + (i % 4 - 1.5) * engine::pi / 3;
      vertices[i] = scaled({end.x + capsule.radius * std::cos(angle), end.y + capsule.radius * std::sin(angle)});
    }
    polygon.Set(vertices, b2_maxPolygonVertices);
  }

  // Errors: unsupported, for what Box2D 2.4.1 has no notion of.
  Status check_known(const Shape& shape, const std::string& place) const {
    const auto refuse = [&](const char* what) {
      return Error{ErrorCode::unsupported, fmt::format("{}: {}", place, what), {}};
    };
    if (shape.kind == ShapeKind::capsule && !options_.capsules_as_octagons)
      return refuse("Box2D 2.4.1 has no capsules");
    if (shape.kind == ShapeKind::segment || shape.kind == ShapeKind::chain)
      if (shape.radius > 0) return refuse("Box2D 2.4.1 rounds no lines");
    if (shape.material.rolling_resistance > 0) return refuse("Box2D 2.4.1 has no rolling resistance");
    const engine::Filter& filter = shape.filter;
    const std::uint32_t beyond = filter.mask >> 16;  // "all" and "all but some" have every bit
    if (filter.category > 0xffff || (beyond != 0 && beyond != 0xffff) || filter.group < -0x8000 ||
        filter.group > 0x7fff)
      return refuse("Box2D 2.4.1 has filters of 16 bits");
    for (std::size_t i = shape.kind == ShapeKind::chain && shape.loop ? 0 : 1;
         shape.kind == ShapeKind::chain && i < shape.vertices.size(); ++i) {
      const b2Vec2 a = scaled(shape.vertices[i]);
      const b2Vec2 b = scaled(shape.vertices[(i + shape.vertices.size() - 1) % shape.vertices.size()]);
      if (b2Distance(a, b) <= 1.01f * b2_linearSlop) return refuse("a chain's edge is too short for Box2D");
    }
    return {};
  }

  // ---- Joints ----

  // Masses and arms of a joint's two bodies, Box2D units.
  struct Pair {
    b2Body* a;
    b2Body* b;
    double inv_mass() const {
      return inverse(static_cast<double>(a->GetMass())) + inverse(static_cast<double>(b->GetMass()));
    }
    double inv_inertia(const b2Body* body) const {
      const double mass = static_cast<double>(body->GetMass());
      const double arm = static_cast<double>(body->GetLocalCenter().LengthSquared());
      return body->IsFixedRotation() ? 0 : inverse(static_cast<double>(body->GetInertia()) - mass * arm);
    }
    static double inverse(double value) { return value > 0 ? 1 / value : 0; }
    // Of a row along a direction through two points of the world, as ours has it (joint_rows.h), 1/kg.
    double mobility(const b2Vec2& axis, const b2Vec2& at_a, const b2Vec2& at_b) const {
      const double lever_a = static_cast<double>(b2Cross(at_a - a->GetWorldCenter(), axis));
      const double lever_b = static_cast<double>(b2Cross(at_b - b->GetWorldCenter(), axis));
      return inv_mass() + inv_inertia(a) * lever_a * lever_a + inv_inertia(b) * lever_b * lever_b;
    }
    // Of the angle while the bodies are pinned at a point of the world, as ours has it, 1/(kg m^2).
    double pinned_mobility(const b2Vec2& pin) const {
      const b2Vec2 arm_a = pin - a->GetWorldCenter();
      const b2Vec2 arm_b = pin - b->GetWorldCenter();
      const double m = inv_mass(), i = inv_inertia(a), j = inv_inertia(b);
      const double xa = static_cast<double>(arm_a.x), ya = static_cast<double>(arm_a.y);
      const double xb = static_cast<double>(arm_b.x), yb = static_cast<double>(arm_b.y);
      // Schur complement of the point's mobility in that of point and angle.
      const double k11 = m + i * ya * ya + j * yb * yb;
      const double k12 = -(i * xa * ya + j * xb * yb);
      const double k22 = m + i * xa * xa + j * xb * xb;
      const double c1 = -(i * ya + j * yb), c2 = i * xa + j * xb;
      const double determinant = k11 * k22 - k12 * k12;
      return i + j - (k22 * c1 * c1 - 2 * k12 * c1 * c2 + k11 * c2 * c2) / determinant;
    }
  };

  struct Stiffness {
    float stiffness = 0;
    float damping = 0;
  };
  /// Requires: `mobility` > 0 of the sprung row, where the scene gives hertz. `unit`: of absolute values.
  static Stiffness stiffness_of(const engine::JointSpring& spring, double mobility, double unit) {
    if (spring.absolute)
      return {static_cast<float>(spring.stiffness * unit), static_cast<float>(spring.damping * unit)};
    const double omega = 2 * engine::pi * spring.hertz;
    return {static_cast<float>(omega * omega / mobility),
            static_cast<float>(2 * spring.damping_ratio * omega / mobility)};
  }

  // Box2D adds angles up where ours repeat every turn: the reference from which B starts less than half a turn away.
  static float reference_of(double reference, const Pair& pair) {
    const double start = static_cast<double>(pair.b->GetAngle() - pair.a->GetAngle()) - reference;
    return static_cast<float>(reference + (start - std::remainder(start, 2 * engine::pi)));
  }

  template <typename Definition>
  void set_limits(Definition& definition, const engine::Joint& joint) const {
    if (!joint.limits) return;
    definition.enableLimit = true;
    definition.lowerTranslation = static_cast<float>(joint.limits->lower * scale_);
    definition.upperTranslation = static_cast<float>(joint.limits->upper * scale_);
  }

  // Errors: unsupported, for what Box2D 2.4.1 has no notion of.
  Status check_known(const engine::Joint& joint, const std::string& place) const {
    const auto refuse = [&](const char* what) {
      return Error{ErrorCode::unsupported, fmt::format("{}: {}", place, what), {}};
    };
    for (const auto& spring : {joint.spring, joint.linear_spring}) {
      if (!spring) continue;
      const bool is_stiff = spring->absolute ? spring->stiffness > 0 : spring->hertz > 0;
      if (!is_stiff && spring->absolute && spring->damping > 0) return refuse("Box2D 2.4.1 has no damper alone");
    }
    switch (joint.kind) {
      case JointKind::revolute:
      case JointKind::prismatic:
        if (joint.spring) return refuse("Box2D 2.4.1 has no springs in revolute and prismatic joints");
        break;
      case JointKind::distance:
        if (joint.motor) return refuse("Box2D 2.4.1 has no motors in distance joints");
        if (!joint.limits && !joint.spring && joint.length * scale_ < static_cast<double>(b2_linearSlop))
          return refuse("Box2D 2.4.1 has no rods shorter than its slop");
        break;
      case JointKind::weld:
        if (joint.linear_spring) return refuse("Box2D 2.4.1 has no springs for the point of weld joints");
        break;
      case JointKind::motor:
        if (joint.spring && !(joint.spring->absolute ? joint.spring->damping > 0 : joint.spring->damping_ratio >= 1))
          return refuse("Box2D 2.4.1 has no motor joints that swing");
        break;
      case JointKind::target:
        if (!joint.spring) return refuse("Box2D 2.4.1 has no rigid mouse joints");
        break;
      case JointKind::wheel:
      case JointKind::friction:
        break;
    }
    return {};
  }

  // Springs given in hertz are as stiff as their row's mass asks, which turns with the bodies.
  struct Sprung {
    b2Joint* joint;
    std::size_t index;  // in Scene::joints
  };
  void set_stiffness(const Sprung& sprung) const {
    const engine::Joint& joint = scene_.joints[sprung.index];
    if (!joint.spring) return;
    const Pair pair{sprung.joint->GetBodyA(), sprung.joint->GetBodyB()};
    const b2Vec2 at_a = sprung.joint->GetAnchorA();
    const b2Vec2 at_b = sprung.joint->GetAnchorB();
    const auto set = [](auto* target, const Stiffness& soft) {
      target->SetStiffness(soft.stiffness);
      target->SetDamping(soft.damping);
    };
    if (joint.kind == JointKind::weld) {
      const double mobility = pair.pinned_mobility(0.5f * (at_a + at_b));
      set(static_cast<b2WeldJoint*>(sprung.joint), stiffness_of(*joint.spring, mobility, scale_ * scale_));
      return;
    }
    if (joint.kind == JointKind::wheel) {  // ours acts at B's anchor on both bodies
      b2Vec2 axis = scaled(joint.axis);
      axis.Normalize();
      const double mobility = pair.mobility(pair.a->GetWorldVector(axis), at_b, at_b);
      set(static_cast<b2WheelJoint*>(sprung.joint), stiffness_of(*joint.spring, mobility, 1));
      return;
    }
    b2Vec2 along = at_b - at_a;
    if (along.Normalize() < b2_epsilon) along = {1, 0};
    set(static_cast<b2DistanceJoint*>(sprung.joint), stiffness_of(*joint.spring, pair.mobility(along, at_a, at_b), 1));
  }

  Status add_joint(std::size_t index) {
    const engine::Joint& joint = scene_.joints[index];
    const std::string place = fmt::format("{}: /joints/{}", scene_.name, index);
    if (Status known = check_known(joint, place); !known) return known;
    const bool to_world = joint.kind == JointKind::target;
    if (to_world && !anchorage_) {
      const b2BodyDef definition;
      anchorage_ = world_.CreateBody(&definition);
    }
    const Pair pair{to_world ? anchorage_ : bodies_[joint.body_a].body, bodies_[joint.body_b].body};
    const b2Vec2 anchor_a = scaled(joint.anchor_a);
    const b2Vec2 anchor_b = scaled(joint.anchor_b);
    const b2Vec2 at_b = pair.b->GetWorldPoint(anchor_b);
    b2Vec2 axis = scaled(joint.axis);
    axis.Normalize();
    const auto add = [&](b2JointDef& definition) {
      definition.bodyA = pair.a;
      definition.bodyB = pair.b;
      definition.collideConnected = joint.collide_connected || to_world;
      return world_.CreateJoint(&definition);
    };
    const auto force = [&](double newton) { return static_cast<float>(newton * scale_); };
    const auto torque = [&](double newton_m) { return static_cast<float>(newton_m * scale_ * scale_); };
    switch (joint.kind) {
      case JointKind::revolute: {
        b2RevoluteJointDef definition;
        definition.localAnchorA = anchor_a;
        definition.localAnchorB = anchor_b;
        definition.referenceAngle = reference_of(joint.reference_angle, pair);
        if (joint.limits) {
          definition.enableLimit = true;
          definition.lowerAngle = static_cast<float>(joint.limits->lower);
          definition.upperAngle = static_cast<float>(joint.limits->upper);
        }
        if (joint.motor) {
          definition.enableMotor = true;
          definition.motorSpeed = static_cast<float>(joint.motor->speed);
          definition.maxMotorTorque = torque(joint.motor->force_max);
        }
        add(definition);
        break;
      }
      case JointKind::prismatic: {
        b2PrismaticJointDef definition;
        definition.localAnchorA = anchor_a;
        definition.localAnchorB = anchor_b;
        definition.localAxisA = axis;
        definition.referenceAngle = reference_of(joint.reference_angle, pair);
        set_limits(definition, joint);
        if (joint.motor) {
          definition.enableMotor = true;
          definition.motorSpeed = static_cast<float>(joint.motor->speed * scale_);
          definition.maxMotorForce = force(joint.motor->force_max);
        }
        add(definition);
        break;
      }
      case JointKind::wheel: {
        b2WheelJointDef definition;
        definition.localAnchorA = anchor_a;
        definition.localAnchorB = anchor_b;
        definition.localAxisA = axis;
        set_limits(definition, joint);
        if (joint.motor) {
          definition.enableMotor = true;
          definition.motorSpeed = static_cast<float>(joint.motor->speed);
          definition.maxMotorTorque = torque(joint.motor->force_max);
        }
        sprung_.push_back({add(definition), index});
        break;
      }
      case JointKind::distance: {
        b2DistanceJointDef definition;
        definition.localAnchorA = anchor_a;
        definition.localAnchorB = anchor_b;
        definition.length = static_cast<float>(joint.length * scale_);
        if (!joint.limits && !joint.spring) definition.minLength = definition.maxLength = definition.length;
        if (joint.limits) {
          definition.minLength = static_cast<float>(joint.limits->lower * scale_);
          definition.maxLength = static_cast<float>(joint.limits->upper * scale_);
        }
        sprung_.push_back({add(definition), index});
        break;
      }
      case JointKind::weld: {
        b2WeldJointDef definition;
        definition.localAnchorA = anchor_a;
        definition.localAnchorB = anchor_b;
        definition.referenceAngle = reference_of(joint.reference_angle, pair);
        sprung_.push_back({add(definition), index});
        break;
      }
      case JointKind::motor: {
        b2MotorJointDef definition;
        definition.linearOffset = scaled(joint.offset);
        definition.angularOffset = reference_of(joint.angle_offset, pair);
        definition.maxForce = force(joint.force_max);
        definition.maxTorque = torque(joint.torque_max);
        if (joint.spring) {
          // What is overdamped creeps back at stiffness / damping; Box2D takes this share of the error out each step.
          const double rate = joint.spring->absolute
                                  ? joint.spring->stiffness / joint.spring->damping
                                  : engine::pi * joint.spring->hertz / joint.spring->damping_ratio;  // 1/s
          definition.correctionFactor = std::min(1.0f, static_cast<float>(rate) * dt_);
        }
        add(definition);
        break;
      }
      case JointKind::friction: {
        b2FrictionJointDef definition;  // ours acts at B's centre of mass
        definition.localAnchorA = pair.a->GetLocalPoint(pair.b->GetWorldCenter());
        definition.localAnchorB = pair.b->GetLocalCenter();
        definition.maxForce = force(joint.force_max);
        definition.maxTorque = torque(joint.torque_max);
        add(definition);
        break;
      }
      case JointKind::target: {
        b2MouseJointDef definition;
        definition.target = at_b;  // where B is held; where to comes after
        definition.maxForce = force(joint.force_max);
        const Stiffness soft = stiffness_of(*joint.spring, pair.inv_mass(), 1);
        definition.stiffness = soft.stiffness;
        definition.damping = soft.damping;
        static_cast<b2MouseJoint*>(add(definition))->SetTarget(scaled(joint.offset));
        break;
      }
    }
    return {};
  }

  // Box2D cuts what a body moves or turns in one step to b2_maxTranslation and b2_maxRotation. It writes the cut
  // velocity back, so a cut shows as a speed at the limit.
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
      const Point center = unscaled(entry.body->GetWorldPoint(entry.local_center));
      const bool inside = center.x >= scene_.bounds->lower.x && center.x <= scene_.bounds->upper.x &&
                          center.y >= scene_.bounds->lower.y && center.y <= scene_.bounds->upper.y;
      if (inside) continue;
      const auto is_gone = [&](const Sprung& sprung) {
        return sprung.joint->GetBodyA() == entry.body || sprung.joint->GetBodyB() == entry.body;
      };
      sprung_.erase(std::remove_if(sprung_.begin(), sprung_.end(), is_gone), sprung_.end());
      world_.DestroyBody(entry.body);
      entry.body = nullptr;
    }
  }

  engine::Scene scene_;
  Box2dOptions options_;
  double scale_;
  float dt_;  // s, of a step
  Mixer mixer_;
  mutable b2World world_;      // its contacts' fixtures and bodies tell their user data to the non-const only
  std::vector<Entry> bodies_;  // by id
  std::vector<Sprung> sprung_;
  b2Body* anchorage_ = nullptr;  // holds what is pulled to points of the world; made when first needed
  std::size_t tick_ = 0;
  std::size_t clamped_tick_ = 0;
};

// Box2D fills a table of contact functions on its first contact, without a lock: once, before any thread needs it.
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
  // 2.4.1 still calls itself 2.4.0; fixtures with a restitution threshold of their own, used above, came with 2.4.1.
  const int revision =
      b2_version.major == 2 && b2_version.minor == 4 && b2_version.revision == 0 ? 1 : b2_version.revision;
  return fmt::format("{}.{}.{}", b2_version.major, b2_version.minor, revision);
}

}  // namespace ticktrue::verifier

#endif
