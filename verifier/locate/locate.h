// Locates a difference: which stage, table, column, row and lane, from hashes and state images.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/state/row_names.h"
#include "base/state/state_view.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Fills tables, rows, contents and their counts of `divergence` from two images of one schema. At most `row_count_max`
/// lanes and the same number of texts are listed. All are counted, lanes up to a million. `row_name` may be empty.
/// Errors: corrupt (an image does not fit the schema).
Status locate_lanes(const StateSchema& schema, ByteView expected, ByteView got, const RowNamer& row_name,
                    std::size_t row_count_max, Divergence& divergence);

/// Fills stage and stage_note from the hashes after each stage: the recorded ones and those of a run here.
void locate_stage(std::span<const std::string> stages, std::span<const std::uint64_t> expected,
                  std::span<const std::uint64_t> got, Divergence& divergence);

}  // namespace ticktrue::verifier
