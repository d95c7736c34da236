// Compares the marks of a tick: names with more or fewer marks, or with other values.
// SPDX-License-Identifier: MIT
//
// Marks affect no verdict: a random generator may also serve the display. They show where to search.
#pragma once

#include <cstdint>
#include <optional>

#include "replay/format/marks.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Nothing: the marks are the same, or the marks of one side are unknown. Null: the tick has no marks.
std::optional<MarksDifference> compare_marks(std::uint64_t tick, const replay::TickMarks* expected,
                                             const replay::TickMarks* got);

}  // namespace ticktrue::verifier
