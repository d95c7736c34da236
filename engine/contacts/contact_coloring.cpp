// Colouring of contacts, and blocks of islands.
// SPDX-License-Identifier: MIT
#include "engine/contacts/contact_coloring.h"

#include <algorithm>
#include <atomic>

#include "engine/islands/islands.h"
#include "engine/model/bodies.h"
#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The least number of contacts per chunk for which a second thread pays.
constexpr std::size_t contact_bodies_per_chunk_least = 256;
constexpr std::size_t slots_per_chunk_least = 1024;

/// A block of this many contacts, with its bodies and batches, fits into a core's own cache.
constexpr std::size_t contacts_per_block = 1024;
/// Fewer contacts stay in the cache in any order.
constexpr std::size_t contacts_to_split_least = 2 * contacts_per_block;
/// Finding islands costs as much as several ticks can save.
constexpr std::uint32_t ticks_between_splits = 16;

/// Fills coloring.body_indices: entry i is bodies_at(i). True if no entry has changed.
template <typename BodiesAt>
bool find_contact_bodies(const Parallel& parallel, std::size_t count, BodiesAt bodies_at, ContactColoring& coloring) {
  std::atomic<bool> changed{coloring.body_indices.size() != count};
  coloring.body_indices.resize(count);
  parallel.for_chunks(count, parallel.chunk_size(count, contact_bodies_per_chunk_least), [&](const Chunk& chunk) {
    bool same = true;
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const ContactBodies bodies = bodies_at(i);
      same &= bodies == coloring.body_indices[i];
      coloring.body_indices[i] = bodies;
    }
    if (!same) changed.store(true, std::memory_order_relaxed);
  });
  return !changed.load(std::memory_order_relaxed);
}

/// Whether the colours are those of all present contacts.
bool are_colored(const Scratch& scratch, const ContactColoring& coloring) {
  return coloring.is_whole_set && coloring.contact_generation == scratch.contact_generation;
}

/// Finds the dynamic bodies of the set's contacts. True if they have not changed.
bool find_contact_bodies_of_set(Scratch& scratch, const SolverSet& set, ContactColoring& coloring) {
  const std::size_t count = set.contact_end - set.first_contact;
  const bool is_whole_set = count == scratch.contact_pairs.size();
  if (is_whole_set && are_colored(scratch, coloring)) return true;
  coloring.is_whole_set = is_whole_set;
  coloring.contact_generation = scratch.contact_generation;
  const std::uint32_t* contacts = scratch.set_contacts.data() + set.first_contact;
  const std::uint32_t sink = dummy_sink(scratch);
  const auto dynamic_row = [&](std::uint32_t row) { return scratch.masses[row].write == sink ? no_body : row; };
  const auto bodies_at = [&](std::size_t i) {
    const ContactPair& pair = scratch.contact_pairs[contacts[i]];
    return ContactBodies{dynamic_row(pair.body_a), dynamic_row(pair.body_b)};
  };
  return find_contact_bodies(scratch.parallel, count, bodies_at, coloring);
}

// ---- Blocks ----

bool moves_both(const ContactBodies& bodies) {
  return bodies.a != no_body && bodies.b != no_body;
}
std::uint32_t dynamic_body_of(const ContactBodies& bodies) {
  return bodies.a != no_body ? bodies.a : bodies.b;
}

/// Whether each contact is still within one block.
bool blocks_are_valid(const ContactColoring& coloring) {
  return !coloring.blocks.empty() &&
         std::all_of(coloring.body_indices.begin(), coloring.body_indices.end(), [&](const auto& bodies) {
           const std::uint32_t block = coloring.block_of[dynamic_body_of(bodies)];
           return block != no_block && (!moves_both(bodies) || coloring.block_of[bodies.b] == block);
         });
}

