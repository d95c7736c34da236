// The inner loops of the contact solver: eight contacts side by side, plain loops that compilers turn into vectors.
// SPDX-License-Identifier: MIT
// Source: Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005 (accumulated impulses); Catto, "Solver2D", 2024
// (soft contacts with relax). Each lane does the same operations in the same order at every vector width.
#include "engine/constraints/contact_batch.h"
#include "engine/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Overlap is pushed out at most this fast, so that bodies created inside each other do not explode.
constexpr Real push_speed_max = 3;  // m/s

struct Velocities {
  Lanes x, y, w;
};
struct Motions {
  Lanes x, y, c, s;
};

inline void gather(const MovingBody* bodies, const std::uint32_t* index, Velocities& v) {
  for (int i = 0; i < lane_count; ++i) {
    const MovingBody& body = bodies[index[i]];
    v.x.at[i] = body.velocity.x;
    v.y.at[i] = body.velocity.y;
    v.w.at[i] = body.angular_velocity;
  }
}

inline void gather(const MovingBody* bodies, const std::uint32_t* index, Velocities& v, Motions& m) {
  for (int i = 0; i < lane_count; ++i) {
    const MovingBody& body = bodies[index[i]];
    v.x.at[i] = body.velocity.x;
    v.y.at[i] = body.velocity.y;
    v.w.at[i] = body.angular_velocity;
    m.x.at[i] = body.moved.x;
    m.y.at[i] = body.moved.y;
    m.c.at[i] = body.turned.c;
    m.s.at[i] = body.turned.s;
  }
}

inline void scatter(MovingBody* bodies, const std::uint32_t* index, const Velocities& v) {
  for (int i = 0; i < lane_count; ++i) {
    MovingBody& body = bodies[index[i]];
    body.velocity.x = v.x.at[i];
    body.velocity.y = v.y.at[i];
    body.angular_velocity = v.w.at[i];
  }
}

/// Adds impulse (px, py) at the point: -on A, +on B.
inline void apply(const ContactBatch& batch, const ContactPointLanes& point, int i, Real px, Real py, Velocities& a,
                  Velocities& b) {
  a.x.at[i] -= batch.inv_mass_a.at[i] * px;
  a.y.at[i] -= batch.inv_mass_a.at[i] * py;
  a.w.at[i] -= batch.inv_inertia_a.at[i] * (point.anchor_a_x.at[i] * py - point.anchor_a_y.at[i] * px);
  b.x.at[i] += batch.inv_mass_b.at[i] * px;
  b.y.at[i] += batch.inv_mass_b.at[i] * py;
  b.w.at[i] += batch.inv_inertia_b.at[i] * (point.anchor_b_x.at[i] * py - point.anchor_b_y.at[i] * px);
}

inline Real relative_velocity_x(const ContactPointLanes& point, int i, const Velocities& a, const Velocities& b) {
  return (b.x.at[i] - b.w.at[i] * point.anchor_b_y.at[i]) - (a.x.at[i] - a.w.at[i] * point.anchor_a_y.at[i]);
}
inline Real relative_velocity_y(const ContactPointLanes& point, int i, const Velocities& a, const Velocities& b) {
  return (b.y.at[i] + b.w.at[i] * point.anchor_b_x.at[i]) - (a.y.at[i] + a.w.at[i] * point.anchor_a_x.at[i]);
}

