// Compares the marks of a tick: which names are there more or less often, or with other values.
// SPDX-License-Identifier: MIT
//
// Marks decide no verdict: a generator may also serve what is drawn. They tell where to look.
#pragma once

#include <cstdint>
#include <optional>

#include "replay/format/marks.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Nothing if the marks are the same, or if those of one side are not known. Null: the tick has no marks.
std::optional<MarksDifference> compare_marks(std::uint64_t tick, const replay::TickMarks* expected,
                                             const replay::TickMarks* got);

}  // namespace ticktrue::verifier