/// Puts several islands into each block, in the order of their first rows. `forced`: contacts per block, or 0 for the
/// default. False: most contacts are of one island.
bool find_blocks(ContactColoring& coloring, std::size_t body_count, std::size_t forced) {
  std::vector<std::uint32_t>& parent = coloring.island_parent;
  parent.resize(body_count);
  for (std::uint32_t row = 0; row < body_count; ++row) parent[row] = row;
  for (const ContactBodies& bodies : coloring.body_indices)
    if (moves_both(bodies)) unite(parent, bodies.a, bodies.b);
  std::vector<std::uint32_t>& counts = coloring.block_starts;  // [body] contacts of the island, at its first row
  counts.assign(body_count, 0);
  std::uint32_t most = 0;
  for (const ContactBodies& bodies : coloring.body_indices)
    most = std::max(most, ++counts[find_root(parent, dynamic_body_of(bodies))]);
  if (forced == 0 && most > coloring.body_indices.size() / 2) return false;
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
    coloring.block_of[row] = coloring.block_of[root];  // a root precedes its island
  }
  coloring.blocks.assign(block + 1, {});
  return true;
}

/// Sorts `count` elements by block into `out`, stable. block_at(i): block of element i, or no_block. set_range(block,
/// first, end).
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

/// Assigns contacts and bodies to the blocks.
void fill_blocks(ContactColoring& coloring) {
  sort_by_block(
      coloring, coloring.body_indices.size(),
      [&](std::size_t i) { return coloring.block_of[dynamic_body_of(coloring.body_indices[i])]; }, coloring.contacts,
      [](ContactBlock& block, std::uint32_t first, std::uint32_t end) {
        block.first = first;
        block.end = end;
      });
  const std::vector<std::uint32_t>& rows = coloring.set_rows;
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

/// Splits the contacts into blocks, if that pays.
bool split(Scratch& scratch, ContactColoring& coloring) {
  const std::size_t forced = scratch.parallel.chunk_size_forced;
  if (coloring.body_indices.size() < (forced > 0 ? 1 : contacts_to_split_least)) return false;
  const std::size_t body_count = scratch.masses.size();
  const bool is_hit = coloring.block_of.size() == body_count && blocks_are_valid(coloring);
  coloring.blocks_cache.count(is_hit);
  if (!is_hit) {
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
  const auto count = static_cast<std::uint32_t>(coloring.body_indices.size());
  coloring.block_of.clear();
  coloring.blocks.assign(1, {});
  coloring.blocks[0].end = count;
  coloring.contacts.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) coloring.contacts[i] = i;
}

// ---- Colours ----

/// Colours `count` contacts, at place_at(0), .. in the block. A contact whose body has no free colour left goes to
/// `uncolored`, for the next pass. Returns the number of these contacts.
template <typename PlaceAt>
std::size_t color_pass(ContactColoring& out, std::size_t count, PlaceAt place_at, std::uint32_t pass) {
  std::size_t uncolored_count = 0;
  const std::uint32_t first_color = pass * pass_color_count;
  out.places.resize(first_color + pass_color_count, {0, 0});
  ColorPlace* places = out.places.data() + first_color;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t place = place_at(i);
    const ContactBodies bodies = out.body_indices[out.contacts[place]];
    const bool both_move = moves_both(bodies);
    std::uint32_t used;
    if (both_move) {
      BodyColors& a = out.body_colors[bodies.a];
      BodyColors& b = out.body_colors[bodies.b];
      used = a.moving | b.moving;
      const std::uint32_t bit = ~used & (used + 1);  // the lowest free bit, or none
      a.moving |= bit;
      b.moving |= bit;
    } else {
      BodyColors& body = out.body_colors[dynamic_body_of(bodies)];
      used = body.immovable;
      body.immovable |= ~used & (used + 1);
    }
    if (used == 0xffffffffu) {
      out.uncolored[uncolored_count++] = place;
      continue;
    }
    const std::uint32_t color = static_cast<std::uint32_t>(__builtin_ctz(~used)) + (both_move ? 0u : class_color_count);
    out.colors[place] = {first_color + color, places[color].count++};
  }
  return uncolored_count;
}

