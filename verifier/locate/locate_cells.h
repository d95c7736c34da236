// Locates a difference from the cells of two states: the exact columns, and the rows that can have differed.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/state/cells.h"
#include "replay/format/trace.h"
#include "verifier/locate/locate.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// If all partitions name more rows than this limit, rows that three partitions name are listed too. If most cells
/// differ, a row with one cell that is unchanged by chance would otherwise be missed.
inline constexpr std::size_t short_list_max = 32;

/// The rows that differ according to the cells of two states.
struct CellFinding {
  std::vector<CellOwner> candidates;  // the given owners that can have differed
  std::vector<CellOwner> gone;        // the same for owners given as gone
  bool healed = false;                // some candidates were named by three of four partitions only
  std::uint32_t differing_cells = 0;
  std::uint32_t unexplained_cells = 0;  // differing cells without a value of a candidate
};

/// Candidates are owners all of whose cells differ. If these owners do not explain each differing cell, other owners
/// are added: those with three differing cells, one of them unexplained. A value can change and leave one of its cells
/// unchanged.
/// Requires: equal partition_cells.
CellFinding find_candidates(const StateCells& expected, const StateCells& got, const std::vector<CellOwner>& owners,
                            const std::vector<CellOwner>& gone = {});

/// The number of differing owners among `owner_count`, estimated from the number of differing cells; exact if it is
/// small.
std::uint64_t estimate_differing(const StateCells& expected, const StateCells& got, std::uint64_t owner_count);

/// The owners of a state that both sides had, and their names.
struct RowsBefore {
  std::vector<CellOwner> owners;
  std::vector<std::string> names;         // [owner]
  std::vector<std::uint32_t> row_counts;  // [table]
};
RowsBefore rows_before(const StateView& state, const RowNamer& row_name);

/// Fills tables, row_counts and candidates of `divergence`. `rows`: the state whose owners are tried, this one or the
/// last known one; null: none. `before`: the owners before the tick, for rows that only the other side still has, or
/// has with another key; may be null. At most `row_count_max` candidates are listed; all are counted.
void locate_cells(const StateSchema& schema, const StateCells& expected, const StateCells& got, const StateView* rows,
                  const RowNamer& row_name, std::size_t row_count_max, Divergence& divergence,
                  const RowsBefore* before = nullptr);

/// The number of owners that differ between a recorded tick and the state here after it. Nothing: the trace stores only
/// a hash of the tick, and the hashes differ.
std::optional<Spread> measure_spread(const StateSchema& schema, const replay::TickRecord& recorded,
                                     const StateView& here, CellHasher& hasher);
/// The same for two sets of cells, or for two states.
Spread spread_of_cells(const StateSchema& schema, const StateCells& a, const StateCells& b, std::uint64_t tick);
Spread spread_of_tables(const StateSchema& schema, std::span<const ImageTable> a, std::span<const ImageTable> b,
                        std::uint64_t tick);

/// The command that shows the values of a difference at `tick`, for the build that recorded `file`.
std::string more_detail_command(const std::string& file, std::uint64_t tick, const std::string& tool);

/// A state view over an image. Requires: an image of the schema that outlives this object.
class ImageState {
 public:
  /// Errors: corrupt.
  static Result<ImageState> of(const StateSchema& schema, ByteView image);
  const StateView& view() const { return view_; }

 private:
  StateView view_;
  std::vector<Bytes> rows_;
};

}  // namespace ticktrue::verifier
