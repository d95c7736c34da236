// Matches the names of both sides. The order matters only if counts and values are equal.
// SPDX-License-Identifier: MIT
#include "verifier/locate/compare_marks.h"

#include <algorithm>
#include <map>
#include <string_view>

namespace ticktrue::verifier {
namespace {

constexpr std::size_t name_count_max = 64;  // in a difference

}  // namespace

std::optional<MarksDifference> compare_marks(std::uint64_t tick, const replay::TickMarks* expected,
                                             const replay::TickMarks* got) {
  const bool is_known = (expected == nullptr || !expected->is_left_out()) && (got == nullptr || !got->is_left_out());
  if (!is_known || (expected == nullptr && got == nullptr)) return std::nullopt;
  MarksDifference difference;
  difference.tick = tick;
  struct Both {
    const replay::NameMarks* expected = nullptr;
    const replay::NameMarks* got = nullptr;
  };
  std::map<std::string_view, Both> names;
  if (expected != nullptr)
    for (const replay::NameMarks& name : expected->names) names[name.name].expected = &name;
  if (got != nullptr)
    for (const replay::NameMarks& name : got->names) names[name.name].got = &name;
  for (const auto& [name, both] : names) {
    const std::uint64_t before = both.expected != nullptr ? both.expected->count : 0;
    const std::uint64_t now = both.got != nullptr ? both.got->count : 0;
    if (before == now && both.expected != nullptr && both.got != nullptr && both.expected->hash == both.got->hash)
      continue;
    difference.names.push_back({std::string(name), before, now});
  }
  const bool is_same_trail = expected != nullptr && got != nullptr && expected->trail == got->trail;
  if (difference.names.empty() && is_same_trail) return std::nullopt;
  difference.name_count = difference.names.size();
  // Another number of marks is a better hint than other values, which can follow from it.
  std::stable_partition(difference.names.begin(), difference.names.end(),
                        [](const NameDifference& name) { return name.expected != name.got; });
  if (difference.names.size() > name_count_max) difference.names.resize(name_count_max);
  return difference;
}

}  // namespace ticktrue::verifier
