// The inner loops of the contact solver: contacts of a batch side by side, as many as a vector register holds.
// SPDX-License-Identifier: MIT
// Source: Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005 (accumulated impulses); Catto, "Solver2D", 2024
// (soft contacts with relax). Each lane does the same operations in the same order at every vector width.
#include <span>
#include <type_traits>

#include "engine/constraints/contact_batch.h"
#include "engine/math/wide.h"
#include "engine/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Overlap is pushed out at most this fast, so that bodies created inside each other do not explode.
constexpr Real push_speed_max = 3;  // m/s

struct Velocities {
  Wide x, y, w;
};
struct Motions {
  Wide x, y, c, s;
};

std::span<ContactBatch> batches_of(Scratch& scratch, const SolveGroup& group) {
  return {scratch.contact_batches.batches.data() + group.first_batch, group.batch_end - group.first_batch};
}

/// wide_count contacts of a batch, starting at lane `first`.
struct Group {
  ContactBatch& batch;
  int first;

  Wide load(const Lanes& lanes) const { return load_wide(lanes.at + first); }
  void store(Lanes& lanes, Wide value) const { store_wide(lanes.at + first, value); }
};

Velocities gather_velocities(const MovingBody* bodies, const std::uint32_t* index) {
  Velocities v{};
  for (int i = 0; i < wide_count; ++i) {
    const MovingBody& body = bodies[index[i]];
    v.x[i] = body.velocity.x;
    v.y[i] = body.velocity.y;
    v.w[i] = body.angular_velocity;
  }
  return v;
}

Motions gather_motions(const MovingBody* bodies, const std::uint32_t* index) {
  Motions m{};
  for (int i = 0; i < wide_count; ++i) {
    const MovingBody& body = bodies[index[i]];
    m.x[i] = body.moved.x;
    m.y[i] = body.moved.y;
    m.c[i] = body.turned.c;
    m.s[i] = body.turned.s;
  }
  return m;
}

void scatter(MovingBody* bodies, const std::uint32_t* index, const Velocities& v) {
  for (int i = 0; i < wide_count; ++i) {
    MovingBody& body = bodies[index[i]];
    body.velocity.x = v.x[i];
    body.velocity.y = v.y[i];
    body.angular_velocity = v.w[i];
  }
}

/// The bodies' share of a contact: constants of a group, loaded once.
struct Masses {
  Wide inv_mass_a, inv_mass_b, inv_inertia_a, inv_inertia_b;
};

Masses load_masses(const Group& group) {
  return {group.load(group.batch.inv_mass_a), group.load(group.batch.inv_mass_b), group.load(group.batch.inv_inertia_a),
          group.load(group.batch.inv_inertia_b)};
}

struct Anchors {
  Wide ax, ay, bx, by;
};

Anchors load_anchors(const Group& group, const ContactPointLanes& point) {
  return {group.load(point.anchor_a_x), group.load(point.anchor_a_y), group.load(point.anchor_b_x),
          group.load(point.anchor_b_y)};
}

/// Adds impulse (px, py) at the point: -on A, +on B.
void apply(const Masses& masses, const Anchors& r, Wide px, Wide py, Velocities& a, Velocities& b) {
  a.x -= masses.inv_mass_a * px;
  a.y -= masses.inv_mass_a * py;
  a.w -= masses.inv_inertia_a * (r.ax * py - r.ay * px);
  b.x += masses.inv_mass_b * px;
  b.y += masses.inv_mass_b * py;
  b.w += masses.inv_inertia_b * (r.bx * py - r.by * px);
}

/// Velocity of B's point seen from A's, along (nx, ny).
Wide relative_velocity(const Anchors& r, const Velocities& a, const Velocities& b, Wide nx, Wide ny) {
  const Wide x = (b.x - b.w * r.by) - (a.x - a.w * r.ay);
  const Wide y = (b.y + b.w * r.bx) - (a.y + a.w * r.ax);
  return x * nx + y * ny;
}

