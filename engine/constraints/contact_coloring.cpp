// Colouring of contacts, and blocks of islands.
// SPDX-License-Identifier: MIT
#include "engine/constraints/contact_coloring.h"

#include <algorithm>
#include <atomic>

#include "engine/constraints/bodies.h"
#include "engine/scratch.h"
#include "engine/stages/islands.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr std::uint32_t uncolored = 0xffffffff;

/// So many contacts are worth another thread's while.
constexpr std::size_t ends_per_chunk_least = 256;

/// A block of so many contacts, with its bodies and batches, fits into a core's own cache.
constexpr std::size_t contacts_per_block = 1024;
/// Fewer are there all along, whatever the order.
constexpr std::size_t contacts_to_split_least = 2 * contacts_per_block;
/// Looking for islands costs as much as some ticks can save.
constexpr std::uint32_t ticks_between_splits = 16;

/// Fills coloring.ends. True if they are those that were there.
bool find_ends(Scratch& scratch, const SolveGroup& group, ContactColoring& coloring) {
  const std::uint32_t* contacts = scratch.group_contacts.data() + group.first_contact;
  const std::uint32_t unread = unread_record(scratch);
  const std::size_t count = group.contact_end - group.first_contact;
  const bool is_whole_set = count == scratch.touching.size();
  if (is_whole_set && coloring.is_whole_set && coloring.contact_set == scratch.kept.contact_set) return true;
  coloring.is_whole_set = is_whole_set;
  coloring.contact_set = scratch.kept.contact_set;
  std::atomic<bool> changed{coloring.ends.size() != count};
  coloring.ends.resize(count);
  const auto mover = [&](std::uint32_t row) { return scratch.masses[row].write == unread ? no_body : row; };
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, ends_per_chunk_least), [&](const Chunk& chunk) {
    bool same = true;
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const TouchingPair& pair = scratch.touching[contacts[i]];
      const ContactEnds ends{mover(pair.body_a), mover(pair.body_b)};
      same &= ends == coloring.ends[i];
      coloring.ends[i] = ends;
    }
    if (!same) changed.store(true, std::memory_order_relaxed);
  });
  return !changed.load(std::memory_order_relaxed);
}

// ---- Blocks ----

bool is_tie(const ContactEnds& ends) {
  return ends.a != no_body && ends.b != no_body;
}
std::uint32_t mover_of(const ContactEnds& ends) {
  return ends.a != no_body ? ends.a : ends.b;
}

/// Whether every contact is within a block still.
bool holds(const ContactColoring& coloring) {
  return !coloring.blocks.empty() && std::all_of(coloring.ends.begin(), coloring.ends.end(), [&](const auto& ends) {
    const std::uint32_t block = coloring.block_of[mover_of(ends)];
    return block != no_block && (!is_tie(ends) || coloring.block_of[ends.b] == block);
  });
}

/// Some islands to a block, in the order of their first rows. `forced`: so many contacts to a block, or 0 for as many
/// as pay. False: most contacts are of one island.
bool find_blocks(ContactColoring& coloring, std::size_t body_count, std::size_t forced) {
  std::vector<std::uint32_t>& parent = coloring.island_parent;
  parent.resize(body_count);
  for (std::uint32_t row = 0; row < body_count; ++row) parent[row] = row;
  for (const ContactEnds& ends : coloring.ends)
    if (is_tie(ends)) unite(parent, ends.a, ends.b);
  std::vector<std::uint32_t>& counts = coloring.block_starts;  // [body] contacts of the island, at its first row
  counts.assign(body_count, 0);
  std::uint32_t most = 0;
  for (const ContactEnds& ends : coloring.ends) most = std::max(most, ++counts[find_root(parent, mover_of(ends))]);
  if (forced == 0 && most > coloring.ends.size() / 2) return false;
  const std::size_t wanted = forced > 0 ? forced : contacts_per_block;
  coloring.block_of.assign(body_count, no_block);
  std::uint32_t block = 0;
  std::uint32_t in_block = 0;
  for (std::uint32_t row = 0; row < body_count; ++row) {
    const std::uint32_t root = find_root(parent, row);
    if (root == row && counts[row] > 0) {
      if (in_block > 0 && in_block + counts[row] > wanted) {
        ++block;
        in_block = 0;
      }
      in_block += counts[row];
      coloring.block_of[row] = block;
    }
    coloring.block_of[row] = coloring.block_of[root];  // the root comes first
  }
  coloring.blocks.assign(block + 1, {});
  return true;
}

