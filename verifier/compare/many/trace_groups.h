// Traces grouped by a common property: the majority, and the traces outside it.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace ticktrue::verifier {

/// Indices into the list of compared traces, ascending.
using TraceGroup = std::vector<std::size_t>;

/// The largest group first. Between groups of equal size, the group with the first trace comes first.
struct TraceGroups {
  std::vector<TraceGroup> groups;

  std::size_t trace_count() const;
  /// Whether more than half of the traces are in the first group.
  bool has_majority() const { return !groups.empty() && 2 * groups.front().size() > trace_count(); }
  /// The traces outside the majority, ascending. Empty: no majority.
  TraceGroup odd() const;
  /// Sorts each group, and the groups.
  void put_in_order();
};

/// `same(i, j)`: whether two traces belong together. A trace joins the first group whose first member is the same.
template <typename Same>
TraceGroups group_traces(const TraceGroup& traces, Same same) {
  TraceGroups found;
  for (const std::size_t trace : traces) {
    const auto group = std::find_if(found.groups.begin(), found.groups.end(),
                                    [&](const TraceGroup& one) { return same(one.front(), trace); });
    if (group == found.groups.end())
      found.groups.push_back({trace});
    else
      group->push_back(trace);
  }
  found.put_in_order();
  return found;
}

/// a, b, ..., z, aa, ab, ...
std::string trace_label(std::size_t trace);
/// "a, b".
std::string labels_text(const TraceGroup& traces);
/// "a, b agree; c is the odd one out", or "no majority: a, b; c, d".
std::string who_text(const TraceGroups& groups);

}  // namespace ticktrue::verifier