template <Bias bias>
void solve_normal(const Group& group, const Masses& masses, ContactPointLanes& point, Wide nx, Wide ny,
                  const Motions& ma, const Motions& mb, Wide inv_h, Velocities& a, Velocities& b) {
  const Anchors r = load_anchors(group, point);
  // Present separation: the normal stays; what turns with the bodies are the pivots, a radius behind the anchors, since
  // the surface of a rolling disc stays where it is.
  const Wide radius_a = group.load(group.batch.radius_a);
  const Wide radius_b = group.load(group.batch.radius_b);
  const Wide pax = r.ax - radius_a * nx;
  const Wide pay = r.ay - radius_a * ny;
  const Wide pbx = r.bx + radius_b * nx;
  const Wide pby = r.by + radius_b * ny;
  const Wide dx = (mb.x - ma.x) + ((mb.c * pbx - mb.s * pby) - (ma.c * pax - ma.s * pay));
  const Wide dy = (mb.y - ma.y) + ((mb.s * pbx + mb.c * pby) - (ma.s * pax + ma.c * pay));
  const Wide separation = group.load(point.base_separation) + (dx * nx + dy * ny);

  // Apart: may close the gap within the substep, no more. Overlapping: pushed out softly, or (relax) not at all.
  const Wide zero{};
  const Wide one = spread(1);
  const auto apart = separation > zero;
  Wide target = apart ? separation * inv_h : zero;
  Wide mass_scale = one;
  Wide impulse_scale = zero;
  if constexpr (bias == Bias::on) {
    const Wide push = larger(group.load(group.batch.bias_rate) * separation, spread(-push_speed_max));
    target = apart ? target : push;
    mass_scale = apart ? one : group.load(group.batch.mass_scale);
    impulse_scale = apart ? zero : group.load(group.batch.impulse_scale);
  }
  const Wide vn = relative_velocity(r, a, b, nx, ny);
  const Wide old_impulse = group.load(point.normal_impulse);
  const Wide wanted =
      (old_impulse - group.load(point.normal_mass) * mass_scale * (vn + target)) - impulse_scale * old_impulse;
  const Wide impulse = larger(wanted, zero);
  group.store(point.normal_impulse, impulse);
  group.store(point.normal_impulse_max, larger(group.load(point.normal_impulse_max), impulse));
  const Wide change = impulse - old_impulse;
  apply(masses, r, change * nx, change * ny, a, b);
}

/// `surface`: null, or what the surfaces do by themselves.
template <typename Surface>
void solve_friction(const Group& group, const Masses& masses, ContactPointLanes& point, Wide nx, Wide ny,
                    Surface* surface, Velocities& a, Velocities& b) {
  const Anchors r = load_anchors(group, point);
  const Wide tx = ny;
  const Wide ty = -nx;
  Wide vt = relative_velocity(r, a, b, tx, ty);
  if constexpr (!std::is_same_v<Surface, void>) vt += group.load(surface->tangent_speed);
  const Wide old_impulse = group.load(point.tangent_impulse);
  const Wide limit = group.load(group.batch.friction) * group.load(point.normal_impulse);
  const Wide wanted = old_impulse - group.load(point.tangent_mass) * vt;
  const Wide impulse = larger(smaller(wanted, limit), -limit);
  group.store(point.tangent_impulse, impulse);
  const Wide change = impulse - old_impulse;
  apply(masses, r, change * tx, change * ty, a, b);
}

/// A torque against the relative turn, at most rolling resistance times normal force.
void solve_rolling(const Group& group, const Masses& masses, SurfaceLanes& surface, Velocities& a, Velocities& b) {
  const Wide pressed =
      group.load(group.batch.points[0].normal_impulse) + group.load(group.batch.points[1].normal_impulse);
  const Wide limit = group.load(surface.rolling_resistance) * pressed;
  const Wide old_impulse = group.load(surface.rolling_impulse);
  const Wide wanted = old_impulse - group.load(surface.rolling_mass) * (b.w - a.w);
  const Wide impulse = larger(smaller(wanted, limit), -limit);
  group.store(surface.rolling_impulse, impulse);
  const Wide change = impulse - old_impulse;
  a.w -= masses.inv_inertia_a * change;
  b.w += masses.inv_inertia_b * change;
}

/// Surface: void, or SurfaceLanes where materials of the scene need them.
template <Bias bias, typename Surface>
void solve_batches(Scratch& scratch, Surface* surface, const SolveGroup& group_of_batches) {
  MovingBody* bodies = scratch.bodies.data();
  const Wide inv_h = spread(1 / group_of_batches.h);
  for (ContactBatch& batch : batches_of(scratch, group_of_batches)) {
    for (int first = 0; first < batch.count; first += wide_count) {
      const Group group{batch, first};
      Velocities a = gather_velocities(bodies, batch.read_a + first);
      Velocities b = gather_velocities(bodies, batch.read_b + first);
      const Motions ma = gather_motions(bodies, batch.read_a + first);
      const Motions mb = gather_motions(bodies, batch.read_b + first);
      const Masses masses = load_masses(group);
      const Wide nx = group.load(batch.normal_x);
      const Wide ny = group.load(batch.normal_y);
      for (ContactPointLanes& point : batch.points)
        solve_normal<bias>(group, masses, point, nx, ny, ma, mb, inv_h, a, b);
      for (ContactPointLanes& point : batch.points) solve_friction(group, masses, point, nx, ny, surface, a, b);
      if constexpr (!std::is_same_v<Surface, void>) solve_rolling(group, masses, *surface, a, b);
      scatter(bodies, batch.write_a + first, a);
      scatter(bodies, batch.write_b + first, b);
    }
    if constexpr (!std::is_same_v<Surface, void>) ++surface;
  }
}

