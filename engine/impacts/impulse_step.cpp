// A step of an active set: a sparse system in the velocities of the bodies, factored along its envelope.
// SPDX-License-Identifier: MIT
// Source: Silcowitz, Niebe, Erleben, "Projected Gauss-Seidel Subspace Minimization Method for Interactive Rigid Body
// Dynamics", 2010 (passes find the active contacts, a direct solution finds their impulses); George and Liu, "Computer
// Solution of Large Sparse Positive Definite Systems", 1981 (envelope). Rockafellar, "Monotone Operators and the
// Proximal Point Algorithm", 1976.
//
// J are the rows of the active contacts, l their impulses, v the velocities and r = J v - wanted. J M^-1 J^T is
// singular: two points, which four rows describe, hold a box. Each row therefore has a small compliance E, and the
// remaining residual is solved again: (M + J^T E^-1 J) dv = -J^T E^-1 r, dl = -E^-1 (r + J dv). The solution is in
// doubles, since E is far below the precision of a float.
#include "engine/impacts/impulse_step.h"

#include <algorithm>

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr double compliance_share = 1e-9;  // of a row's own mobility
constexpr int proximal_count = 3;
constexpr double left_share = 1e-3;            // of the largest residual: what a step may leave of a normal
constexpr double envelope_work_max = 1 << 24;  // multiplications of a factorization
// The work of a step, in contacts solved once.
constexpr std::uint64_t work_of_row = 70;
constexpr std::uint64_t work_of_listing = 30;  // the part of a row before the factorization
constexpr std::uint64_t multiplications_per_contact = 10;

/// The present separation of a point, as kernels compute it.
double separation_of(const ContactBatch& batch, const ContactPointLanes& point, std::uint32_t lane, const MovingBody& a,
                     const MovingBody& b) {
  const auto at = [lane](const ContactLanes& lanes) { return static_cast<double>(lanes.at[lane]); };
  const Vec2 displacement = b.delta_position - a.delta_position;
  const double along = static_cast<double>(displacement.x) * at(batch.normal_x) +
                       static_cast<double>(displacement.y) * at(batch.normal_y);
  const double back_a = at(point.tangent_arm_a) + at(batch.radius_a);
  const double back_b = at(point.tangent_arm_b) - at(batch.radius_b);
  const double by_cosine =
      (static_cast<double>(a.delta_rotation.c) - 1) * back_a - (static_cast<double>(b.delta_rotation.c) - 1) * back_b;
  const double by_sine = static_cast<double>(b.delta_rotation.s) * at(point.normal_arm_b) -
                         static_cast<double>(a.delta_rotation.s) * at(point.normal_arm_a);
  return at(point.separation) + (along + (by_cosine + by_sine));
}

double speed_along(const double (&row)[3], const double* velocity) {
  return (row[0] * velocity[0] + row[1] * velocity[1]) + row[2] * velocity[2];
}

/// J v of a row; `velocity`: three of each place.
double speed_along(const ActiveRow& row, const std::vector<double>& velocity) {
  double sum = 0;
  if (row.place_a != no_body) sum += speed_along(row.along_a, &velocity[3 * row.place_a]);
  if (row.place_b != no_body) sum += speed_along(row.along_b, &velocity[3 * row.place_b]);
  return sum;
}

/// v += J^T impulse of a row.
void add(const ActiveRow& row, double impulse, std::vector<double>& velocity) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (row.place_a != no_body) velocity[3 * row.place_a + i] += row.along_a[i] * impulse;
    if (row.place_b != no_body) velocity[3 * row.place_b + i] += row.along_b[i] * impulse;
  }
}

double speed_of(const ActiveRow& row, const SolverBodies& bodies) {
  const auto part = [&](std::uint32_t body, const double(&along)[3]) {
    const MovingBody& moving = bodies.records[body];
    const double velocity[3] = {static_cast<double>(moving.velocity.x), static_cast<double>(moving.velocity.y),
                                static_cast<double>(moving.angular_velocity)};
    return speed_along(along, velocity);
  };
  return part(row.read_a, row.along_a) + part(row.read_b, row.along_b);
}

