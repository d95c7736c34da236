// The colours of contacts.
// SPDX-License-Identifier: MIT
//
// A colour is a set of contacts without a common dynamic body. Each contact, in order, gets the lowest colour that its
// bodies do not have yet. The colour of a contact therefore depends on its island alone, and islands can be coloured
// and solved a few at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel/parallel.h"
#include "engine/contacts/contact_lanes.h"
#include "engine/contacts/island_blocks.h"
#include "engine/model/body_rows.h"
#include "engine/model/caches.h"
#include "engine/model/contact_pairs.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

// One bit for each colour of a body. Contacts between dynamic bodies are solved first and contacts with other bodies
// last. The last contacts have the smallest error, so that nothing sinks into the ground.
inline constexpr std::uint32_t class_color_count = 32;
inline constexpr std::uint32_t pass_color_count = 2 * class_color_count;

/// The colours of a body's contacts so far, one bit each: with dynamic and with other bodies.
struct BodyColors {
  std::uint32_t moving;
  std::uint32_t immovable;
};

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

/// Contacts that share no dynamic body with other blocks: ranges of ContactColors::contacts and ::slots.
struct ContactBlock {
  std::uint32_t first = 0, end = 0;
  std::uint32_t first_slot = 0, slot_end = 0;
};

/// The contacts of a set, as input of the colouring.
struct ContactsOfSet {
  std::span<const ContactPair> pairs;       // of the tick
  std::span<const std::uint32_t> contacts;  // of the set, in `pairs`
  std::span<const BodyMass> masses;         // [body]
  std::uint32_t sink;                       // BodyMass::write of bodies that are not dynamic
  std::uint32_t generation;                 // TickLists::contact_generation

  bool are_all() const { return contacts.size() == pairs.size(); }
  ContactBodies bodies_at(std::size_t i) const;
};

/// The workspace of the colouring.
struct ColoringWork {
  std::vector<ContactColor> colors;      // [place in `contacts`]
  std::vector<std::uint32_t> uncolored;  // places of contacts for the next pass
  std::vector<ColorPlace> places;        // [pass, colour] of a block
  std::vector<BodyColors> body_colors;   // [body]
  std::vector<std::uint32_t> starts;     // [block] in `contacts`
  IslandBlocksWork blocks;
};

template <typename Visit>
void list_fields(ColoringWork& of, const Visit& visit) {
  auto& [colors, uncolored, places, body_colors, starts, blocks] = of;
  visit(colors, uncolored, places, body_colors, starts, blocks);
}

/// The colours and slots of a set's contacts. Key: the dynamic bodies of the contacts, and the division into blocks.
class ContactColors final : public TickCache {
 public:
  ContactColors() : TickCache(CacheKind::contact_colors) {}

  /// Takes the bodies of the contacts into the key. True if the key had these bodies already.
  bool follow_contacts(const ContactsOfSet& contacts, const Parallel& parallel);
  /// Whether the colours are valid for the key's contacts in this division. `division`: IslandBlocks::generation, or
  /// one_block.
  bool valid_for(std::uint32_t division) const { return is_colored_ && division_ == division; }
  /// Colours the contacts unless the colours are valid. `blocks`: null for one block.
  void follow_division(const IslandBlocks* blocks, std::size_t body_count, const Parallel& parallel,
                       ColoringWork& work);
  void invalidate() override;

  static constexpr std::uint32_t one_block = 0;
  bool is_split() const { return division_ != one_block; }
  /// Whether all contacts of the tick are in the set.
  bool are_all() const { return are_all_; }
  std::span<const ContactBodies> bodies() const { return bodies_; }             // [contact of the set]
  std::span<const ContactBlock> blocks() const { return blocks_; }              // one, unless is_split
  std::span<const std::uint32_t> contacts() const { return contacts_; }         // [block] contacts of the set
  std::span<const std::uint32_t> slots() const { return slots_; }               // [block, batch, lane] or no_contact
  const std::uint8_t* is_serial() const { return is_serial_.data(); }           // [block, batch]
  std::span<const BatchRange> color_batches() const { return color_batches_; }  // of one block, in solving order

 private:
  void rebuild(const IslandBlocks* blocks, std::size_t body_count, const Parallel& parallel, ColoringWork& work);
  void color_block(const Parallel& parallel, ContactBlock& block, ColoringWork& work);
  void fill_slots(const Parallel& parallel, ContactBlock& block, std::uint32_t pass_count, ColoringWork& work);
  template <typename PlaceAt>
  std::size_t color_pass(std::size_t count, PlaceAt place_at, std::uint32_t pass, ColoringWork& work) const;

  std::vector<ContactBodies> bodies_;   // key: of the contacts
  std::uint32_t generation_ = 0;        // key: TickLists::contact_generation, if are_all_
  bool are_all_ = false;                // key
  std::uint32_t division_ = one_block;  // key
  bool is_colored_ = false;
  std::vector<ContactBlock> blocks_;
  std::vector<std::uint32_t> contacts_;
  std::vector<std::uint32_t> slots_;
  std::vector<std::uint8_t> is_serial_;  // 1: contacts of colours with one contact each
  std::vector<BatchRange> color_batches_;
};

/// Colours the contacts of a set. `may_split`: in blocks, if there are enough contacts. `rows`: the dynamic bodies of
/// the set.
void color_contacts(const ContactsOfSet& contacts, std::span<const std::uint32_t> rows, bool may_split,
                    const Parallel& parallel, ContactColors& colors, IslandBlocks& blocks, ColoringWork& work);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
