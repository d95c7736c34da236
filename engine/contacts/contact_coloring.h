// The colours of contacts, and which of them are solved by themselves.
// SPDX-License-Identifier: MIT
//
// A colour is a set of contacts of which no two move the same body. Contacts get colours in their order, each the
// lowest that its bodies do not have: a contact's colour depends on nothing but its island. So islands can be coloured,
// and solved, a few at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/caches.h"
#include "engine/contacts/contact_lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Scratch;
struct SolverSet;
struct State;

// One bit each in a body's colour set. Contacts between two moving bodies come first, those with something immovable
// last: the last ones solved are met best, and nothing may sink into the ground.
inline constexpr std::uint32_t class_color_count = 32;
inline constexpr std::uint32_t pass_color_count = 2 * class_color_count;

/// The colours of a body's contacts so far, one bit each: with what moves and with what does not.
struct BodyColors {
  std::uint32_t moving;
  std::uint32_t immovable;
};

/// The bodies that a contact moves, as rows; no_body for one that impulses do not move.
struct ContactBodies {
  std::uint32_t a;
  std::uint32_t b;

  bool operator==(const ContactBodies&) const = default;
};
inline constexpr std::uint32_t no_body = 0xffffffff;

/// The colour of a contact, and which of that colour in its block it is.
struct ContactColor {
  std::uint32_t color;
  std::uint32_t rank;
};

/// Where the contacts of a colour are: slots in a row.
struct ColorPlace {
  std::uint32_t count;  // of its contacts
  std::uint32_t first_slot;
};

/// Batches first..end-1.
struct BatchRange {
  std::uint32_t first;
  std::uint32_t end;
};

/// Contacts that no body ties to those of other blocks. Ranges of ContactColoring::contacts, ::rows and ::slots.
struct ContactBlock {
  std::uint32_t first = 0, end = 0;
  std::uint32_t first_row = 0, row_end = 0;
  std::uint32_t first_slot = 0, slot_end = 0;
};

/// The colours of some contacts, which follow from their ends alone: kept from tick to tick, they hold for the same
/// ends. So do the blocks, for the same bodies.
struct ContactColoring {
  /// The colours and slots as a cache. Key: `body_indices`, or `contact_generation` if all contacts are in the set.
  class Colors final : public TickCache {
   public:
    explicit Colors(ContactColoring& coloring) : TickCache(CacheKind::contact_colors), coloring_(coloring) {}
    void invalidate() override;
    void count(bool was_hit) { count_use(was_hit); }

   private:
    ContactColoring& coloring_;
  };
  /// The blocks as a cache. Key: no contact ties two blocks.
  class Blocks final : public TickCache {
   public:
    explicit Blocks(ContactColoring& coloring) : TickCache(CacheKind::contact_blocks), coloring_(coloring) {}
    void invalidate() override;
    void count(bool was_hit) { count_use(was_hit); }

   private:
    ContactColoring& coloring_;
  };

  ContactColoring() = default;
  ContactColoring(const ContactColoring&) = delete;
  ContactColoring& operator=(const ContactColoring&) = delete;

  Colors colors_cache{*this};
  Blocks blocks_cache{*this};
  std::vector<ContactBodies> body_indices;  // [contact of the group]
  std::uint32_t contact_generation = 0;     // TickLists', if they are all of it
  bool is_whole_set = false;
  bool is_split = false;  // into blocks; else there is one of everything, without rows
  std::vector<ContactBlock> blocks;
  std::vector<std::uint32_t> contacts;    // of the group, by block
  std::vector<std::uint32_t> slots;       // [block, batch, lane] the contact of the group, or no_contact
  std::vector<std::uint8_t> is_serial;    // [block, batch] 1: contacts of colours that have one each
  std::vector<BatchRange> color_batches;  // in solving order, where there is one block
  std::vector<std::uint32_t> rows;        // bodies that move, by block
  std::vector<std::uint32_t> free_rows;   // those that are in none
  std::vector<std::uint32_t> set_rows;    // those that the blocks were made for
  std::vector<std::uint32_t> block_of;    // [body] its block, or no_block; holds while no contact ties two blocks
  std::uint32_t ticks_unsplit = 0;        // to pass before islands are looked for
  std::vector<ContactColor> colors;       // [place in `contacts`]
  std::vector<std::uint32_t> uncolored;   // places of those that wait for the next round
  std::vector<ColorPlace> places;         // [round, colour] of a block
  std::vector<BodyColors> body_colors;    // [body]
  std::vector<std::uint32_t> block_starts;
  std::vector<std::uint32_t> island_parent;  // [body]
};
inline constexpr std::uint32_t no_block = 0xffffffff;

/// Colours the contacts of a group: scratch.caches.coloring. `may_split`: in blocks, if there are contacts enough for
/// some. Requires: prepare_bodies.
void color_contacts(Scratch& scratch, const SolverSet& set, bool may_split);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