double mobility_of(const BodyMass& mass, const double (&along)[3]) {
  return static_cast<double>(mass.inv_mass) * (along[0] * along[0] + along[1] * along[1]) +
         static_cast<double>(mass.inv_inertia) * along[2] * along[2];
}

void set_along(ActiveRow& row, const double (&arms)[3][2]) {
  for (std::size_t i = 0; i < 3; ++i) {
    row.along_a[i] = arms[i][0];
    row.along_b[i] = arms[i][1];
  }
}

/// The number of points with a normal impulse.
std::uint64_t count_rows(const SolvedSet& solved, const ContactBatches& all) {
  std::uint64_t count = 0;
  for (std::uint32_t i = solved.set.first_batch; i < solved.set.batch_end; ++i) {
    const ContactBatch& batch = all.batches[i];
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(batch.count); ++lane)
      for (const ContactPointLanes& point : batch.points)
        count += point.normal_mass.at[lane] > 0 && point.normal_impulse.at[lane] > 0 ? 1 : 0;
  }
  return count;
}

/// Finds the rows of points with a normal impulse. A point with static friction has a second row.
void find_rows(const SolvedSet& solved, const ContactBatches& all, ImpulseStep& out) {
  const SolverBodies& bodies = solved.bodies;
  out.rows.clear();
  const double inv_h = 1 / static_cast<double>(solved.set.h);
  for (std::uint32_t i = solved.set.first_batch; i < solved.set.batch_end; ++i) {
    const ContactBatch& batch = all.batches[i];
    for (std::uint32_t lane = 0; lane < static_cast<std::uint32_t>(batch.count); ++lane) {
      const ContactPair& pair = solved.tick.contact_pairs[batch.contact[lane]];
      const auto at = [lane](const ContactLanes& lanes) { return static_cast<double>(lanes.at[lane]); };
      const double nx = at(batch.normal_x);
      const double ny = at(batch.normal_y);
      for (std::uint32_t p = 0; p < 2; ++p) {
        const ContactPointLanes& point = batch.points[p];
        if (!(point.normal_mass.at[lane] > 0) || !(point.normal_impulse.at[lane] > 0)) continue;
        ActiveRow row{};
        row.batch = i;
        row.lane = lane;
        row.point = p;
        row.body_a = pair.body_a;
        row.body_b = pair.body_b;
        const BodyMass& mass_a = bodies.masses[pair.body_a];
        const BodyMass& mass_b = bodies.masses[pair.body_b];
        row.read_a = mass_a.read;
        row.read_b = mass_b.read;
        const double arms[3][2] = {{-nx, nx}, {-ny, ny}, {-at(point.normal_arm_a), at(point.normal_arm_b)}};
        set_along(row, arms);
        const double separation =
            separation_of(batch, point, lane, bodies.records[row.read_a], bodies.records[row.read_b]);
        row.residual = speed_of(row, bodies) + (separation > 0 ? separation * inv_h : 0);
        row.stiffness = 1 / (compliance_share * (mobility_of(mass_a, row.along_a) + mobility_of(mass_b, row.along_b)));
        row.impulse = at(point.normal_impulse);
        out.rows.push_back(row);
        const double limit = at(batch.friction) * row.impulse;
        const double tangent = at(point.tangent_impulse);
        if (!(point.tangent_mass.at[lane] > 0) || !((tangent < 0 ? -tangent : tangent) < limit)) continue;
        row.is_friction = true;
        const double tangent_arms[3][2] = {{-ny, ny}, {nx, -nx}, {-at(point.tangent_arm_a), at(point.tangent_arm_b)}};
        set_along(row, tangent_arms);
        row.residual = speed_of(row, bodies) +
                       (all.surfaces.empty() ? 0.0 : static_cast<double>(all.surfaces[i].tangent_speed.at[lane]));
        row.stiffness = 1 / (compliance_share * (mobility_of(mass_a, row.along_a) + mobility_of(mass_b, row.along_b)));
        row.impulse = tangent;
        row.friction = at(batch.friction);
        out.rows.push_back(row);
      }
    }
  }
}

