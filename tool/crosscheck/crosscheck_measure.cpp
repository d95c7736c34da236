// Measures bodies and contacts of one run, and reduces them to the quantities of the criteria.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/math/trig.h"
#include "tool/crosscheck/crosscheck.h"
#include "tool/crosscheck/statics.h"
#include "tool/drawing/joint_geometry.h"

namespace ticktrue::tool {
namespace {

using engine::BodyReport;
using engine::ContactReport;
using engine::Point;

// Limits within which a placed body counts as standing.
constexpr double standing_tilt_max_deg = 15;
constexpr double standing_move_max = 0.5;  // of its width across, of its height up or down
constexpr double stood_share = 0.98;       // of the placed bodies: the structure counts as standing
constexpr double tilt_shown_max_deg = 45;  // a body with a larger tilt has toppled; how far it rolled on means nothing
constexpr double place_speed_max = 0.05;   // m/s: a body that stays slower for place_time_s has come to rest
constexpr double place_time_s = 1;
constexpr double level_share = 0.02;  // largest sideways share of the ground force in level contacts

double along(const Point& p, const Point& direction) {
  return p.x * direction.x + p.y * direction.y;
}

double force_of(const ContactReport& contact) {
  double force = 0;
  for (int i = 0; i < contact.point_count; ++i) force += contact.normal_force[i];
  return force;
}

double tilt_of(const BodyReport& body, const CrosscheckBody& start) {
  return std::fabs(std::remainder(body.angle - start.angle, 2 * engine::pi)) * 180 / engine::pi;
}

double mixed(engine::MixRule rule, double a, double b) {
  switch (rule) {
    case engine::MixRule::geometric_mean:
      return std::sqrt(a * b);
    case engine::MixRule::maximum:
      return std::max(a, b);
    case engine::MixRule::minimum:
      return std::min(a, b);
    case engine::MixRule::average:
      return (a + b) / 2;
  }
  return 0;
}

double inverse(double value) {
  return value > 0 ? 1 / value : 0;
}

// The report of each body by id; null for an absent body.
std::vector<const BodyReport*> by_id(const std::vector<BodyReport>& bodies, std::size_t count) {
  std::vector<const BodyReport*> found(count, nullptr);
  for (const BodyReport& body : bodies)
    if (body.id < count) found[body.id] = &body;
  return found;
}

}  // namespace

CrosscheckMeasure::CrosscheckMeasure(const CrosscheckLayout& layout, double contact_hertz, double skin)
    : layout_(layout),
      contact_hertz_(contact_hertz),
      skin_(skin),
      moving_until_s_(layout.bodies.size(), 0),
      fast_until_s_(layout.bodies.size(), 0),
      toppled_(layout.bodies.size(), false),
      carried_sum_(layout.bodies.size(), 0) {}

void CrosscheckMeasure::add(double time_s, const std::vector<BodyReport>& bodies,
                            const std::vector<ContactReport>* contacts) {
  time_s_ = time_s;
  for (const BodyReport& body : bodies) {
    if (body.id >= layout_.bodies.size() || !layout_.bodies[body.id].is_dynamic) continue;
    const double sum =
        body.center.x + body.center.y + body.angle + body.velocity.x + body.velocity.y + body.angular_velocity;
    if (!std::isfinite(sum)) is_finite_ = false;
    const CrosscheckBody& start = layout_.bodies[body.id];
    if (start.is_placed && start.shows_tilt && tilt_of(body, start) >= tilt_shown_max_deg) toppled_[body.id] = true;
    const double spin_speed = std::fabs(body.angular_velocity) * layout_.bodies[body.id].width / 2;
    const double speed = std::hypot(body.velocity.x, body.velocity.y);
    if (speed + spin_speed > layout_.rest_speed) moving_until_s_[body.id] = time_s;
    if (speed > place_speed_max) fast_until_s_[body.id] = time_s;
  }
  last_bodies_ = bodies;
  if (contacts && layout_.jointed)
    for (const double gap : joint_gaps(*layout_.jointed, bodies)) joint_gap_ = std::max(joint_gap_, gap);
  if (contacts && is_finite_) add_contacts(bodies, *contacts);
}

void CrosscheckMeasure::add_contacts(const std::vector<BodyReport>& bodies,
                                     const std::vector<ContactReport>& contacts) {
  const std::size_t count = layout_.bodies.size();
  const std::vector<const BodyReport*> found = by_id(bodies, count);
  const double stiffness_per_kg = 2 * engine::pi * contact_hertz_ * 2 * engine::pi * contact_hertz_;  // 1/s^2
  double deepest = 0;
  double deepest_unexplained = 0;
  for (const ContactReport& contact : contacts) {
    if (contact.body_a >= count || contact.body_b >= count) continue;
    const BodyReport* a = found[contact.body_a];
    const BodyReport* b = found[contact.body_b];
    if (!a || !b) continue;
    const CrosscheckBody& start_a = layout_.bodies[contact.body_a];
    const CrosscheckBody& start_b = layout_.bodies[contact.body_b];
    double size = std::numeric_limits<double>::infinity();
    for (const CrosscheckBody* body : {&start_a, &start_b})
      if (body->is_dynamic) size = std::min(size, std::min(body->width, body->height));
    for (int i = 0; i < contact.point_count; ++i) {
      const double overlap = -contact.separation[i];
      // A soft contact yields by force / (stiffness per kg * effective mass of the contact point).
      const Point arm_a{contact.point[i].x - a->center.x, contact.point[i].y - a->center.y};
      const Point arm_b{contact.point[i].x - b->center.x, contact.point[i].y - b->center.y};
      const double lever_a = arm_a.x * contact.normal.y - arm_a.y * contact.normal.x;
      const double lever_b = arm_b.x * contact.normal.y - arm_b.y * contact.normal.x;
      const double inverse_mass = inverse(a->mass) + inverse(b->mass) + lever_a * lever_a * inverse(a->inertia) +
                                  lever_b * lever_b * inverse(b->inertia);
      const double give = stiffness_per_kg > 0 ? contact.normal_force[i] * inverse_mass / stiffness_per_kg : 0;
      deepest = std::max(deepest, overlap / size);
      deepest_unexplained = std::max(deepest_unexplained, (overlap - give) / size);
    }

    const double force = force_of(contact);
    const double normal_up = along(contact.normal, layout_.up);
    if (start_a.is_dynamic != start_b.is_dynamic) {
      ground_up_sum_ += start_b.is_dynamic ? force * normal_up : -force * normal_up;
      ground_side_sum_ += force * std::fabs(along(contact.normal, layout_.right));
      ground_all_sum_ += force;
    }
    const auto carries = [&](std::uint32_t support, std::uint32_t body) {
      const std::vector<std::uint32_t>& supports = layout_.bodies[body].supports;
      return layout_.bodies[body].is_dynamic && supports.size() == 1 && supports.front() == support;
    };
    if (carries(contact.body_a, contact.body_b)) carried_sum_[contact.body_b] += force * normal_up;
    if (carries(contact.body_b, contact.body_a)) carried_sum_[contact.body_a] -= force * normal_up;
  }
  penetration_sum_ += deepest;
  penetration_unexplained_sum_ += deepest_unexplained;
  ++contact_sample_count_;
  last_contacts_ = contacts;
}

CrosscheckRun CrosscheckMeasure::finish() const {
  CrosscheckRun run;
  run.is_finite = is_finite_;
  if (!is_finite_) return run;
  const std::size_t count = layout_.bodies.size();
  const std::vector<const BodyReport*> found = by_id(last_bodies_, count);

  std::vector<double> across(count, 0);  // distance travelled
  std::vector<bool> present(count, false);
  std::vector<double> settled;
  std::size_t support_count = 0;
  std::size_t ordered_count = 0;
  run.top = -std::numeric_limits<double>::infinity();
  for (std::size_t id = 0; id < count; ++id) {
    const CrosscheckBody& start = layout_.bodies[id];
    if (!start.is_dynamic) continue;
    const BodyReport* body = found[id];
    if (body) {
      const double up = along(body->center, layout_.up);
      present[id] = true;
      across[id] = along(body->center, layout_.right) - start.across;
      run.top = std::max(run.top, up - layout_.base);
      run.travel.push_back(std::fabs(across[id]));
      settled.push_back(moving_until_s_[id]);
      if (start.is_placed) {
        const double tilt = start.shows_tilt ? tilt_of(*body, start) : 0;
        run.tilt_deg = std::max(run.tilt_deg, toppled_[id] ? tilt_shown_max_deg : tilt);
        run.toppled = run.toppled || toppled_[id];
        const double sunk = up - (start.up - (std::isfinite(start.drop) ? start.drop : 0));
        if (tilt <= standing_tilt_max_deg && std::fabs(across[id]) <= standing_move_max * start.width &&
            std::fabs(sunk) <= standing_move_max * start.height)
          ++run.standing_count;
      }
    } else if (start.is_placed) {
      run.tilt_deg = tilt_shown_max_deg;  // the body has left the bounds
    }
    for (const std::uint32_t support : start.supports) {
      if (!layout_.bodies[support].is_dynamic) continue;
      ++support_count;
      if (!body || !found[support]) continue;
      const double distance = (start.height + layout_.bodies[support].height) / 2;
      if (along(body->center, layout_.up) - along(found[support]->center, layout_.up) > 0.25 * distance)
        ++ordered_count;
    }
  }
  run.stood = layout_.placed_count > 0 &&
              static_cast<double>(run.standing_count) >= stood_share * static_cast<double>(layout_.placed_count);
  run.order = support_count > 0 ? static_cast<double>(ordered_count) / static_cast<double>(support_count) : 1;
  if (run.travel.empty()) run.top = 0;

  // The structure is at rest when nineteen of twenty bodies are. One disc that rolls for ever must not decide for a
  // thousand bodies.
  std::sort(settled.begin(), settled.end());
  if (!settled.empty()) {
    const std::size_t index = (settled.size() - 1) - settled.size() / 20;
    run.settle_s = settled[index];
    const bool still_moving = run.settle_s > 0.98 * time_s_;
    if (still_moving) run.settle_s = std::numeric_limits<double>::infinity();
  }

  run.joint_gap = joint_gap_;
  if (contact_sample_count_ > 0) {
    const double samples = static_cast<double>(contact_sample_count_);
    run.penetration = penetration_sum_ / samples;
    run.penetration_unexplained = penetration_unexplained_sum_ / samples;
    double weight = 0;
    for (std::size_t id = 0; id < count; ++id)
      if (present[id]) weight += layout_.bodies[id].weight;
    run.ground_force = weight > 0 ? ground_up_sum_ / samples / weight : 0;
    run.ground_is_flat = ground_all_sum_ > 0 && ground_side_sum_ <= level_share * ground_all_sum_;
  }
  if (layout_.is_column && contact_sample_count_ > 0) {
    std::vector<double> load(count, 0);  // N, weight of the body and of all bodies above
    for (std::size_t id = 0; id < count; ++id) {
      if (!layout_.bodies[id].is_dynamic) continue;
      std::size_t under = id;
      while (layout_.bodies[under].is_dynamic) {
        load[under] += layout_.bodies[id].weight;
        under = layout_.bodies[under].supports.front();
      }
    }
    for (std::size_t id = 0; id < count; ++id)
      if (layout_.bodies[id].is_dynamic)
        run.column_error =
            std::max(run.column_error,
                     std::fabs(carried_sum_[id] / static_cast<double>(contact_sample_count_) - load[id]) / load[id]);
  }

  run.balances = run.stood && balances(found);
  measure_chains(run);
  measure_places(run, found);
  close_rows(run, across, present);
  std::sort(run.travel.begin(), run.travel.end());
  return run;
}

bool CrosscheckMeasure::balances(const std::vector<const BodyReport*>& found) const {
  if (!layout_.has_weight_alone || !layout_.is_structure) return false;
  std::vector<StaticBody> bodies(layout_.bodies.size());
  for (std::size_t id = 0; id < bodies.size(); ++id) {
    const CrosscheckBody& start = layout_.bodies[id];
    if (!start.is_dynamic || !found[id]) continue;  // what has left carries and weighs nothing
    const Point weight{-start.weight * layout_.up.x, -start.weight * layout_.up.y};
    bodies[id] = {true, found[id]->center, weight, std::min(start.width, start.height)};
  }
  std::vector<StaticContact> points;
  for (const ContactReport& contact : last_contacts_) {
    if (contact.body_a >= bodies.size() || contact.body_b >= bodies.size()) continue;
    const double friction =
        mixed(layout_.friction_mix, layout_.bodies[contact.body_a].friction, layout_.bodies[contact.body_b].friction);
    for (int i = 0; i < contact.point_count; ++i)
      if (contact.normal_force[i] > 0)
        points.push_back({contact.body_a, contact.body_b, contact.point[i], contact.normal, friction});
  }
  return can_balance(bodies, points);
}

// The body that carries most of each body's weight from below, by id.
std::vector<CrosscheckMeasure::Carrier> CrosscheckMeasure::find_carriers() const {
  const std::size_t count = layout_.bodies.size();
  std::vector<Carrier> carriers(count);
  const auto upper_of = [&](const ContactReport& contact) {
    const double normal_up = along(contact.normal, layout_.up);
    const bool is_known = contact.body_a < count && contact.body_b < count && contact.point_count > 0;
    if (!is_known || std::fabs(normal_up) < 0.5) return count;  // side by side
    return std::size_t{normal_up > 0 ? contact.body_b : contact.body_a};
  };
  for (const ContactReport& contact : last_contacts_) {
    const std::size_t upper = upper_of(contact);
    if (upper == count) continue;
    const double force = force_of(contact) * std::fabs(along(contact.normal, layout_.up));
    if (force <= carriers[upper].force) continue;
    carriers[upper].force = force;
    carriers[upper].body = contact.body_a == upper ? contact.body_b : contact.body_a;
  }
  // A pair of bodies with several shapes may have several contacts.
  for (const ContactReport& contact : last_contacts_) {
    const std::size_t upper = upper_of(contact);
    if (upper == count) continue;
    Carrier& carrier = carriers[upper];
    if (carrier.body != (contact.body_a == upper ? contact.body_b : contact.body_a)) continue;
    for (int i = 0; i < contact.point_count; ++i)
      carrier.gap_sum += contact.separation[i] * std::fabs(along(contact.normal, layout_.up));
    carrier.point_count += contact.point_count;
  }
  return carriers;
}

// Follows the strongest support downwards, in at most as many steps as there are bodies.
CrosscheckMeasure::Chain CrosscheckMeasure::follow_chain(std::size_t body, const std::vector<Carrier>& carriers) const {
  Chain chain;
  const std::size_t count = layout_.bodies.size();
  while (body < count && layout_.bodies[body].is_dynamic && chain.count < count) {
    const Carrier& carrier = carriers[body];
    if (carrier.point_count == 0) return chain;
    const double gap = carrier.gap_sum / carrier.point_count;
    chain.gap += gap;
    chain.gap_max = std::max(chain.gap_max, gap);
    ++chain.count;
    body = carrier.body;
  }
  chain.ends_on_ground = body < count && !layout_.bodies[body].is_dynamic && chain.count > 0;
  return chain;
}

void CrosscheckMeasure::measure_chains(CrosscheckRun& run) const {
  const std::size_t count = layout_.bodies.size();
  std::size_t highest = count;
  double top = -std::numeric_limits<double>::infinity();
  for (const BodyReport& report : last_bodies_) {
    if (report.id >= count || !layout_.bodies[report.id].is_dynamic) continue;
    if (const double up = along(report.center, layout_.up); up > top) {
      top = up;
      highest = report.id;
    }
  }
  const Chain chain = follow_chain(highest, find_carriers());
  run.has_chain = chain.ends_on_ground;
  run.chain_count = chain.count;
  run.chain_gap = chain.gap;
  run.chain_gap_max = chain.gap_max;
}

void CrosscheckMeasure::measure_places(CrosscheckRun& run, const std::vector<const BodyReport*>& found) const {
  const std::vector<Carrier> carriers = find_carriers();
  run.places.resize(layout_.bodies.size());
  for (std::size_t id = 0; id < layout_.bodies.size(); ++id) {
    const CrosscheckBody& start = layout_.bodies[id];
    if (!start.is_dynamic || !found[id]) continue;
    CrosscheckPlace& place = run.places[id];
    place.is_left = true;
    place.rests = fast_until_s_[id] < time_s_ - place_time_s;
    place.across = along(found[id]->center, layout_.right);
    place.up = along(found[id]->center, layout_.up);
    place.moved = std::hypot(place.across - start.across, place.up - start.up);
    const Chain chain = follow_chain(id, carriers);
    if (!chain.ends_on_ground) continue;
    place.chain_gap = chain.gap;
    place.chain_gap_max = chain.gap_max;
  }
}

// Removes the gaps that the skin opened between the bodies of each row, and keeps the middle of the row in place.
void CrosscheckMeasure::close_rows(CrosscheckRun& run, const std::vector<double>& across,
                                   const std::vector<bool>& present) const {
  std::vector<double> closed = across;
  for (const std::vector<std::uint32_t>& row : layout_.body_rows) {
    std::vector<double> opened(row.size(), 0);
    for (std::size_t i = 1; i < row.size(); ++i) {
      const bool both = present[row[i]] && present[row[i - 1]];
      opened[i] = opened[i - 1] + (both ? std::clamp(across[row[i]] - across[row[i - 1]], 0.0, skin_) : 0);
    }
    double middle = 0;
    for (const double sum : opened) middle += sum / static_cast<double>(row.size());
    for (std::size_t i = 0; i < row.size(); ++i) closed[row[i]] -= opened[i] - middle;
  }
  for (std::size_t id = 0; id < closed.size(); ++id)
    if (present[id]) run.travel_closed.push_back(std::fabs(closed[id]));
  std::sort(run.travel_closed.begin(), run.travel_closed.end());
}

}  // namespace ticktrue::tool
