// The colours of contacts, and the blocks of islands that are solved separately.
// SPDX-License-Identifier: MIT
//
// A colour is a set of contacts without a common dynamic body. Each contact, in order, gets the lowest colour that its
// bodies do not have yet. The colour therefore depends on its island alone, and islands can be coloured and solved a
// few at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/contacts/contact_lanes.h"
#include "engine/model/caches.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Scratch;
struct SolverSet;
struct State;

// One bit for each colour of a body. Contacts between dynamic bodies are solved first and contacts with other bodies
// last: the last ones are solved most exactly, so that nothing sinks into the ground.
inline constexpr std::uint32_t class_color_count = 32;
inline constexpr std::uint32_t pass_color_count = 2 * class_color_count;

/// The colours of a body's contacts so far, one bit each: with dynamic and with other bodies.
struct BodyColors {
  std::uint32_t moving;
  std::uint32_t immovable;
};

/// The rows of a contact's dynamic bodies; no_body for other bodies.
struct ContactBodies {
  std::uint32_t a;
  std::uint32_t b;

  bool operator==(const ContactBodies&) const = default;
};
inline constexpr std::uint32_t no_body = 0xffffffff;

/// The colour of a contact, and its rank among the contacts of this colour in its block.
struct ContactColor {
  std::uint32_t color;
  std::uint32_t rank;
};

/// The consecutive slots of a colour.
struct ColorPlace {
  std::uint32_t count;  // of its contacts
  std::uint32_t first_slot;
};

/// Batches first..end-1.
struct BatchRange {
  std::uint32_t first;
  std::uint32_t end;
};

/// Contacts that share no dynamic body with other blocks. Ranges of ContactColoring::contacts, ::rows and ::slots.
struct ContactBlock {
  std::uint32_t first = 0, end = 0;
  std::uint32_t first_row = 0, row_end = 0;
  std::uint32_t first_slot = 0, slot_end = 0;
};

/// A cache of colours and blocks. Colours are valid for the same body indices, blocks for the same bodies.
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
  std::vector<ContactBodies> body_indices;  // [contact of the set]
  std::uint32_t contact_generation = 0;     // TickLists', if they are all of it
  bool is_whole_set = false;
  bool is_split = false;  // into blocks; else there is one block, without rows
  std::vector<ContactBlock> blocks;
  std::vector<std::uint32_t> contacts;    // [block] contacts of the set
  std::vector<std::uint32_t> slots;       // [block, batch, lane] contact of the set, or no_contact
  std::vector<std::uint8_t> is_serial;    // [block, batch] 1: contacts of colours with one contact each
  std::vector<BatchRange> color_batches;  // in solving order, where there is one block
  std::vector<std::uint32_t> rows;        // [block] rows of dynamic bodies
  std::vector<std::uint32_t> free_rows;   // dynamic bodies in no block
  std::vector<std::uint32_t> set_rows;    // rows for which the blocks were made
  std::vector<std::uint32_t> block_of;    // [body] its block, or no_block; valid while no contact joins two blocks
  std::uint32_t ticks_unsplit = 0;        // until islands are searched for again
  std::vector<ContactColor> colors;       // [place in `contacts`]
  std::vector<std::uint32_t> uncolored;   // places of contacts for the next pass
  std::vector<ColorPlace> places;         // [pass, colour] of a block
  std::vector<BodyColors> body_colors;    // [body]
  std::vector<std::uint32_t> block_starts;
  std::vector<std::uint32_t> island_parent;  // [body]
};
inline constexpr std::uint32_t no_block = 0xffffffff;

/// Colours the contacts of a group: scratch.caches.coloring. `may_split`: in blocks, if there are contacts enough for
/// some. Requires: prepare_bodies.
void color_contacts(Scratch& scratch, const SolverSet& set, bool may_split);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