/// Numbers the bodies of the rows breadth first from the ground, so that neighbours are close.
void find_places(const SolverBodies& bodies, ImpulseStep& out) {
  const std::uint32_t sink = dummy_sink(bodies);
  const auto moves = [&](std::uint32_t body) { return bodies.masses[body].write != sink; };
  out.start.assign(bodies.masses.size() + 2, 0);
  out.is_start.assign(bodies.masses.size(), 0);
  for (const ActiveRow& row : out.rows) {
    if (moves(row.body_a) && moves(row.body_b)) {
      ++out.start[row.body_a + 2];
      ++out.start[row.body_b + 2];
    } else {
      out.is_start[moves(row.body_a) ? row.body_a : row.body_b] = 1;
    }
  }
  for (std::size_t i = 2; i < out.start.size(); ++i) out.start[i] += out.start[i - 1];
  out.neighbours.resize(out.start.back());
  for (const ActiveRow& row : out.rows) {
    if (!moves(row.body_a) || !moves(row.body_b)) continue;
    out.neighbours[out.start[row.body_a + 1]++] = row.body_b;
    out.neighbours[out.start[row.body_b + 1]++] = row.body_a;
  }
  out.place.assign(bodies.masses.size(), no_body);
  out.bodies.clear();
  const auto put = [&](std::uint32_t body) {
    if (!moves(body) || out.place[body] != no_body) return;
    out.place[body] = static_cast<std::uint32_t>(out.bodies.size());
    out.bodies.push_back(body);
  };
  std::size_t next = 0;
  const auto spread_out = [&] {
    for (; next < out.bodies.size(); ++next) {
      const std::uint32_t body = out.bodies[next];
      for (std::uint32_t i = out.start[body]; i < out.start[body + 1]; ++i) put(out.neighbours[i]);
    }
  };
  for (std::uint32_t body = 0; body < out.is_start.size(); ++body)
    if (out.is_start[body] != 0) put(body);
  spread_out();
  for (const ActiveRow& row : out.rows) {  // bodies without a path to the ground
    put(row.body_a);
    put(row.body_b);
    spread_out();
  }
  for (ActiveRow& row : out.rows) {
    row.place_a = out.place[row.body_a];
    row.place_b = out.place[row.body_b];
  }
}

/// Finds the first nonzero entry of each row of M + J^T E^-1 J. Returns the multiplications of its factorization; a
/// number above envelope_work_max if there are more.
double find_envelope(ImpulseStep& out) {
  const std::size_t size = 3 * out.bodies.size();
  out.first.resize(size);
  for (std::size_t i = 0; i < size; ++i) out.first[i] = static_cast<std::uint32_t>(i - i % 3);
  for (const ActiveRow& row : out.rows) {
    if (row.place_a == no_body || row.place_b == no_body) continue;
    const std::uint32_t low = row.place_a < row.place_b ? row.place_a : row.place_b;
    const std::uint32_t high = row.place_a < row.place_b ? row.place_b : row.place_a;
    for (std::uint32_t i = 3 * high; i < 3 * high + 3; ++i) out.first[i] = std::min(out.first[i], 3 * low);
  }
  out.row_start.resize(size + 1);
  std::size_t total = 0;
  double work = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t width = i - out.first[i] + 1;
    out.row_start[i] = total;
    total += width;
    work += static_cast<double>(width) * static_cast<double>(width);
    if (work > envelope_work_max) return work;
  }
  out.row_start[size] = total;
  return work;
}

/// Builds M + J^T E^-1 J. Requires: find_envelope.
void make_system(const SolverBodies& bodies, ImpulseStep& out) {
  out.matrix.assign(out.row_start[out.first.size()], 0);
  const auto at = [&](std::size_t i, std::size_t j) -> double& {
    return out.matrix[out.row_start[i] + (j - out.first[i])];
  };
  for (std::size_t place = 0; place < out.bodies.size(); ++place) {
    const BodyMass& mass = bodies.masses[out.bodies[place]];
    const double inertia = mass.inv_inertia > 0 ? 1 / static_cast<double>(mass.inv_inertia) : 1e30;
    at(3 * place, 3 * place) = at(3 * place + 1, 3 * place + 1) = 1 / static_cast<double>(mass.inv_mass);
    at(3 * place + 2, 3 * place + 2) = inertia;
  }
  const auto add_block = [&](std::uint32_t p, std::uint32_t q, const double(&u)[3], const double(&w)[3],
                             double factor) {
    if (p == no_body || q == no_body || q > p) return;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        if (3 * q + j <= 3 * p + i) at(3 * p + i, 3 * q + j) += factor * u[i] * w[j];
  };
  for (const ActiveRow& row : out.rows) {
    add_block(row.place_a, row.place_a, row.along_a, row.along_a, row.stiffness);
    add_block(row.place_b, row.place_b, row.along_b, row.along_b, row.stiffness);
    add_block(row.place_a, row.place_b, row.along_a, row.along_b, row.stiffness);
    add_block(row.place_b, row.place_a, row.along_b, row.along_a, row.stiffness);
  }
}