/// Puts the contacts of a block into slots, colour by colour, contacts between dynamic bodies first. Each colour begins
/// a new batch. Colours with one contact, as of a body that touches everything, share batches that are solved serially.
void fill_slots(const Parallel& parallel, ContactColoring& out, ContactBlock& block, std::uint32_t pass_count) {
  block.first_slot = static_cast<std::uint32_t>(out.slots.size());
  std::uint32_t next = block.first_slot;
  for (const std::uint32_t first : {0u, class_color_count}) {
    std::uint32_t serial_count = 0;  // contacts of the last batch, if it is serial
    for (std::uint32_t pass = 0; pass < pass_count; ++pass)
      for (std::uint32_t color = 0; color < class_color_count; ++color) {
        ColorPlace& place = out.places[pass * pass_color_count + first + color];
        if (place.count == 0) continue;
        if (place.count == 1 && serial_count % contact_lane_count != 0) {
          place.first_slot = next - contact_lane_count + serial_count++;
          continue;
        }
        serial_count = place.count == 1 ? 1 : 0;
        const std::uint32_t batch_count = (place.count + contact_lane_count - 1) / contact_lane_count;
        place.first_slot = next;
        next += batch_count * contact_lane_count;
        out.is_serial.insert(out.is_serial.end(), batch_count, static_cast<std::uint8_t>(serial_count));
        if (!out.is_split)
          out.color_batches.push_back({place.first_slot / contact_lane_count, next / contact_lane_count});
      }
  }
  block.slot_end = next;
  out.slots.resize(next, no_contact);
  const std::size_t count = block.end - block.first;
  parallel.for_chunks(count, parallel.chunk_size(count, slots_per_chunk_least), [&](const Chunk& chunk) {
    for (std::size_t i = block.first + chunk.begin; i < block.first + chunk.end; ++i)
      out.slots[out.places[out.colors[i].color].first_slot + out.colors[i].rank] = out.contacts[i];
  });
}

void color_block(const Parallel& parallel, ContactColoring& out, ContactBlock& block) {
  out.places.clear();
  out.uncolored.resize(out.colors.size());
  std::uint32_t pass_count = 1;
  std::size_t uncolored_count = color_pass(
      out, block.end - block.first, [&](std::size_t i) { return block.first + static_cast<std::uint32_t>(i); }, 0);
  while (uncolored_count > 0) {
    for (std::size_t i = 0; i < uncolored_count; ++i) {
      const ContactBodies bodies = out.body_indices[out.contacts[out.uncolored[i]]];
      for (const std::uint32_t row : {bodies.a, bodies.b})
        if (row != no_body) out.body_colors[row] = {0, 0};
    }
    uncolored_count = color_pass(
        out, uncolored_count, [&](std::size_t i) { return out.uncolored[i]; }, pass_count++);
  }
  fill_slots(parallel, out, block, pass_count);
}

void color_blocks(const Parallel& parallel, std::size_t body_count, ContactColoring& coloring) {
  coloring.colors.resize(coloring.body_indices.size());
  coloring.slots.clear();
  coloring.is_serial.clear();
  coloring.color_batches.clear();
  coloring.body_colors.assign(body_count, {0, 0});
  for (ContactBlock& block : coloring.blocks) color_block(parallel, coloring, block);
}

}  // namespace

void ContactColoring::Colors::invalidate() {
  coloring_.is_whole_set = false;
  coloring_.body_indices.clear();
  coloring_.blocks.clear();
}

void ContactColoring::Blocks::invalidate() {
  coloring_.block_of.clear();
  coloring_.set_rows.clear();
  coloring_.ticks_unsplit = 0;
}

void color_contacts(Scratch& scratch, const SolverSet& set, bool may_split) {
  ContactColoring& coloring = scratch.caches.coloring;
  const bool same_bodies = find_contact_bodies_of_set(scratch, set, coloring) && !coloring.blocks.empty();
  coloring.colors_cache.count(same_bodies);
  if (may_split) {
    const std::span<const std::uint32_t> rows(scratch.set_rows.data() + set.first_row, set.row_end - set.first_row);
    const bool same_rows = std::equal(rows.begin(), rows.end(), coloring.set_rows.begin(), coloring.set_rows.end());
    if (same_bodies && same_rows && coloring.is_split) {
      coloring.blocks_cache.count(true);
      return;
    }
    coloring.set_rows.assign(rows.begin(), rows.end());
    const bool was_split = coloring.is_split;
    coloring.is_split = split(scratch, coloring);
    if (!coloring.is_split && same_bodies && !was_split) return;
  } else {
    if (same_bodies && !coloring.is_split) return;
    coloring.is_split = false;
  }
  if (!coloring.is_split) make_one_block(coloring);
  color_blocks(scratch.parallel, scratch.masses.size(), coloring);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
