// Colouring and packing of contacts, and the impulses carried from tick to tick.
// SPDX-License-Identifier: MIT
#include "engine/constraints/contact_batch.h"

#include "engine/constraints/bodies.h"
#include "engine/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr std::uint32_t round_color_count = 32;  // one bit each in a body's colour set
constexpr std::uint32_t uncolored = 0xffffffff;

/// Stiffness against the substep rate 1/h. Not a fixed frequency: with it the error falls as substeps^-2.
constexpr Real hertz_per_rate = Real(0.125);
constexpr Real contact_damping_ratio = 10;

/// Share of an overlap taken back per step. Source: Baumgarte, "Stabilization of Constraints", 1972.
constexpr Real baumgarte = Real(0.2);

bool moves(const Model& model, const State& state, std::uint32_t row) {
  return model.bodies[state.bodies[row].source].type == BodyType::dynamic_body;
}

/// Colours contacts between two moving bodies, or those with something immovable, from `first` on: 32 colours in a
/// round, and another round for contacts of bodies that have more. Returns the first colour that is not used.
std::uint32_t color_class(const Model& model, const State& state, Scratch& scratch, const SolveGroup& group,
                          bool against_immovable, std::uint32_t first) {
  ContactBatches& out = scratch.contact_batches;
  const std::uint32_t* contacts = scratch.group_contacts.data() + group.first_contact;
  for (bool left = true; left; first += round_color_count) {
    left = false;
    out.body_colors.assign(state.bodies.size(), 0);
    for (std::size_t i = 0; i < out.colors.size(); ++i) {
      if (out.colors[i] != uncolored) continue;
      const TouchingPair& pair = scratch.touching[contacts[i]];
      const bool a_moves = moves(model, state, pair.body_a);
      const bool b_moves = moves(model, state, pair.body_b);
      if ((a_moves && b_moves) == against_immovable) continue;
      const std::uint32_t used =
          (a_moves ? out.body_colors[pair.body_a] : 0u) | (b_moves ? out.body_colors[pair.body_b] : 0u);
      if (used == 0xffffffffu) {
        left = true;
        continue;
      }
      const auto color = static_cast<std::uint32_t>(__builtin_ctz(~used));
      if (a_moves) out.body_colors[pair.body_a] |= 1u << color;
      if (b_moves) out.body_colors[pair.body_b] |= 1u << color;
      out.colors[i] = first + color;
    }
  }
  return first;
}

/// What the colours of a group are: below `immovable` those between two moving bodies. They come first, those with
/// something immovable last: the last ones solved are met best, and nothing may sink into the ground.
struct ColorCounts {
  std::uint32_t immovable;
  std::uint32_t all;
};

/// colors[i]: of the i-th contact of the group.
ColorCounts color_contacts(const Model& model, const State& state, Scratch& scratch, const SolveGroup& group) {
  scratch.contact_batches.colors.assign(group.contact_end - group.first_contact, uncolored);
  const std::uint32_t immovable = color_class(model, state, scratch, group, false, 0);
  return {immovable, color_class(model, state, scratch, group, true, immovable)};
}

void fill_point(ContactBatch& batch, int lane, int index, const ManifoldPoint& point, const ContactRow& row,
                const MovingBody& body_a, const MovingBody& body_b, Vec2 normal, Real slop, Real h) {
  ContactPointLanes& out = batch.points[index];
  const Vec2 tangent = right_turn(normal);
  const auto effective_mass = [&](Vec2 direction) {
    const Real arm_a = cross(point.anchor_a, direction);
    const Real arm_b = cross(point.anchor_b, direction);
    const Real k =
        ((batch.inv_mass_a.at[lane] + batch.inv_mass_b.at[lane]) + batch.inv_inertia_a.at[lane] * arm_a * arm_a) +
        batch.inv_inertia_b.at[lane] * arm_b * arm_b;
    return k > 0 ? 1 / k : Real(0);
  };
  out.anchor_a_x.at[lane] = point.anchor_a.x;
  out.anchor_a_y.at[lane] = point.anchor_a.y;
  out.anchor_b_x.at[lane] = point.anchor_b.x;
  out.anchor_b_y.at[lane] = point.anchor_b.y;
  out.base_separation.at[lane] = ((point.separation + slop) - dot(point.anchor_b - point.anchor_a, normal)) -
                                 (batch.radius_a.at[lane] + batch.radius_b.at[lane]);
  out.normal_mass.at[lane] = effective_mass(normal);
  out.tangent_mass.at[lane] = effective_mass(tangent);
  out.normal_impulse.at[lane] = h * row.normal_force[index];
  out.tangent_impulse.at[lane] = h * row.tangent_force[index];
  const Vec2 velocity_a = body_a.velocity + cross(body_a.angular_velocity, point.anchor_a);
  const Vec2 velocity_b = body_b.velocity + cross(body_b.angular_velocity, point.anchor_b);
  out.approach.at[lane] = dot(velocity_b - velocity_a, normal);
}

