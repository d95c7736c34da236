// The verdicts of a study on one curve or case, and counts of verdicts.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace ticktrue::tool {

/// not_judged: nothing is claimed. falls_short: the row misses the claim, and docs/study.md gives the reason.
enum class StudyVerdict : std::uint8_t { pass, fail, not_judged, falls_short, not_applicable };
inline constexpr std::array<std::string_view, 5> study_verdict_names{"pass", "fail", "not_judged", "falls_short",
                                                                     "not_applicable"};
constexpr std::string_view verdict_name(StudyVerdict verdict) {
  return study_verdict_names[static_cast<std::size_t>(verdict)];
}

struct VerdictCounts {
  std::array<int, study_verdict_names.size()> by_verdict{};
  void add(StudyVerdict verdict) { ++by_verdict[static_cast<std::size_t>(verdict)]; }
  int of(StudyVerdict verdict) const { return by_verdict[static_cast<std::size_t>(verdict)]; }
};

}  // namespace ticktrue::tool
