// Compares one tick between any number of sides: recordings, and runs that are under way.
// SPDX-License-Identifier: MIT
//
// Verified: of a tick, every part that two sides have: root hash, hash after each stage, state image, cells. A side
// with the state itself has its image and cells as well: they are made where another side stores them. Not verified:
// parts that only one side has. ComparedParts counts what was compared.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/state/cells.h"
#include "base/state/row_names.h"
#include "base/state/state_view.h"
#include "replay/format/trace.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// A copy of a recorded tick, valid beyond the reader's next step.
struct StoredTick {
  std::uint64_t tick = 0;
  double dt = 0;
  Bytes inputs;
  std::uint64_t root_hash = 0;
  std::vector<std::uint64_t> stage_hashes;  // empty unless stored
  std::optional<Bytes> image;
  std::optional<StateCells> cells;
};
StoredTick copy_of(const replay::TickRecord& record);

/// A copy of the checkpoint after a tick. It counts as another side of that tick.
struct StoredCheckpoint {
  std::uint64_t tick = 0;  // ticks done
  std::uint64_t root_hash = 0;
  Bytes image;
  std::optional<Bytes> shown = std::nullopt;
};
StoredCheckpoint copy_of(const replay::CheckpointRecord& record);

/// The data that one side has of a tick. The views must outlive it.
struct TickSide {
  std::uint64_t root_hash = 0;
  std::span<const std::uint64_t> stage_hashes = {};  // empty: not known
  std::optional<ByteView> image = std::nullopt;      // stored, as one piece
  std::optional<replay::StoredState> tables = {};    // stored, instead of the image
  const StateCells* cells = nullptr;                 // stored
  const StateView* state = nullptr;                  // after the tick; null: the side is a recording
};
TickSide side_of(const StoredTick& stored);
TickSide side_of(const replay::TickRecord& record);
TickSide side_of(const StoredCheckpoint& checkpoint);

enum class TickPart : std::uint8_t { root_hash, stage_hashes, image, cells };
struct TickPartInfo {
  TickPart part;
  std::string_view name;  // in sentences
};
inline constexpr std::array<TickPartInfo, 4> tick_parts{{
    {TickPart::root_hash, "root hash"},
    {TickPart::stage_hashes, "hashes after the stages"},
    {TickPart::image, "state image"},
    {TickPart::cells, "cells"},
}};
std::string_view name_of(TickPart part);

/// The first part that differs, in the order of tick_parts, and the first two sides between which it does.
struct TickDifference {
  TickPart part = TickPart::root_hash;
  std::size_t a = 0;
  std::size_t b = 0;
};

class TickComparer {
 public:
  /// The schema is that of the stored sides; ranges of columns do not matter.
  explicit TickComparer(const StateSchema& schema) : schema_(schema) {}

  /// Returns nothing if every part is the same on all sides that have the part.
  std::optional<TickDifference> compare(std::span<const TickSide> sides);

  /// Counts, for each part, the ticks in which it was compared between at least two sides since the last call.
  ComparedParts take_compared() { return std::exchange(compared_, {}); }

 private:
  bool same_images(const TickSide& a, const TickSide& b);
  bool same_cells(const TickSide& a, const TickSide& b);

  StateSchema schema_;
  std::optional<CellHasher> hasher_;  // made at the first cells
  Bytes image_;                       // reused
  Bytes other_image_;                 // reused
  StateCells cells_;                  // reused
  ComparedParts compared_;
};

/// Names and limits for describe_tick.
struct DescribeContext {
  const StateSchema& schema;
  std::span<const std::string> stages;
  RowNamer row_name;  // of the rows of `rows`; may be empty
  std::size_t row_count_max = 64;
  const StateView* rows = nullptr;  // state whose rows can be candidates; null: the state of `got`, if any
  std::string_view no_stages = "not known: the trace stores no hash after each stage of this tick";
};

/// Fills the hashes of `divergence`; also its stage, tables, rows and candidates if both sides store the data.
/// Errors: corrupt, if a stored image does not fit the schema.
Status describe_tick(const DescribeContext& context, const TickSide& expected, const TickSide& got,
                     Divergence& divergence);

/// A note if the root hashes of both sides agree and another part differs; empty for the root hash.
std::string contradiction_text(std::uint64_t tick, TickPart part);

/// A tick of this build, compared with a recording that ended because that tick was not finite.
struct NonFiniteTick {
  bool is_as_recorded = false;      // the state here is not finite, at the recorded place if that is known
  std::optional<StatePlace> place;  // in the state here
  std::string text;                 // a note if it is as recorded, else the reason of the verdict
  Divergence divergence;            // if it is not: tick, stage note and hash
};
/// `recorded_note`: of the end of the recording; it ends with the recorded place, or is empty.
NonFiniteTick compare_non_finite(std::uint64_t tick, const StateView& state, const std::string& recorded_note,
                                 const RowNamer& row_name);

}  // namespace ticktrue::verifier
