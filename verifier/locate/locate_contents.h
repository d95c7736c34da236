// Texts and strings of bytes that differ between two states: the pieces of an owner put together. Places of children.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "base/state/child_tables.h"
#include "base/state/row_names.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Where a row of a child stands: "units[3].inventory[2]", and "units[3].name" for a piece of a text. Empty for a table
/// that is no child. Numbers are those of rows, counted from 0.
/// Requires: a row of the table.
std::string child_place(const StateSchema& schema, std::span<const ImageTable> tables, std::size_t table,
                        std::size_t row);

/// Fills contents and content_count of `divergence`. Owners are matched by ids and indices. At most `count_max` are
/// listed, all are counted. Requires: the tables of two images of the schema.
void locate_contents(const StateSchema& schema, std::span<const ImageTable> expected, std::span<const ImageTable> got,
                     const RowNamer& row_name, std::size_t count_max, Divergence& divergence);

}  // namespace ticktrue::verifier
