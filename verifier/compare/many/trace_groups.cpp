// Orders groups of traces, and names them.
// SPDX-License-Identifier: MIT
#include "verifier/compare/many/trace_groups.h"

namespace ticktrue::verifier {

std::size_t TraceGroups::trace_count() const {
  std::size_t count = 0;
  for (const TraceGroup& group : groups) count += group.size();
  return count;
}

TraceGroup TraceGroups::odd() const {
  TraceGroup others;
  if (!has_majority()) return others;
  for (std::size_t g = 1; g < groups.size(); ++g) others.insert(others.end(), groups[g].begin(), groups[g].end());
  std::sort(others.begin(), others.end());
  return others;
}

void TraceGroups::put_in_order() {
  for (TraceGroup& group : groups) std::sort(group.begin(), group.end());
  std::sort(groups.begin(), groups.end(), [](const TraceGroup& a, const TraceGroup& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
}

std::string trace_label(std::size_t trace) {
  constexpr std::size_t letter_count = 26;
  const std::string last(1, static_cast<char>('a' + trace % letter_count));
  return trace < letter_count ? last : trace_label(trace / letter_count - 1) + last;
}

std::string labels_text(const TraceGroup& traces) {
  std::string text;
  for (const std::size_t trace : traces) text += (text.empty() ? "" : ", ") + trace_label(trace);
  return text;
}

std::string who_text(const TraceGroups& groups) {
  const TraceGroup others = groups.odd();
  if (!others.empty())
    return labels_text(groups.groups.front()) + " agree; " + labels_text(others) +
           (others.size() == 1 ? " is the odd one out" : " are the odd ones out");
  std::string text;
  for (const TraceGroup& group : groups.groups) text += (text.empty() ? "no majority: " : "; ") + labels_text(group);
  return text;
}

}  // namespace ticktrue::verifier