/// Sorts what is `count` long into `out` by block, each in its order. block_at(i): of the i-th, or no_block.
/// set_range(block, first, end).
template <typename BlockAt, typename SetRange>
void sort_by_block(ContactColoring& coloring, std::size_t count, BlockAt block_at, std::vector<std::uint32_t>& out,
                   SetRange set_range) {
  std::vector<std::uint32_t>& starts = coloring.block_starts;
  starts.assign(coloring.blocks.size() + 2, 0);
  const auto no_block_place = static_cast<std::uint32_t>(coloring.blocks.size());
  const auto place_of = [&](std::size_t i) { return std::min(block_at(i), no_block_place); };
  for (std::size_t i = 0; i < count; ++i) ++starts[place_of(i) + 1];
  for (std::size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
  for (std::size_t i = 0; i < coloring.blocks.size(); ++i) set_range(coloring.blocks[i], starts[i], starts[i + 1]);
  out.resize(count);
  for (std::size_t i = 0; i < count; ++i) out[starts[place_of(i)]++] = static_cast<std::uint32_t>(i);
}

/// Puts contacts and bodies into the blocks.
void fill_blocks(ContactColoring& coloring) {
  sort_by_block(
      coloring, coloring.ends.size(), [&](std::size_t i) { return coloring.block_of[mover_of(coloring.ends[i])]; },
      coloring.contacts,
      [](ContactBlock& block, std::uint32_t first, std::uint32_t end) {
        block.first = first;
        block.end = end;
      });
  const std::vector<std::uint32_t>& rows = coloring.group_rows;
  std::uint32_t in_blocks = 0;
  sort_by_block(
      coloring, rows.size(), [&](std::size_t i) { return coloring.block_of[rows[i]]; }, coloring.rows,
      [&](ContactBlock& block, std::uint32_t first, std::uint32_t end) {
        block.first_row = first;
        block.row_end = in_blocks = end;
      });
  for (std::uint32_t& row : coloring.rows) row = rows[row];
  coloring.free_rows.assign(coloring.rows.begin() + in_blocks, coloring.rows.end());
}

/// Splits the contacts into blocks, if that is worth it.
bool split(const Scratch& scratch, ContactColoring& coloring) {
  const std::size_t forced = scratch.parallel.chunk_size_forced;
  if (coloring.ends.size() < (forced > 0 ? 1 : contacts_to_split_least)) return false;
  const std::size_t body_count = scratch.masses.size();
  if (coloring.block_of.size() != body_count || !holds(coloring)) {
    if (forced == 0 && coloring.ticks_unsplit > 0) {
      --coloring.ticks_unsplit;
      return false;
    }
    coloring.ticks_unsplit = ticks_between_splits;
    if (!find_blocks(coloring, body_count, forced)) return false;
  }
  fill_blocks(coloring);
  return true;
}

void make_one_block(ContactColoring& coloring) {
  const auto count = static_cast<std::uint32_t>(coloring.ends.size());
  coloring.block_of.clear();
  coloring.blocks.assign(1, {});
  coloring.blocks[0].end = count;
  coloring.contacts.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) coloring.contacts[i] = i;
}

// ---- Colours ----

