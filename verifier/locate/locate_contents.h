// Differing texts and byte strings of two states: the pieces of an owner joined. Places of child rows.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/state/child_tables.h"
#include "base/state/row_names.h"
#include "verifier/report/content_text.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// The place of a child row: "units[3].inventory[2]", or "units[3].name" for a piece of a text. Numbers are row numbers
/// from 0. Empty: the table is not a child table.
/// Requires: a row of the table.
std::string child_place(const StateSchema& schema, std::span<const ImageTable> tables, std::size_t table,
                        std::size_t row);

/// A text or a string of bytes of a state.
struct Content {
  std::string place;  // "units[3].inventory[2].label"
  std::string bytes;
};
/// Those that have a byte, in owner order. Requires: the table has pieces; the tables of an image of the schema.
std::vector<Content> contents_of(const StateSchema& schema, std::span<const ImageTable> tables, std::size_t table);

/// A text or a string of bytes that is not the same in several states. Where it stands is told of one of them.
struct ContentDifference {
  std::string place;                // "units[3].inventory[2].label"
  std::string table;                // of the pieces
  std::size_t placed_by = 0;        // the first state that has a byte of it: `place` and `top` are of that one
  StatePlace top;                   // the row at the begin of `place`
  std::optional<std::uint64_t> id;  // of that row, where its table has ids
  bool is_text = false;
  std::uint64_t first = 0;                        // place of the first byte of each side in the whole
  std::uint64_t offset = 0;                       // of the first byte that is not the same in all
  std::optional<std::uint64_t> character;         // the same in characters; absent: the text is no UTF-8
  std::vector<std::optional<ContentSide>> sides;  // [state]; absent: no such row
};
struct ContentDifferences {
  std::vector<ContentDifference> list;  // in table and owner order; the first of them
  std::uint64_t count = 0;              // of all
};
/// Owners are matched by ids and indices. Requires: the tables of one state at least, each an image of the schema.
ContentDifferences find_content_differences(const StateSchema& schema,
                                            std::span<const std::span<const ImageTable>> states, std::size_t count_max);

/// Fills contents and content_count of `divergence` from two states. At most `count_max` are listed, all are counted.
/// Requires: the tables of two images of the schema.
void locate_contents(const StateSchema& schema, std::span<const ImageTable> expected, std::span<const ImageTable> got,
                     const RowNamer& row_name, std::size_t count_max, Divergence& divergence);

}  // namespace ticktrue::verifier
