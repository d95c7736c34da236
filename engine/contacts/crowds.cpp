// Crowds: bodies that overlap several others deeply, as bodies put down in one place do.
// SPDX-License-Identifier: MIT
#include "engine/contacts/crowds.h"

#include <algorithm>

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real deep_share = Real(0.2);    // overlap over the size of the smaller shape
constexpr std::uint32_t crowd_least = 2;  // deep contacts of a body in a crowd with bodies that move

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
  std::uint32_t most = 0;
  for (const std::uint32_t contact : tick.set_contacts) {
    const ContactPair& pair = tick.contact_pairs[contact];
    if (!is_deep(pair) || !moves(pair.body_a) || !moves(pair.body_b)) continue;
    for (const std::uint32_t row : {pair.body_a, pair.body_b}) most = std::max(most, ++tick.deep_counts[row]);
  }
  if (most < crowd_least) tick.deep_counts.clear();
}

bool is_crowded(const TickLists& tick, std::uint32_t contact) {
  const ContactPair& pair = tick.contact_pairs[contact];
  return std::max(tick.deep_counts[pair.body_a], tick.deep_counts[pair.body_b]) >= crowd_least;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
