// Compares the parts of a tick.
// SPDX-License-Identifier: MIT
#include "verifier/locate/compare_tick.h"

#include <algorithm>
#include <utility>

#include "replay/format/payload.h"
#include "verifier/locate/locate.h"
#include "verifier/locate/locate_cells.h"

namespace ticktrue::verifier {
namespace {

bool equal_bytes(ByteView a, ByteView b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

/// The first two of the sides with this part whose parts differ. `count`: incremented if two sides have the part.
template <typename Has, typename Same>
std::optional<TickDifference> first_difference(std::span<const TickSide> sides, TickPart part, std::uint64_t& count,
                                               Has has, Same same) {
  std::size_t first = 0;
  while (first < sides.size() && !has(sides[first])) ++first;
  bool is_counted = false;
  for (std::size_t i = first + 1; i < sides.size(); ++i) {
    if (!has(sides[i])) continue;
    if (!is_counted) ++count;
    is_counted = true;
    if (!same(sides[first], sides[i])) return TickDifference{part, first, i};
  }
  return std::nullopt;
}

bool stores_state(const TickSide& side) {
  return side.image || side.tables;
}

/// The image of a side: the stored image, or an image made from its tables or its state.
ByteView image_of(const TickSide& side, Bytes& buffer) {
  if (side.image) return *side.image;
  if (side.tables)
    join_image(side.tables->tables, buffer);
  else
    encode_image(*side.state, buffer);
  return buffer;
}

/// Compares the tables that one side stores for the state with those of the other side.
bool same_tables(const replay::StoredState& stored, std::span<const ImageTable> other) {
  return std::all_of(stored.stored.begin(), stored.stored.end(), [&](std::uint32_t t) {
    return stored.tables[t].row_count == other[t].row_count && equal_bytes(stored.tables[t].rows, other[t].rows);
  });
}

}  // namespace

StoredTick copy_of(const replay::TickRecord& record) {
  StoredTick copy;
  copy.tick = record.tick;
  copy.dt = record.dt;
  copy.inputs.assign(record.inputs.begin(), record.inputs.end());
  copy.root_hash = record.root_hash;
  copy.stage_hashes = record.stage_hashes;
  if (record.image) copy.image = record.image->joined();
  if (record.cells != nullptr) copy.cells = *record.cells;
  return copy;
}

StoredCheckpoint copy_of(const replay::CheckpointRecord& record) {
  StoredCheckpoint copy{record.tick, record.root_hash, Bytes(record.image.begin(), record.image.end())};
  if (record.shown) copy.shown.emplace(record.shown->begin(), record.shown->end());
  return copy;
}

TickSide side_of(const StoredTick& stored) {
  TickSide side{stored.root_hash, stored.stage_hashes};
  if (stored.image) side.image = ByteView(*stored.image);
  if (stored.cells) side.cells = &*stored.cells;
  return side;
}

TickSide side_of(const replay::TickRecord& record) {
  TickSide side{record.root_hash, record.stage_hashes};
  side.tables = record.image;
  side.cells = record.cells;
  return side;
}

TickSide side_of(const StoredCheckpoint& checkpoint) {
  TickSide side{checkpoint.root_hash};
  side.image = ByteView(checkpoint.image);
  return side;
}

std::string_view name_of(TickPart part) {
  for (const TickPartInfo& info : tick_parts)
    if (info.part == part) return info.name;
  return "";
}

std::optional<TickDifference> TickComparer::compare(std::span<const TickSide> sides) {
  const auto all = [](const TickSide&) { return true; };
  const auto same_root = [](const TickSide& a, const TickSide& b) { return a.root_hash == b.root_hash; };
  if (const auto found = first_difference(sides, TickPart::root_hash, compared_.ticks, all, same_root)) return found;

  const auto has_stages = [](const TickSide& side) { return !side.stage_hashes.empty(); };
  const auto same_stages = [](const TickSide& a, const TickSide& b) {
    return std::equal(a.stage_hashes.begin(), a.stage_hashes.end(), b.stage_hashes.begin(), b.stage_hashes.end());
  };
  if (const auto found =
          first_difference(sides, TickPart::stage_hashes, compared_.stage_hashes, has_stages, same_stages))
    return found;

  const bool any_image = std::any_of(sides.begin(), sides.end(), stores_state);
  const auto has_image = [&](const TickSide& side) {
    return stores_state(side) || (any_image && side.state != nullptr);
  };
  const auto same_image = [&](const TickSide& a, const TickSide& b) { return same_images(a, b); };
  if (const auto found = first_difference(sides, TickPart::image, compared_.images, has_image, same_image))
    return found;

  const bool any_cells = std::any_of(sides.begin(), sides.end(), [](const TickSide& s) { return s.cells != nullptr; });
  const auto has_cells = [&](const TickSide& side) {
    return side.cells != nullptr || (any_cells && side.state != nullptr);
  };
  const auto same_cell = [&](const TickSide& a, const TickSide& b) { return same_cells(a, b); };
  return first_difference(sides, TickPart::cells, compared_.cells, has_cells, same_cell);
}

/// Requires: equal root hashes. They prove the tables that no side stores for this state.
bool TickComparer::same_images(const TickSide& a, const TickSide& b) {
  if (a.tables && b.tables) return same_tables(*a.tables, b.tables->tables) && same_tables(*b.tables, a.tables->tables);
  if (a.state != nullptr && b.state != nullptr && !stores_state(a) && !stores_state(b)) return true;
  const TickSide& stored = a.tables ? a : b;
  const TickSide& other = a.tables ? b : a;
  if (stored.tables && other.state != nullptr && !other.image)
    return same_tables(*stored.tables, canonical_tables(*other.state, image_));
  return equal_bytes(image_of(a, image_), image_of(b, other_image_));
}

bool TickComparer::same_cells(const TickSide& a, const TickSide& b) {
  const StateCells& stored = a.cells != nullptr ? *a.cells : *b.cells;
  const StateCells* other = a.cells != nullptr ? b.cells : a.cells;
  if (other == nullptr) {
    if (!hasher_) hasher_.emplace(schema_);
    hasher_->hash(a.cells != nullptr ? *b.state : *a.state, stored.partition_cells, cells_);
    other = &cells_;
  }
  if (stored.partition_cells == other->partition_cells) return stored == *other;
  return stored.row_counts == other->row_counts && stored.columns == other->columns;
}

Status describe_tick(const DescribeContext& context, const TickSide& expected, const TickSide& got,
                     Divergence& divergence) {
  divergence.expected_root = expected.root_hash;
  divergence.got_root = got.root_hash;
  if (expected.stage_hashes.empty() || got.stage_hashes.empty())
    divergence.stage_note = context.no_stages;
  else
    locate_stage(context.stages, expected.stage_hashes, got.stage_hashes, divergence);

  if (stores_state(expected) && (stores_state(got) || got.state != nullptr)) {
    Bytes made_expected, made_got;
    return locate_lanes(context.schema, image_of(expected, made_expected), image_of(got, made_got), context.row_name,
                        context.row_count_max, divergence);
  }
  if (expected.cells == nullptr || (got.cells == nullptr && got.state == nullptr)) return {};
  const StateCells& there = *expected.cells;
  StateCells made;
  if (got.cells == nullptr) CellHasher(context.schema).hash(*got.state, there.partition_cells, made);
  const StateCells& here = got.cells != nullptr ? *got.cells : made;
  const StateView* rows = context.rows != nullptr ? context.rows : got.state;
  locate_cells(context.schema, there, here, rows, context.row_name, context.row_count_max, divergence);
  return {};
}

std::string contradiction_text(std::uint64_t tick, TickPart part) {
  if (part == TickPart::root_hash) return "";
  return "tick " + std::to_string(tick) + ": the root hash agrees, the " + std::string(name_of(part)) +
         (part == TickPart::image ? " does not" : " do not") +
         (part == TickPart::stage_hashes ? ": the stages do other work to the same end, or the record was changed"
                                         : ": the record contradicts itself, as if it was changed");
}

NonFiniteTick compare_non_finite(std::uint64_t tick, const StateView& state, const std::string& recorded_note,
                                 const RowNamer& row_name) {
  NonFiniteTick found;
  found.place = find_non_finite(state);
  const std::string here = found.place ? place_text(*state.schema, *found.place, row_name) : "";
  const std::string number = "tick " + std::to_string(tick);
  found.is_as_recorded = found.place && (recorded_note.empty() || recorded_note.find(here) != std::string::npos);
  if (found.is_as_recorded) {
    found.text = number + " is not finite, as recorded: " + here;
    return found;
  }
  found.text = number + ": recorded as not finite (" + recorded_note + "), here " +
               (found.place ? "it is not finite at " + here : std::string("it is finite"));
  found.divergence.tick = tick;
  found.divergence.stage_note = "not known: a tick that is not finite is not stored";
  found.divergence.got_root = root_hash(state);
  return found;
}

}  // namespace ticktrue::verifier
