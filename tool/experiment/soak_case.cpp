// Encodes the inputs of a case tick by tick.
// SPDX-License-Identifier: MIT
#include "tool/experiment/soak_case.h"

#include <algorithm>
#include <tuple>

#include "base/random.h"

namespace ticktrue::soak {

CaseInputs::CaseInputs(const SoakCase& soak_case) : dt_(soak_case.scene.settings.dt), bytes_(soak_case.tick_count) {
  std::vector<engine::Input> sorted;
  for (const engine::Input& input : soak_case.inputs)
    if (input.kind != engine::InputKind::end && input.tick < soak_case.tick_count) sorted.push_back(input);
  std::stable_sort(sorted.begin(), sorted.end(), [](const engine::Input& a, const engine::Input& b) {
    return std::tie(a.tick, a.player, a.sequence) < std::tie(b.tick, b.player, b.sequence);
  });
  for (std::size_t i = 0; i < sorted.size();) {
    const std::uint64_t tick = sorted[i].tick;
    std::vector<engine::Input> of_tick;
    for (; i < sorted.size() && sorted[i].tick == tick; ++i) of_tick.push_back(sorted[i]);
    engine::encode_inputs(of_tick, bytes_[tick]);
  }
}

TickInput CaseInputs::at(std::uint64_t tick) const {
  return {dt_, tick < bytes_.size() ? bytes_[tick] : none_};
}

std::uint64_t mix(std::uint64_t a, std::uint64_t b) {
  return Random(Random(a).bits() + b).bits();
}

}  // namespace ticktrue::soak
