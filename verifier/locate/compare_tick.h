// Compares one tick between several sides: recordings, and running simulations.
// SPDX-License-Identifier: MIT
//
// Verified, for each part of a tick that two sides have: root hash, hash after each stage, state image, cells. A side
// with the state itself also has its image and cells: they are made if another side stores them. Not verified: parts
// that only one side has. ComparedParts counts the compared parts.
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

/// A copy of a recorded tick, which stays valid after the reader advances.
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

/// A copy of the checkpoint after a tick. It is compared as another side of this tick.
struct StoredCheckpoint {
  std::uint64_t tick = 0;  // number of ticks before it
  std::uint64_t root_hash = 0;
  Bytes image;
  std::optional<Bytes> shown = std::nullopt;
};
StoredCheckpoint copy_of(const replay::CheckpointRecord& record);

/// The data of a tick on one side. The views must outlive it.
struct TickSide {
  std::uint64_t root_hash = 0;
  std::span<const std::uint64_t> stage_hashes = {};  // empty: unknown
  std::optional<ByteView> image = std::nullopt;      // stored, as one image
  std::optional<replay::StoredState> tables = {};    // stored, as tables
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

/// The first differing part, in the order of tick_parts, and the first two sides that differ in it.
struct TickDifference {
  TickPart part = TickPart::root_hash;
  std::size_t a = 0;
  std::size_t b = 0;
};

class TickComparer {
 public:
  /// `schema`: of the stored sides; ranges of columns are ignored.
  explicit TickComparer(const StateSchema& schema) : schema_(schema) {}

  /// Nothing: each part is the same on all sides that have the part.
  std::optional<TickDifference> compare(std::span<const TickSide> sides);

  /// For each part, the number of ticks in which at least two sides had it, since the last call.
  ComparedParts take_compared() { return std::exchange(compared_, {}); }

 private:
  bool same_images(const TickSide& a, const TickSide& b);
  bool same_cells(const TickSide& a, const TickSide& b);

  StateSchema schema_;
  std::optional<CellHasher> hasher_;  // made when cells are first needed
  Bytes image_;                       // reused
  Bytes other_image_;                 // reused
  StateCells cells_;                  // reused
  ComparedParts compared_;
};

/// Names and limits for describe_tick.
struct DescribeContext {
  const StateSchema& schema;
  std::span<const std::string> stages;
  RowNamer row_name;  // names the rows of `rows`; may be empty
  std::size_t row_count_max = 64;
  const StateView* rows = nullptr;  // the state with the candidate rows; null: the state of `got`, if it has one
  std::string_view no_stages = "not known: the trace stores no hash after each stage of this tick";
};

/// Fills the hashes of `divergence`. If both sides store the data, also fills stage, tables, rows and candidates.
/// Errors: corrupt (a stored image does not fit the schema).
Status describe_tick(const DescribeContext& context, const TickSide& expected, const TickSide& got,
                     Divergence& divergence);

/// A note that the root hashes agree and another part differs; empty for the root hash.
std::string contradiction_text(std::uint64_t tick, TickPart part);

/// A tick of this build, compared with a recording that ended because this tick was not finite.
struct NonFiniteTick {
  bool is_as_recorded = false;      // the state here is not finite, at the recorded place if it is known
  std::optional<StatePlace> place;  // in the state here
  std::string text;                 // a note if it is as recorded, otherwise the reason of the verdict
  Divergence divergence;            // if it is not as recorded: tick, stage note and hash
};
/// `recorded_note`: the note at the end of the recording; it ends with the recorded place, or is empty.
NonFiniteTick compare_non_finite(std::uint64_t tick, const StateView& state, const std::string& recorded_note,
                                 const RowNamer& row_name);

}  // namespace ticktrue::verifier