template <Bias bias>
void solve_all(Scratch& scratch, const SolveGroup& group) {
  std::vector<SurfaceLanes>& surfaces = scratch.contact_batches.surfaces;
  if (surfaces.empty())
    solve_batches<bias>(scratch, static_cast<void*>(nullptr), group);
  else
    solve_batches<bias>(scratch, surfaces.data() + group.first_batch, group);
}

}  // namespace

void warm_start_contacts(Scratch& scratch, const SolveGroup& group_of_batches) {
  for (SurfaceLanes& surface : scratch.contact_batches.surfaces) surface.rolling_impulse = {};
  MovingBody* bodies = scratch.bodies.data();
  for (ContactBatch& batch : batches_of(scratch, group_of_batches))
    for (int first = 0; first < batch.count; first += wide_count) {
      const Group group{batch, first};
      Velocities a = gather_velocities(bodies, batch.read_a + first);
      Velocities b = gather_velocities(bodies, batch.read_b + first);
      const Masses masses = load_masses(group);
      const Wide nx = group.load(batch.normal_x);
      const Wide ny = group.load(batch.normal_y);
      for (const ContactPointLanes& point : batch.points) {
        const Wide normal = group.load(point.normal_impulse);
        const Wide tangent = group.load(point.tangent_impulse);
        apply(masses, load_anchors(group, point), normal * nx + tangent * ny, normal * ny - tangent * nx, a, b);
      }
      scatter(bodies, batch.write_a + first, a);
      scatter(bodies, batch.write_b + first, b);
    }
}

void solve_contacts(Scratch& scratch, const SolveGroup& group, Bias bias) {
  if (bias == Bias::on)
    solve_all<Bias::on>(scratch, group);
  else
    solve_all<Bias::off>(scratch, group);
}

bool bounce_contacts(Scratch& scratch, const SolveGroup& group, Real threshold) {
  MovingBody* bodies = scratch.bodies.data();
  bool any = false;
  for (ContactBatch& batch : batches_of(scratch, group)) {
    if (!batch.bounces) continue;
    for (int lane = 0; lane < batch.count; ++lane) {
      if (batch.restitution.at[lane] == 0) continue;
      MovingBody& a = bodies[batch.read_a[lane]];
      MovingBody& b = bodies[batch.read_b[lane]];
      const Vec2 normal{batch.normal_x.at[lane], batch.normal_y.at[lane]};
      for (ContactPointLanes& point : batch.points) {
        // Newton's law of restitution: v_n after = -e v_n before, for points that approached and did push.
        if (point.approach.at[lane] > -threshold || point.normal_impulse_max.at[lane] == 0) continue;
        const Vec2 arm_a{point.anchor_a_x.at[lane], point.anchor_a_y.at[lane]};
        const Vec2 arm_b{point.anchor_b_x.at[lane], point.anchor_b_y.at[lane]};
        const Vec2 velocity_a = a.velocity + cross(a.angular_velocity, arm_a);
        const Vec2 velocity_b = b.velocity + cross(b.angular_velocity, arm_b);
        const Real vn = dot(velocity_b - velocity_a, normal);
        const Real old_impulse = point.normal_impulse.at[lane];
        const Real wanted =
            old_impulse - point.normal_mass.at[lane] * (vn + batch.restitution.at[lane] * point.approach.at[lane]);
        const Real impulse = larger(wanted, 0);
        point.normal_impulse.at[lane] = impulse;
        const Vec2 change = (impulse - old_impulse) * normal;
        if (batch.write_a[lane] == batch.read_a[lane]) {
          a.velocity = a.velocity - batch.inv_mass_a.at[lane] * change;
          a.angular_velocity -= batch.inv_inertia_a.at[lane] * cross(arm_a, change);
        }
        if (batch.write_b[lane] == batch.read_b[lane]) {
          b.velocity = b.velocity + batch.inv_mass_b.at[lane] * change;
          b.angular_velocity += batch.inv_inertia_b.at[lane] * cross(arm_b, change);
        }
        any = true;
      }
    }
  }
  return any;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