/// Replaces the matrix by L of L L^T.
void factor(ImpulseStep& out) {
  const std::size_t size = out.first.size();
  for (std::size_t i = 0; i < size; ++i) {
    double* row = out.matrix.data() + out.row_start[i];
    for (std::size_t j = out.first[i]; j <= i; ++j) {
      const double* other = out.matrix.data() + out.row_start[j];
      const std::size_t begin = std::max(out.first[i], out.first[j]);
      double sum = row[j - out.first[i]];
      for (std::size_t k = begin; k < j; ++k) sum -= row[k - out.first[i]] * other[k - out.first[j]];
      row[j - out.first[i]] = j < i ? sum / other[j - out.first[j]] : __builtin_sqrt(sum > 0 ? sum : 1e-300);
    }
  }
}

void solve_factored(const ImpulseStep& out, std::vector<double>& x) {
  const std::size_t size = out.first.size();
  for (std::size_t i = 0; i < size; ++i) {
    const double* row = out.matrix.data() + out.row_start[i];
    for (std::size_t k = out.first[i]; k < i; ++k) x[i] -= row[k - out.first[i]] * x[k];
    x[i] /= row[i - out.first[i]];
  }
  for (std::size_t i = size; i-- > 0;) {
    const double* row = out.matrix.data() + out.row_start[i];
    x[i] /= row[i - out.first[i]];
    for (std::size_t k = out.first[i]; k < i; ++k) x[k] -= row[k - out.first[i]] * x[i];
  }
}

/// Finds the changes of all impulses.
void find_changes(ImpulseStep& out) {
  for (ActiveRow& row : out.rows) row.change = 0;
  out.total.assign(out.first.size(), 0);
  for (int i = 0; i < proximal_count; ++i) {
    out.velocity.assign(out.first.size(), 0);
    for (const ActiveRow& row : out.rows)
      add(row, -row.stiffness * (row.residual + speed_along(row, out.total)), out.velocity);
    solve_factored(out, out.velocity);
    for (ActiveRow& row : out.rows)
      row.change -= row.stiffness * ((row.residual + speed_along(row, out.total)) + speed_along(row, out.velocity));
    for (std::size_t k = 0; k < out.total.size(); ++k) out.total[k] += out.velocity[k];
  }
}

/// Whether no velocities meet all normals, as of a body between two immovable ones that approach each other. Impulses
/// against the compliance alone would answer what is left, and friction would grow with them.
bool contradicts_itself(const ImpulseStep& out) {
  double asked = 0, left = 0;
  for (const ActiveRow& row : out.rows) {
    if (row.is_friction) continue;
    const double rest = row.residual + speed_along(row, out.total);
    asked = std::max(asked, row.residual < 0 ? -row.residual : row.residual);
    left = std::max(left, rest < 0 ? -rest : rest);
  }
  return left > left_share * asked;
}

/// The largest step, as a share of the changes, for which every row stays active.
double longest_step(const ImpulseStep& out) {
  double step = 1;
  double normal = 0, normal_change = 0;
  const auto bound = [&step](double slack, double rate) {  // slack + step rate >= 0
    if (rate < 0 && slack < -rate * step) step = slack / -rate;
  };
  for (const ActiveRow& row : out.rows) {
    if (!row.is_friction) {
      normal = row.impulse;
      normal_change = row.change;
      bound(normal, normal_change);
    } else {
      bound(row.friction * normal - row.impulse, row.friction * normal_change - row.change);
      bound(row.friction * normal + row.impulse, row.friction * normal_change + row.change);
    }
  }
  return step > 0 ? step : 0;
}

