// The ddmin algorithm.
// SPDX-License-Identifier: MIT
#include "tool/experiment/ddmin.h"

#include <algorithm>

namespace ticktrue::soak {
namespace {

using Indices = std::vector<std::size_t>;

/// First and last position of part `part`, if the list is split into `part_count` parts of about equal size.
std::pair<std::size_t, std::size_t> part_of(std::size_t size, std::size_t part, std::size_t part_count) {
  return {size * part / part_count, size * (part + 1) / part_count};
}

}  // namespace

Indices ddmin(std::size_t count, const std::function<bool(const Indices&)>& fails) {
  Indices remaining;
  for (std::size_t i = 0; i < count; ++i) remaining.push_back(i);
  if (count == 0 || fails({})) return {};
  std::size_t part_count = 2;
  while (remaining.size() >= 2) {
    part_count = std::min(part_count, remaining.size());
    bool is_smaller = false;
    for (std::size_t part = 0; part < part_count && !is_smaller; ++part) {
      const auto [begin, end] = part_of(remaining.size(), part, part_count);
      const auto at = [&](std::size_t i) { return remaining.begin() + static_cast<std::ptrdiff_t>(i); };
      const Indices alone(at(begin), at(end));
      Indices without(remaining.begin(), at(begin));
      without.insert(without.end(), at(end), remaining.end());
      if (fails(alone)) {
        remaining = alone;
        part_count = 2;
        is_smaller = true;
      } else if (part_count > 2 && fails(without)) {
        remaining = without;
        part_count = std::max<std::size_t>(part_count - 1, 2);
        is_smaller = true;
      }
    }
    if (is_smaller) continue;
    if (part_count == remaining.size()) break;
    part_count *= 2;
  }
  return remaining;
}

}  // namespace ticktrue::soak
