// Impacts on jointed bodies: what hits an arm meets the inertia of the whole arm.
// SPDX-License-Identifier: MIT
// Source: Moreau, "Unilateral Contact and Dry Friction in Finite Freedom Dynamics", 1988 (inelastic impact as a
// projection in the metric of the kinetic energy). The rows are solved by projected Gauss-Seidel.
//
// A contact of the solver knows the inertia of its two bodies. Where a joint holds one of them, its impulse grows over
// several substeps, each of which starts with the impulse of the one before. That is right for a lasting force. After
// an impact it throws an arm back. Closing contacts of jointed bodies are therefore stopped at the start of each
// substep, by impulses that are not kept. Each impulse acts on a whole island, also where its joints are iterative. An
// island with too many contact points is left to the solver (meets_island).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/contacts/contact_batch.h"
#include "engine/impacts/island_response.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// A point of a contact with a body of an island (DirectComponents).
struct ImpactPoint {
  std::uint32_t batch = 0;
  std::uint32_t lane = 0;
  std::uint32_t point = 0;
  std::array<std::uint32_t, 2> records{};  // of the bodies, to read
  ImpactEnds ends;
  ImpactRow normal;
  ImpactRow tangent;
  double least_speed = 0;    // of the normal after the impact, m/s
  double impulse_max = 0;    // of the normal, N s
  double tangent_speed = 0;  // of a conveyor, m/s
  double friction = 0;
};

struct JointedImpacts {
  std::vector<ImpactPoint> points;
  ImpactIslands islands;
  std::vector<Triple> velocities;      // [place]
  std::vector<Triple> stopped;         // [place] velocities before a bounce
  std::vector<double> start_energies;  // [body] kinetic energy of listed bodies when the tick began, J
};

template <typename Visit>
void list_fields(JointedImpacts& of, const Visit& visit) {
  auto& [points, islands, velocities, stopped, start_energies] = of;
  visit(points, islands, velocities, stopped, start_energies);
}

/// Lists the contact points of jointed bodies of a set; their pushes are taken back. Requires: find_direct_joints,
/// prepare_contacts.
void prepare_jointed_contacts(const SolvedSet& solved, const DirectWorkspace& direct, ContactBatches& contacts,
                              JointedImpacts& out);
/// Stops contacts of jointed bodies that close fast. Requires: separations are those of the present poses.
void stop_jointed_contacts(const SolvedSet& solved, DirectWorkspace& direct, ContactBatches& contacts,
                           JointedImpacts& work);
/// Applies restitution at points of jointed bodies that hit faster than `threshold`; bounce_contacts then leaves them
/// out. A bounce leaves its bodies at most the kinetic energy that they had when the tick began. True if there was such
/// a point. Lists the points anew.
bool bounce_jointed_contacts(const SolvedSet& solved, Real threshold, DirectWorkspace& direct, ContactBatches& contacts,
                             JointedImpacts& work);
/// Removes the velocity that pushes have left, as relax_contacts does, by impulses on whole islands. Call after it.
void relax_jointed_contacts(const SolvedSet& solved, DirectWorkspace& direct, ContactBatches& contacts,
                            JointedImpacts& work);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
