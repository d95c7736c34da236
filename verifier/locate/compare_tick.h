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
#include "replay/trace.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// A tick as recorded, kept beyond the reader's next step.
struct StoredTick {
  std::uint64_t tick = 0;
  double dt = 0;
  Bytes inputs;
  std::uint64_t root_hash = 0;
  std::vector<std::uint64_t> stage_hashes;  // empty unless stored
  std::optional<Bytes> image;
  Bytes cells;  // encoded; empty unless stored
};
StoredTick keep(const replay::TickRecord& record);

/// The checkpoint behind a tick. Of that tick it is a side of its own.
struct StoredCheckpoint {
  std::uint64_t tick = 0;  // ticks done
  std::uint64_t root_hash = 0;
  Bytes image;
};
StoredCheckpoint keep(const replay::CheckpointRecord& record);

/// What one side has of a tick. The views must outlive it.
struct TickSide {
  std::uint64_t root_hash = 0;
  std::span<const std::uint64_t> stage_hashes = {};  // empty: not known
  std::optional<ByteView> image = std::nullopt;      // stored
  ByteView cells = {};                               // stored, encoded
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

  /// Nothing if every part is the same on all sides that have it.
  std::optional<TickDifference> compare(std::span<const TickSide> sides);

  /// Ticks of which each part was compared between two sides at least, since the last call.
  ComparedParts take_compared() { return std::exchange(compared_, {}); }

 private:
  bool same_images(const TickSide& a, const TickSide& b);
  bool same_cells(const TickSide& a, const TickSide& b);
  StateCells cells_of_side(const TickSide& side, std::uint32_t partition_cells);

  StateSchema schema_;
  std::optional<CellHasher> hasher_;  // made at the first cells
  Bytes image_;                       // reused
  ComparedParts compared_;
};

/// What describe_tick needs beside the two sides.
struct TickWords {
  const StateSchema& schema;
  std::span<const std::string> stages;
  RowNamer row_name;  // of the rows of `rows`; may be empty
  std::size_t row_count_max = 64;
  const StateView* rows = nullptr;  // whose rows cells may name; null: those of `got`, where it has a state
  std::string_view no_stages = "not known: the trace stores no hash after each stage of this tick";
};

/// Fills the hashes, and as far as both sides store it stage, tables, rows and candidates of `divergence`.
/// Errors: corrupt, if a stored image does not fit the schema.
Status describe_tick(const TickWords& words, const TickSide& expected, const TickSide& got, Divergence& divergence);

/// A note for people where the root hashes of both sides agree and another part does not; empty for the root hash.
std::string contradiction_text(std::uint64_t tick, TickPart part);

}  // namespace ticktrue::verifier
