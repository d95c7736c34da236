// Differing texts and byte strings of two states: the pieces of an owner joined. Places of child rows.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "base/state/child_tables.h"
#include "base/state/row_names.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// The place of a child row: "units[3].inventory[2]", or "units[3].name" for a piece of a text. Numbers are row numbers
/// from 0. Empty: the table is not a child table.
/// Requires: a row of the table.
std::string child_place(const StateSchema& schema, std::span<const ImageTable> tables, std::size_t table,
                        std::size_t row);

/// Fills contents and content_count of `divergence`. Owners are matched by ids and indices. At most `count_max`
/// contents are listed; all are counted. Requires: the tables of two images of the schema.
void locate_contents(const StateSchema& schema, std::span<const ImageTable> expected, std::span<const ImageTable> got,
                     const RowNamer& row_name, std::size_t count_max, Divergence& divergence);

}  // namespace ticktrue::verifier