void fill_surface(SurfaceLanes& out, int lane, const TouchingPair& pair, Real inv_inertia) {
  out.tangent_speed.at[lane] = pair.tangent_speed;
  out.rolling_resistance.at[lane] = pair.rolling_resistance;
  out.rolling_mass.at[lane] = inv_inertia > 0 ? 1 / inv_inertia : Real(0);
}

}  // namespace

Real soft_contact_stiffness(Real h) {
  const Real omega = Real(2 * pi) * hertz_per_rate / h;
  return omega * omega;
}

ContactStiffness soft_contacts(Real h) {
  const Real hertz = hertz_per_rate / h;
  return {make_soft(hertz, contact_damping_ratio, h), make_soft(2 * hertz, contact_damping_ratio, h), 0};
}

ContactStiffness baumgarte_contacts(Real h) {
  const Softness rigid{baumgarte / h, 1, 0};
  return {rigid, rigid, Real(0.005)};
}

void clear_contacts(Scratch& scratch) {
  scratch.contact_batches.batches.clear();
  scratch.contact_batches.surfaces.clear();
}

void prepare_contacts(const Model& model, const State& state, Scratch& scratch, SolveGroup& group,
                      const ContactStiffness& stiffness) {
  const ColorCounts colors = color_contacts(model, state, scratch, group);
  ContactBatches& out = scratch.contact_batches;
  const std::uint32_t* contacts = scratch.group_contacts.data() + group.first_contact;
  const Real h = group.h;

  // Contacts by colour, in contact order within a colour.
  std::vector<std::uint32_t>& start = out.color_start;
  start.assign(colors.all + 1, 0);
  for (const std::uint32_t color : out.colors) ++start[color + 1];
  std::size_t batch_count = 0;
  for (std::uint32_t color = 0; color < colors.all; ++color) {
    batch_count += (start[color + 1] + lane_count - 1) / lane_count;
    start[color + 1] += start[color];
  }
  out.color_next.assign(start.begin(), start.end());
  out.sorted.resize(out.colors.size());
  for (std::uint32_t i = 0; i < out.colors.size(); ++i) out.sorted[out.color_next[out.colors[i]]++] = contacts[i];

  const std::uint32_t resting = resting_record(scratch);
  const std::uint32_t unread = unread_record(scratch);

  std::size_t next = out.batches.size();
  group.first_batch = static_cast<std::uint32_t>(next);
  group.batch_end = static_cast<std::uint32_t>(next + batch_count);
  out.batches.resize(next + batch_count);
  out.surfaces.resize(model.has_surfaces ? next + batch_count : 0);
  for (std::uint32_t color = 0; color < colors.all; ++color) {
    for (std::uint32_t begin = start[color]; begin < start[color + 1]; begin += lane_count) {
      ContactBatch& batch = out.batches[next++];
      const std::uint32_t left = start[color + 1] - begin;
      batch.count = static_cast<int>(left < lane_count ? left : lane_count);
      batch.bounces = false;
      for (int lane = 0; lane < lane_count; ++lane) {
        if (lane >= batch.count) {
          batch.read_a[lane] = batch.read_b[lane] = resting;
          batch.write_a[lane] = batch.write_b[lane] = unread;
          continue;
        }
        const std::uint32_t contact = out.sorted[begin + static_cast<std::uint32_t>(lane)];
        const TouchingPair& pair = scratch.touching[contact];
        const BodyModel& a = model.bodies[state.bodies[pair.body_a].source];
        const BodyModel& b = model.bodies[state.bodies[pair.body_b].source];
        batch.contact[lane] = contact;
        batch.read_a[lane] = a.type == BodyType::static_body ? resting : pair.body_a;
        batch.read_b[lane] = b.type == BodyType::static_body ? resting : pair.body_b;
        batch.write_a[lane] = a.type == BodyType::dynamic_body ? pair.body_a : unread;
        batch.write_b[lane] = b.type == BodyType::dynamic_body ? pair.body_b : unread;
        batch.inv_mass_a.at[lane] = a.inv_mass;
        batch.inv_mass_b.at[lane] = b.inv_mass;
        batch.inv_inertia_a.at[lane] = a.inv_inertia;
        batch.inv_inertia_b.at[lane] = b.inv_inertia;
        batch.normal_x.at[lane] = pair.manifold.normal.x;
        batch.normal_y.at[lane] = pair.manifold.normal.y;
        batch.friction.at[lane] = pair.friction;
        batch.radius_a.at[lane] = pair.radius_a;
        batch.radius_b.at[lane] = pair.radius_b;
        batch.restitution.at[lane] = pair.restitution;
        batch.bounces |= pair.restitution > 0;
        const Softness& softness = color >= colors.immovable ? stiffness.immovable : stiffness.moving;
        batch.bias_rate.at[lane] = softness.bias_rate;
        batch.mass_scale.at[lane] = softness.mass_scale;
        batch.impulse_scale.at[lane] = softness.impulse_scale;
        if (model.has_surfaces) fill_surface(out.surfaces[next - 1], lane, pair, a.inv_inertia + b.inv_inertia);
        const Real slop = stiffness.slop * pair.size;
        for (int i = 0; i < pair.manifold.point_count; ++i)
          fill_point(batch, lane, i, pair.manifold.points[i], state.contacts[contact],
                     scratch.bodies[batch.read_a[lane]], scratch.bodies[batch.read_b[lane]], pair.manifold.normal, slop,
                     h);
      }
    }
  }
}