/// The velocities that the changes cause.
void find_velocities(const SolverBodies& bodies, ImpulseStep& out) {
  out.velocity.assign(out.first.size(), 0);
  for (const ActiveRow& row : out.rows) add(row, row.change, out.velocity);
  for (std::size_t place = 0; place < out.bodies.size(); ++place) {
    const BodyMass& mass = bodies.masses[out.bodies[place]];
    out.velocity[3 * place] *= static_cast<double>(mass.inv_mass);
    out.velocity[3 * place + 1] *= static_cast<double>(mass.inv_mass);
    out.velocity[3 * place + 2] *= static_cast<double>(mass.inv_inertia);
  }
}

/// Projects each change, so that its row stays active.
void cut_changes(ImpulseStep& out) {
  double normal = 0;
  for (ActiveRow& row : out.rows) {
    const double wanted = row.impulse + row.change;
    const double low = row.is_friction ? -row.friction * normal : 0;
    const double cut = wanted < low ? low : row.is_friction && wanted > -low ? -low : wanted;
    if (!row.is_friction) normal = cut;
    row.change = cut - row.impulse;
  }
}

/// The increase of the energy that the passes minimize.
double added_energy(const ImpulseStep& out) {
  double sum = 0;
  for (const ActiveRow& row : out.rows) sum += row.change * (row.residual + 0.5 * speed_along(row, out.velocity));
  return sum;
}

void apply(const ImpulseStep& out, ContactBatches& contacts, SolverBodies& bodies) {
  for (const ActiveRow& row : out.rows) {
    ContactPointLanes& point = contacts.batches[row.batch].points[row.point];
    ContactLanes& impulse = row.is_friction ? point.tangent_impulse : point.normal_impulse;
    impulse.at[row.lane] = static_cast<Real>(row.impulse + row.change);
  }
  for (std::size_t place = 0; place < out.bodies.size(); ++place) {
    MovingBody& body = bodies.records[out.bodies[place]];
    const double* change = &out.velocity[3 * place];
    body.velocity.x = static_cast<Real>(static_cast<double>(body.velocity.x) + change[0]);
    body.velocity.y = static_cast<Real>(static_cast<double>(body.velocity.y) + change[1]);
    body.angular_velocity = static_cast<Real>(static_cast<double>(body.angular_velocity) + change[2]);
  }
}

}  // namespace

StepWork step_active_contacts(const SolvedSet& solved, ContactBatches& contacts, std::uint64_t work_max,
                              ImpulseStep& out) {
  if (work_max != no_step_limit) {
    const std::uint64_t of_rows = work_of_row * count_rows(solved, contacts);
    if (of_rows > work_max) return {false, 0, of_rows};
  }
  find_rows(solved, contacts, out);
  find_places(solved.bodies, out);
  const std::uint64_t listing = work_of_listing * out.rows.size();
  if (out.bodies.empty()) return {false, listing, no_step_limit};
  const double envelope_work = find_envelope(out);
  if (envelope_work > envelope_work_max) return {false, listing, no_step_limit};
  const std::uint64_t work =
      work_of_row * out.rows.size() + static_cast<std::uint64_t>(envelope_work) / multiplications_per_contact;
  if (work > work_max) return {false, listing, work};
  make_system(solved.bodies, out);
  factor(out);
  find_changes(out);
  if (contradicts_itself(out)) return {false, work, no_step_limit};
  const double step = longest_step(out);
  out.full_change.resize(out.rows.size());
  for (std::size_t i = 0; i < out.rows.size(); ++i) out.full_change[i] = out.rows[i].change;
  cut_changes(out);
  find_velocities(solved.bodies, out);
  if (!(added_energy(out) < 0)) {
    for (std::size_t i = 0; i < out.rows.size(); ++i) {
      ActiveRow& row = out.rows[i];
      row.change = step * out.full_change[i];
      if (!row.is_friction && row.impulse + row.change < 0) row.change = -row.impulse;  // by rounding
    }
    find_velocities(solved.bodies, out);
  }
  apply(out, contacts, solved.bodies);
  return {true, work, 0};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
