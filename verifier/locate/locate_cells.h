// Locates a difference from the cells of two states: columns exactly, and the rows that can have differed.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/state/cells.h"
#include "replay/format/trace.h"
#include "verifier/locate/locate.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// If all partitions name more rows than this, rows named by three partitions are listed too. If most cells differ, a
/// row with one cell that is unchanged by chance would otherwise be missed.
inline constexpr std::size_t short_list_max = 32;

/// The rows that the cells of two states can tell apart.
struct CellFinding {
  std::vector<CellOwner> candidates;  // of the given owners, those that can have differed
  std::vector<CellOwner> gone;        // of those given as gone
  bool healed = false;                // some candidates were named by three of four partitions
  std::uint32_t differing_cells = 0;
  std::uint32_t unexplained_cells = 0;  // differ, and no candidate's value goes into them
};

/// Every owner all of whose cells differ. Where these do not explain every differing cell, also those with three
/// differing cells, one of them unexplained: a value may change and leave one of its cells as it was.
/// Requires: equal partition_cells.
CellFinding find_candidates(const StateCells& expected, const StateCells& got, const std::vector<CellOwner>& owners,
                            const std::vector<CellOwner>& gone = {});

/// How many of `owner_count` owners differ, as estimated from how many cells do; exact where they are few.
std::uint64_t estimate_differing(const StateCells& expected, const StateCells& got, std::uint64_t owner_count);

/// The owners of a state both sides had, and their names.
struct RowsBefore {
  std::vector<CellOwner> owners;
  std::vector<std::string> names;         // [owner]
  std::vector<std::uint32_t> row_counts;  // [table]
};
RowsBefore rows_before(const StateView& state, const RowNamer& row_name);

/// Fills tables, row_counts and candidates of `divergence`. `rows`: a state whose owners are tried, the one here or the
/// last one known; null where there is none. `before`: of the state before the tick, for rows that only the other side
/// still has, or has under another key; may be null. At most `row_count_max` candidates are listed, all are counted.
void locate_cells(const StateSchema& schema, const StateCells& expected, const StateCells& got, const StateView* rows,
                  const RowNamer& row_name, std::size_t row_count_max, Divergence& divergence,
                  const RowsBefore* before = nullptr);

/// How many owners differ between a tick as recorded and the state here after it. Nothing where the trace stores only
/// a hash of the tick, and that differs.
std::optional<Spread> measure_spread(const StateSchema& schema, const replay::TickRecord& recorded,
                                     const StateView& here, CellHasher& hasher);
/// The same for two sets of cells, or for two states.
Spread spread_of_cells(const StateSchema& schema, const StateCells& a, const StateCells& b, std::uint64_t tick);
Spread spread_of_tables(const StateSchema& schema, std::span<const ImageTable> a, std::span<const ImageTable> b,
                        std::uint64_t tick);

/// The command, for the build that recorded `file`, that shows the values of a difference at `tick`.
std::string more_detail_command(const std::string& file, std::uint64_t tick, const std::string& tool);

/// A state view over an image. Requires: an image of the schema, which must outlive this.
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
