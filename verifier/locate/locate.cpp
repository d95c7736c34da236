// Names the stage, table, columns, rows and lanes in which two states differ.
// SPDX-License-Identifier: MIT
#include "verifier/locate/locate.h"

#include <algorithm>

#include "verifier/locate/locate_contents.h"

namespace ticktrue::verifier {
namespace {

// Limits the memory of a report if everything differs. More lanes give no further information.
constexpr std::size_t lane_count_max = 1'000'000;

/// The row of `table` with the same key as row `row` of `other`; nothing: there is none.
std::optional<std::size_t> find_row(const TableSchema& schema, const ImageTable& other, std::size_t row,
                                    const ImageTable& table) {
  for (std::size_t candidate = 0; candidate < table.row_count; ++candidate) {
    bool equal = true;
    for (std::size_t c = 0; c < schema.key_column_count && equal; ++c)
      equal = lane_bits(schema, other.rows, {0, row, c, 0}) == lane_bits(schema, table.rows, {0, candidate, c, 0});
    if (equal) return candidate;
  }
  return std::nullopt;
}

}  // namespace

Status locate_lanes(const StateSchema& schema, ByteView expected, ByteView got, const RowNamer& row_name,
                    std::size_t row_count_max, Divergence& divergence) {
  const Result<std::vector<ImageTable>> expected_tables = split_image(schema, expected);
  if (!expected_tables) return expected_tables.error();
  const Result<std::vector<ImageTable>> got_tables = split_image(schema, got);
  if (!got_tables) return got_tables.error();

  std::vector<LaneDifference> lanes = diff_images(schema, *expected_tables, *got_tables, lane_count_max);
  divergence.tables.clear();
  divergence.rows.clear();
  for (std::size_t t = 0; t < schema.tables.size(); ++t) {
    std::vector<bool> differs(schema.tables[t].columns.size());
    bool any = false;
    for (const LaneDifference& lane : lanes)
      if (lane.place.table == t) any = differs[lane.place.column] = true;
    if (!any) continue;
    TableDifference difference;
    difference.table = schema.tables[t].name;
    difference.is_content = has_pieces(schema.tables[t]);
    for (std::size_t c = 0; c < differs.size(); ++c)
      if (differs[c]) difference.columns.push_back(schema.tables[t].columns[c].name);
    divergence.tables.push_back(std::move(difference));
  }
  std::erase_if(lanes, [&](const LaneDifference& lane) { return has_pieces(schema.tables[lane.place.table]); });
  divergence.lane_count = lanes.size();
  locate_contents(schema, *expected_tables, *got_tables, row_name, row_count_max, divergence);
  for (std::size_t i = 0; i < std::min(lanes.size(), row_count_max); ++i) {
    const LaneDifference& lane = lanes[i];
    const TableSchema& table = schema.tables[lane.place.table];
    const Column& column = table.columns[lane.place.column];
    LaneReport row;
    row.table = table.name;
    row.column = column.name;
    row.row = lane.place.row;
    row.id = lane.id;
    row.lane = static_cast<std::uint32_t>(lane.place.lane);
    row.lane_count = column.lane_count;
    row.type = column.type;
    row.expected = lane.expected;
    row.got = lane.got;
    row.place = child_place(schema, lane.expected ? *expected_tables : *got_tables, lane.place.table, lane.place.row);
    if (row_name && lane.got) {
      // Names belong to rows of the state here, which can have another index than in the recorded state.
      std::size_t here = lane.place.row;
      const ImageTable& rows_there = (*expected_tables)[lane.place.table];
      const ImageTable& rows_here = (*got_tables)[lane.place.table];
      if (lane.expected && table.key_column_count > 0 && rows_here.row_count != rows_there.row_count)
        here = find_row(table, rows_there, here, rows_here).value_or(here);
      if (here < rows_here.row_count) row.name = row_name(lane.place.table, here);
    }
    divergence.rows.push_back(std::move(row));
  }
  return {};
}

Divergence between_states(const StateView& first, const StateView& second, const RowNamer& row_name,
                          std::size_t row_count_max) {
  Divergence divergence;
  divergence.expected_root = root_hash(first);
  divergence.got_root = root_hash(second);
  Bytes expected, got;
  encode_image(first, expected);
  encode_image(second, got);
  if (const Status located = locate_lanes(*first.schema, expected, got, row_name, row_count_max, divergence); !located)
    divergence.stage_note = "not known: " + located.error().message;
  return divergence;
}

void locate_stage(std::span<const std::string> stages, std::span<const std::uint64_t> expected,
                  std::span<const std::uint64_t> got, Divergence& divergence) {
  divergence.stage.reset();
  for (std::size_t i = 0; i < std::min(stages.size(), expected.size()); ++i) {
    if (i < got.size() && expected[i] == got[i]) continue;
    divergence.stage = stages[i];
    divergence.stage_note = "first stage whose output differs";
    if (i > 0) divergence.stage_note += "; " + stages[i - 1] + (i > 1 ? " and before agree" : " agrees");
    return;
  }
  divergence.stage_note = "every stage agrees: the difference comes after the last one";
}

}  // namespace ticktrue::verifier