void save_impulses(Scratch& scratch, const SolveGroup& group) {
  ContactBatches& out = scratch.contact_batches;
  out.saved.clear();
  for (std::uint32_t i = group.first_batch; i < group.batch_end; ++i)
    for (const ContactPointLanes& point : out.batches[i].points) out.saved.push_back(point.normal_impulse);
}

void limit_impulses(Scratch& scratch, const SolveGroup& group) {
  ContactBatches& out = scratch.contact_batches;
  std::size_t next = 0;
  for (std::uint32_t i = group.first_batch; i < group.batch_end; ++i)
    for (ContactPointLanes& point : out.batches[i].points) {
      const Lanes& saved = out.saved[next++];
      for (int lane = 0; lane < lane_count; ++lane) {
        point.normal_impulse.at[lane] = smaller(point.normal_impulse.at[lane], saved.at[lane]);
        const Real limit = out.batches[i].friction.at[lane] * point.normal_impulse.at[lane];
        point.tangent_impulse.at[lane] = larger(smaller(point.tangent_impulse.at[lane], limit), -limit);
      }
    }
}

void store_contacts(const Scratch& scratch, const SolveGroup& group, State& state) {
  const Real inv_h = 1 / group.h;
  for (std::uint32_t i = group.first_batch; i < group.batch_end; ++i) {
    const ContactBatch& batch = scratch.contact_batches.batches[i];
    for (int lane = 0; lane < batch.count; ++lane) {
      ContactRow& row = state.contacts[batch.contact[lane]];
      for (int p = 0; p < 2; ++p) {
        row.normal_force[p] = inv_h * batch.points[p].normal_impulse.at[lane];
        row.tangent_force[p] = inv_h * batch.points[p].tangent_impulse.at[lane];
      }
    }
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
