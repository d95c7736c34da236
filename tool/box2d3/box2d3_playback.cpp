// Plays the answer of peer.mjs back, tick by tick, in units of the scene.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/box2d3_playback.h"

#include <cmath>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "engine/engine.h"
#include "engine/math/trig.h"
#include "engine/scene/hull.h"

namespace ticktrue::tool {
namespace {

using engine::BodyReport;
using engine::BodyType;
using engine::ContactReport;
using engine::Point;

class Box2d3Playback final : public Box2d3Peer {
 public:
  Box2d3Playback(engine::Scene scene, const Box2d3Plan& plan, double scale, Box2d3Answer answer)
      : scene_(std::move(scene)), plan_(plan), scale_(scale), answer_(std::move(answer)) {
    for (const engine::Body& body : scene_.bodies) masses_.push_back(engine::body_mass(body));
  }

  void step() override {
    TICKTRUE_ASSERT(tick_ < plan_.tick_count);
    ++tick_;
  }

  std::vector<BodyReport> bodies() const override {
    const Box2d3Tick& tick = reported();
    std::vector<BodyReport> reports;
    reports.reserve(scene_.bodies.size());
    std::size_t next = 0;
    for (std::size_t id = 0; id < scene_.bodies.size(); ++id) {
      const engine::Body& body = scene_.bodies[id];
      if (body.type == BodyType::static_body) {
        const engine::SinCos turn = engine::sin_cos(body.angle);
        reports.push_back(report_of(id, body.position, turn.cos, turn.sin));
      } else if (next < tick.bodies.size() && tick.bodies[next].id == id) {
        const Box2d3Body& moved = tick.bodies[next++];
        BodyReport report = report_of(id, unscaled(moved.origin), moved.cosine, moved.sine);
        report.velocity = unscaled(moved.velocity);
        report.angular_velocity = moved.spin;
        if (body.type == BodyType::kinematic_body) {
          report.velocity.x -= moved.spin * (report.center.y - report.origin.y);
          report.velocity.y += moved.spin * (report.center.x - report.origin.x);
        }
        reports.push_back(std::move(report));
      }
    }
    return reports;
  }

  std::vector<ContactReport> contacts() const override {
    std::vector<ContactReport> reports;
    for (const Box2d3Contact& contact : reported().contacts) {
      ContactReport report;
      report.body_a = contact.body_a;
      report.body_b = contact.body_b;
      report.normal = contact.normal;
      report.point_count = contact.point_count;
      for (int i = 0; i < contact.point_count; ++i) {
        report.point[i] = unscaled(contact.point[i]);
        report.separation[i] = contact.separation[i] / scale_;
        report.normal_force[i] = contact.force[i] / scale_;
      }
      reports.push_back(report);
    }
    return reports;
  }

  std::size_t body_count() const override { return bodies().size(); }
  std::size_t contact_count() const override { return reported().contacts.size(); }
  double length_scale() const override { return scale_; }
  double skin() const override { return 0; }
  std::size_t thin_shape_count() const override { return 0; }
  std::size_t clamped_tick() const override {
    return answer_.clamped_tick <= tick_ ? static_cast<std::size_t>(answer_.clamped_tick) : 0;
  }
  double ms_per_tick() const override { return answer_.ms_per_tick; }

 private:
  Point unscaled(const Point& p) const { return {p.x / scale_, p.y / scale_}; }

  const Box2d3Tick& reported() const {
    TICKTRUE_ASSERT(tick_ > 0 && tick_ % plan_.body_interval == 0);
    return answer_.ticks[static_cast<std::size_t>(tick_ / plan_.body_interval - 1)];
  }

  BodyReport report_of(std::size_t id, const Point& origin, double cosine, double sine) const {
    const engine::Body& body = scene_.bodies[id];
    const Point& center = masses_[id].center;
    BodyReport report;
    report.id = static_cast<std::uint32_t>(id);
    report.name = body.name;
    report.type = body.type;
    report.origin = origin;
    report.center = {origin.x + cosine * center.x - sine * center.y, origin.y + sine * center.x + cosine * center.y};
    report.angle = std::atan2(sine, cosine);
    report.mass = masses_[id].mass;
    report.inertia = masses_[id].inertia;
    report.shapes = &body.shapes;
    return report;
  }

  engine::Scene scene_;
  Box2d3Plan plan_;
  double scale_;
  Box2d3Answer answer_;
  std::vector<engine::MassProperties> masses_;  // by id
  std::uint64_t tick_ = 0;
};

}  // namespace

std::unique_ptr<Box2d3Peer> play_back(const engine::Scene& scene, const Box2d3Plan& plan, double length_scale,
                                      Box2d3Answer answer) {
  return std::make_unique<Box2d3Playback>(scene, plan, length_scale, std::move(answer));
}

}  // namespace ticktrue::tool