template <Bias bias>
void solve_batches(Scratch& scratch, Real h) {
  MovingBody* bodies = scratch.bodies.data();
  const Real inv_h = 1 / h;
  for (ContactBatch& batch : scratch.contact_batches.batches) {
    Velocities a, b;
    Motions ma, mb;
    gather(bodies, batch.read_a, a, ma);
    gather(bodies, batch.read_b, b, mb);
    for (ContactPointLanes& point : batch.points) {
      for (int i = 0; i < lane_count; ++i) {
        const Real nx = batch.normal_x.at[i];
        const Real ny = batch.normal_y.at[i];
        // Present separation: the anchors turn with their bodies, the normal stays.
        const Real ax = ma.c.at[i] * point.anchor_a_x.at[i] - ma.s.at[i] * point.anchor_a_y.at[i];
        const Real ay = ma.s.at[i] * point.anchor_a_x.at[i] + ma.c.at[i] * point.anchor_a_y.at[i];
        const Real bx = mb.c.at[i] * point.anchor_b_x.at[i] - mb.s.at[i] * point.anchor_b_y.at[i];
        const Real by = mb.s.at[i] * point.anchor_b_x.at[i] + mb.c.at[i] * point.anchor_b_y.at[i];
        const Real dx = (mb.x.at[i] - ma.x.at[i]) + (bx - ax);
        const Real dy = (mb.y.at[i] - ma.y.at[i]) + (by - ay);
        const Real separation = point.base_separation.at[i] + (dx * nx + dy * ny);

        // Apart: may close the gap within the substep, no more. Overlapping: pushed out softly, or (relax) not at all.
        const Real push = batch.bias_rate.at[i] * separation;
        const Real soft_bias = bias == Bias::on ? (push > -push_speed_max ? push : -push_speed_max) : Real(0);
        const Real target = separation > 0 ? separation * inv_h : soft_bias;
        const Real mass_scale = separation > 0 || bias == Bias::off ? Real(1) : batch.mass_scale.at[i];
        const Real impulse_scale = separation > 0 || bias == Bias::off ? Real(0) : batch.impulse_scale.at[i];

        const Real vn = relative_velocity_x(point, i, a, b) * nx + relative_velocity_y(point, i, a, b) * ny;
        const Real old_impulse = point.normal_impulse.at[i];
        const Real wanted =
            (old_impulse - point.normal_mass.at[i] * mass_scale * (vn + target)) - impulse_scale * old_impulse;
        const Real impulse = wanted > 0 ? wanted : Real(0);
        point.normal_impulse.at[i] = impulse;
        point.normal_impulse_max.at[i] = larger(point.normal_impulse_max.at[i], impulse);
        const Real change = impulse - old_impulse;
        apply(batch, point, i, change * nx, change * ny, a, b);
      }
    }
    for (ContactPointLanes& point : batch.points) {
      for (int i = 0; i < lane_count; ++i) {
        const Real tx = batch.normal_y.at[i];
        const Real ty = -batch.normal_x.at[i];
        const Real vt = relative_velocity_x(point, i, a, b) * tx + relative_velocity_y(point, i, a, b) * ty;
        const Real old_impulse = point.tangent_impulse.at[i];
        const Real limit = batch.friction.at[i] * point.normal_impulse.at[i];
        const Real wanted = old_impulse - point.tangent_mass.at[i] * vt;
        const Real bounded = wanted < limit ? wanted : limit;
        const Real impulse = bounded > -limit ? bounded : -limit;
        point.tangent_impulse.at[i] = impulse;
        const Real change = impulse - old_impulse;
        apply(batch, point, i, change * tx, change * ty, a, b);
      }
    }
    scatter(bodies, batch.write_a, a);
    scatter(bodies, batch.write_b, b);
  }
}

}  // namespace

void warm_start_contacts(Scratch& scratch) {
  MovingBody* bodies = scratch.bodies.data();
  for (ContactBatch& batch : scratch.contact_batches.batches) {
    Velocities a, b;
    gather(bodies, batch.read_a, a);
    gather(bodies, batch.read_b, b);
    for (const ContactPointLanes& point : batch.points)
      for (int i = 0; i < lane_count; ++i) {
        const Real normal = point.normal_impulse.at[i];
        const Real tangent = point.tangent_impulse.at[i];
        apply(batch, point, i, normal * batch.normal_x.at[i] + tangent * batch.normal_y.at[i],
              normal * batch.normal_y.at[i] - tangent * batch.normal_x.at[i], a, b);
      }
    scatter(bodies, batch.write_a, a);
    scatter(bodies, batch.write_b, b);
  }
}

void solve_contacts(Scratch& scratch, Real h, Bias bias) {
  if (bias == Bias::on)
    solve_batches<Bias::on>(scratch, h);
  else
    solve_batches<Bias::off>(scratch, h);
}

bool bounce_contacts(Scratch& scratch, Real threshold) {
  MovingBody* bodies = scratch.bodies.data();
  bool any = false;
  for (ContactBatch& batch : scratch.contact_batches.batches) {
    if (!batch.bounces) continue;
    Velocities a, b;
    gather(bodies, batch.read_a, a);
    gather(bodies, batch.read_b, b);
    for (ContactPointLanes& point : batch.points)
      for (int i = 0; i < batch.count; ++i) {
        // Newton's law of restitution: v_n after = -e v_n before, for points that approached and did push.
        if (batch.restitution.at[i] == 0 || point.approach.at[i] > -threshold || point.normal_impulse_max.at[i] == 0)
          continue;
        const Real nx = batch.normal_x.at[i];
        const Real ny = batch.normal_y.at[i];
        const Real vn = relative_velocity_x(point, i, a, b) * nx + relative_velocity_y(point, i, a, b) * ny;
        const Real old_impulse = point.normal_impulse.at[i];
        const Real wanted =
            old_impulse - point.normal_mass.at[i] * (vn + batch.restitution.at[i] * point.approach.at[i]);
        const Real impulse = wanted > 0 ? wanted : Real(0);
        point.normal_impulse.at[i] = impulse;
        const Real change = impulse - old_impulse;
        apply(batch, point, i, change * nx, change * ny, a, b);
        any = true;
      }
    scatter(bodies, batch.write_a, a);
    scatter(bodies, batch.write_b, b);
  }
  return any;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
