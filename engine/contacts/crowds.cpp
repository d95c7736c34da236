// Crowds: bodies that overlap several others deeply, as bodies put down in one place do.
// SPDX-License-Identifier: MIT
#include "engine/contacts/crowds.h"

#include <algorithm>

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real deep_share = Real(0.2);    // overlap over the size of the smaller shape
constexpr std::uint32_t crowd_least = 2;  // deep contacts of a body in a crowd with bodies that move
constexpr Real heavy_ratio = 16;          // of masses: a single push hardly moves the heavier one

// In deep_counts: of bodies with both flags. They are in no crowd.
constexpr std::uint32_t is_under_heavy = 1u << 30;   // overlaps a much heavier body deeply
constexpr std::uint32_t is_on_immovable = 1u << 31;  // overlaps an immovable body
constexpr std::uint32_t pressed = is_under_heavy | is_on_immovable;

bool is_deep(const ContactPair& pair) {
  return overlaps_by(pair, deep_share);
}

/// Whether some contact is deep. All worlds pay for this loop in every tick.
bool some_are_deep(const TickLists& tick) {
  if (!tick.has_solver_sets) {
    for (const ContactPair& pair : tick.contact_pairs)
      if (is_deep(pair)) return true;
    return false;
  }
  for (const std::uint32_t contact : tick.set_contacts)
    if (is_deep(tick.contact_pairs[contact])) return true;
  return false;
}

}  // namespace

void find_crowds(const Model& model, const State& state, TickLists& tick) {
  tick.deep_counts.clear();
  if (!some_are_deep(tick)) return;
  tick.deep_counts.assign(state.bodies.size(), 0);
  const auto moves = [&](std::uint32_t row) {
    return model.bodies[state.bodies[row].source].type == BodyType::dynamic_body;
  };
  const auto is_light = [&](std::uint32_t row, std::uint32_t other) {
    return model.bodies[state.bodies[row].source].inv_mass >
           heavy_ratio * model.bodies[state.bodies[other].source].inv_mass;
  };
  for (const std::uint32_t contact : tick.set_contacts) {
    const ContactPair& pair = tick.contact_pairs[contact];
    const std::uint32_t a = pair.body_a, b = pair.body_b;
    if (!moves(a) || !moves(b)) {
      if (overlaps_by(pair, 0)) tick.deep_counts[moves(a) ? a : b] |= is_on_immovable;
    } else if (is_deep(pair)) {
      ++tick.deep_counts[a];
      ++tick.deep_counts[b];
      if (is_light(a, b)) tick.deep_counts[a] |= is_under_heavy;
      if (is_light(b, a)) tick.deep_counts[b] |= is_under_heavy;
    }
  }
  std::uint32_t most = 0;
  for (std::uint32_t& count : tick.deep_counts) {
    count = (count & pressed) == pressed ? pressed : count & ~pressed;
    if (count != pressed) most = std::max(most, count);
  }
  if (most < crowd_least) tick.deep_counts.clear();
}

bool is_crowded(const TickLists& tick, std::uint32_t contact) {
  const ContactPair& pair = tick.contact_pairs[contact];
  const std::uint32_t a = tick.deep_counts[pair.body_a], b = tick.deep_counts[pair.body_b];
  // A heavy body rises from light ones that lie on something only where the pushes of many substeps add up.
  return a != pressed && b != pressed && std::max(a, b) >= crowd_least;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