/// Colours the contacts of one round, and counts those of each colour; those of bodies that have no colour left wait
/// for the next. True if any do.
template <bool is_first>
bool color_round(ContactColoring& out, const ContactBlock& block, std::uint32_t round, ColorPlace* places) {
  bool any_left = false;
  const std::uint32_t first_color = round * round_color_count;
  for (std::uint32_t i = block.first; i < block.end; ++i) {
    if (!is_first && out.colors[i].color != uncolored) continue;
    const ContactEnds ends = out.ends[out.contacts[i]];
    const bool both_move = is_tie(ends);
    std::uint32_t used;
    if (both_move) {
      BodyColors& a = out.body_colors[ends.a];
      BodyColors& b = out.body_colors[ends.b];
      used = a.moving | b.moving;
      const std::uint32_t bit = ~used & (used + 1);  // the lowest that is free, or none
      a.moving |= bit;
      b.moving |= bit;
    } else {
      BodyColors& mover = out.body_colors[mover_of(ends)];
      used = mover.immovable;
      mover.immovable |= ~used & (used + 1);
    }
    const bool is_left = used == 0xffffffffu;
    any_left |= is_left;
    out.colors[i] = {uncolored, 0};
    if (is_left) continue;
    const std::uint32_t color = static_cast<std::uint32_t>(__builtin_ctz(~used)) + (both_move ? 0u : class_color_count);
    out.colors[i] = {first_color + color, places[color].count++};
  }
  return any_left;
}

/// Puts the contacts of a block into slots: colour by colour, those of moving bodies first, each from a batch's begin
/// on.
void fill_slots(ContactColoring& out, ContactBlock& block, std::uint32_t round_count) {
  block.first_slot = static_cast<std::uint32_t>(out.slots.size());
  std::uint32_t next = block.first_slot;
  for (const std::uint32_t first : {0u, class_color_count})
    for (std::uint32_t round = 0; round < round_count; ++round)
      for (std::uint32_t color = 0; color < class_color_count; ++color) {
        ColorPlace& place = out.places[round * round_color_count + first + color];
        if (place.count == 0) continue;
        place.first_slot = next;
        next += (place.count + contact_lane_count - 1) / contact_lane_count * contact_lane_count;
        if (!out.is_split)
          out.color_batches.push_back({place.first_slot / contact_lane_count, next / contact_lane_count});
      }
  block.slot_end = next;
  out.slots.resize(next, no_contact);
  for (std::uint32_t i = block.first; i < block.end; ++i)
    out.slots[out.places[out.colors[i].color].first_slot + out.colors[i].rank] = out.contacts[i];
}

void color_block(ContactColoring& out, ContactBlock& block) {
  out.places.clear();
  std::uint32_t round_count = 0;
  bool any_left = true;
  while (any_left) {
    if (round_count > 0)
      for (std::uint32_t i = block.first; i < block.end; ++i) {
        const ContactEnds ends = out.ends[out.contacts[i]];
        for (const std::uint32_t row : {ends.a, ends.b})
          if (row != no_body) out.body_colors[row] = {0, 0};
      }
    const std::size_t first = out.places.size();
    out.places.resize(first + round_color_count, {0, 0});
    ColorPlace* places = out.places.data() + first;
    any_left = round_count == 0 ? color_round<true>(out, block, 0, places)
                                : color_round<false>(out, block, round_count, places);
    ++round_count;
  }
  fill_slots(out, block, round_count);
}

}  // namespace

void color_contacts(Scratch& scratch, const SolveGroup& group, bool may_split) {
  ContactColoring& coloring = scratch.kept.coloring;
  const bool same_ends = find_ends(scratch, group, coloring) && !coloring.blocks.empty();
  if (may_split) {
    const std::span<const std::uint32_t> rows(scratch.group_rows.data() + group.first_row,
                                              group.row_end - group.first_row);
    const bool same_rows = std::equal(rows.begin(), rows.end(), coloring.group_rows.begin(), coloring.group_rows.end());
    if (same_ends && same_rows && coloring.is_split) return;
    coloring.group_rows.assign(rows.begin(), rows.end());
    const bool was_split = coloring.is_split;
    coloring.is_split = split(scratch, coloring);
    if (!coloring.is_split && same_ends && !was_split) return;
  } else {
    if (same_ends && !coloring.is_split) return;
    coloring.is_split = false;
  }
  if (!coloring.is_split) make_one_block(coloring);
  coloring.colors.resize(coloring.ends.size());
  coloring.slots.clear();
  coloring.color_batches.clear();
  coloring.body_colors.assign(scratch.masses.size(), {0, 0});
  for (ContactBlock& block : coloring.blocks) color_block(coloring, block);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
