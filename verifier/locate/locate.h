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

/// What differs between two states of one schema. Fills hashes, tables, rows and contents.
Divergence between_states(const StateView& first, const StateView& second, const RowNamer& row_name,
                          std::size_t row_count_max);

/// The next step where a second run of some ticks, from a save on, ends otherwise than the first.
inline constexpr const char* second_run_hint =
    "something that these ticks read is not in what save gives or not restored by load (a static, a cache, a counter, "
    "a generator), or a tick reads a clock or addresses";

/// Fills stage and stage_note from the recorded hashes after each stage and those of a run here.
void locate_stage(std::span<const std::string> stages, std::span<const std::uint64_t> expected,
                  std::span<const std::uint64_t> got, Divergence& divergence);

}  // namespace ticktrue::verifier
