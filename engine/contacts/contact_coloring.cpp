// Colouring of contacts.
// SPDX-License-Identifier: MIT
#include "engine/contacts/contact_coloring.h"

#include <atomic>

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The least number of contacts per chunk for which a second thread pays.
constexpr std::size_t contact_bodies_per_chunk_least = 256;
constexpr std::size_t slots_per_chunk_least = 1024;

}  // namespace

ContactBodies ContactsOfSet::bodies_at(std::size_t i) const {
  const ContactPair& pair = pairs[contacts[i]];
  const auto dynamic_row = [&](std::uint32_t row) { return masses[row].write == sink ? no_body : row; };
  return {dynamic_row(pair.body_a), dynamic_row(pair.body_b)};
}

bool ContactColors::follow_contacts(const ContactsOfSet& contacts, const Parallel& parallel) {
  const bool are_all = contacts.are_all();
  if (are_all && are_all_ && generation_ == contacts.generation) return true;
  are_all_ = are_all;
  generation_ = contacts.generation;
  const std::size_t count = contacts.contacts.size();
  std::atomic<bool> changed{bodies_.size() != count};
  bodies_.resize(count);
  parallel.for_chunks(count, parallel.chunk_size(count, contact_bodies_per_chunk_least), [&](const Chunk& chunk) {
    bool same = true;
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const ContactBodies bodies = contacts.bodies_at(i);
      same &= bodies == bodies_[i];
      bodies_[i] = bodies;
    }
    if (!same) changed.store(true, std::memory_order_relaxed);
  });
  const bool is_same = !changed.load(std::memory_order_relaxed);
  is_colored_ = is_colored_ && is_same;
  return is_same;
}

void ContactColors::invalidate() {
  are_all_ = false;
  bodies_.clear();
  is_colored_ = false;
}

void ContactColors::follow_division(const IslandBlocks* blocks, std::size_t body_count, const Parallel& parallel,
                                    ColoringWork& work) {
  const bool is_hit = valid_for(blocks != nullptr ? blocks->generation() : one_block);
  count_use(is_hit);
  if (!is_hit) rebuild(blocks, body_count, parallel, work);
}

void ContactColors::rebuild(const IslandBlocks* blocks, std::size_t body_count, const Parallel& parallel,
                            ColoringWork& work) {
  const auto count = static_cast<std::uint32_t>(bodies_.size());
  if (blocks == nullptr) {
    blocks_.assign(1, {0, count, 0, 0});
    contacts_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) contacts_[i] = i;
    division_ = one_block;
  } else {
    blocks_.resize(blocks->count());
    sort_by_block(
        blocks->count(), count, [&](std::size_t i) { return blocks->block_of(dynamic_body_of(bodies_[i])); },
        work.starts, work.blocks.counts, contacts_);
    for (std::size_t i = 0; i < blocks_.size(); ++i) blocks_[i] = {work.starts[i], work.starts[i + 1], 0, 0};
    division_ = blocks->generation();
  }
  work.colors.resize(count);
  work.body_colors.assign(body_count, {0, 0});
  slots_.clear();
  is_serial_.clear();
  color_batches_.clear();
  for (ContactBlock& block : blocks_) color_block(parallel, block, work);
  is_colored_ = true;
}

/// Colours `count` contacts, at place_at(0), .. in the block. A contact whose body has no free colour goes to
/// `uncolored`, for the next pass. Returns the number of uncoloured contacts.
template <typename PlaceAt>
std::size_t ContactColors::color_pass(std::size_t count, PlaceAt place_at, std::uint32_t pass,
                                      ColoringWork& work) const {
  std::size_t uncolored_count = 0;
  const std::uint32_t first_color = pass * pass_color_count;
  work.places.resize(first_color + pass_color_count, {0, 0});
  ColorPlace* places = work.places.data() + first_color;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t place = place_at(i);
    const ContactBodies bodies = bodies_[contacts_[place]];
    const bool both_move = moves_both(bodies);
    std::uint32_t used;
    if (both_move) {
      BodyColors& a = work.body_colors[bodies.a];
      BodyColors& b = work.body_colors[bodies.b];
      used = a.moving | b.moving;
      const std::uint32_t bit = ~used & (used + 1);  // the lowest free bit, or none
      a.moving |= bit;
      b.moving |= bit;
    } else {
      BodyColors& body = work.body_colors[dynamic_body_of(bodies)];
      used = body.immovable;
      body.immovable |= ~used & (used + 1);
    }
    if (used == 0xffffffffu) {
      work.uncolored[uncolored_count++] = place;
      continue;
    }
    const std::uint32_t color = static_cast<std::uint32_t>(__builtin_ctz(~used)) + (both_move ? 0u : class_color_count);
    work.colors[place] = {first_color + color, places[color].count++};
  }
  return uncolored_count;
}

/// Puts the contacts of a block into slots, colour by colour, contacts between dynamic bodies first. Each colour begins
/// a new batch. Colours with one contact share batches that are solved serially; a body with very many contacts makes
/// such colours.
void ContactColors::fill_slots(const Parallel& parallel, ContactBlock& block, std::uint32_t pass_count,
                               ColoringWork& work) {
  block.first_slot = static_cast<std::uint32_t>(slots_.size());
  std::uint32_t next = block.first_slot;
  for (const std::uint32_t first : {0u, class_color_count}) {
    std::uint32_t serial_count = 0;  // contacts of the last batch, if it is serial
    for (std::uint32_t pass = 0; pass < pass_count; ++pass)
      for (std::uint32_t color = 0; color < class_color_count; ++color) {
        ColorPlace& place = work.places[pass * pass_color_count + first + color];
        if (place.count == 0) continue;
        if (place.count == 1 && serial_count % contact_lane_count != 0) {
          place.first_slot = next - contact_lane_count + serial_count++;
          continue;
        }
        serial_count = place.count == 1 ? 1 : 0;
        const std::uint32_t batch_count = (place.count + contact_lane_count - 1) / contact_lane_count;
        place.first_slot = next;
        next += batch_count * contact_lane_count;
        is_serial_.insert(is_serial_.end(), batch_count, static_cast<std::uint8_t>(serial_count));
        if (!is_split()) color_batches_.push_back({place.first_slot / contact_lane_count, next / contact_lane_count});
      }
  }
  block.slot_end = next;
  slots_.resize(next, no_contact);
  const std::size_t count = block.end - block.first;
  parallel.for_chunks(count, parallel.chunk_size(count, slots_per_chunk_least), [&](const Chunk& chunk) {
    for (std::size_t i = block.first + chunk.begin; i < block.first + chunk.end; ++i)
      slots_[work.places[work.colors[i].color].first_slot + work.colors[i].rank] = contacts_[i];
  });
}

void ContactColors::color_block(const Parallel& parallel, ContactBlock& block, ColoringWork& work) {
  work.places.clear();
  work.uncolored.resize(work.colors.size());
  std::uint32_t pass_count = 1;
  std::size_t uncolored_count = color_pass(
      block.end - block.first, [&](std::size_t i) { return block.first + static_cast<std::uint32_t>(i); }, 0, work);
  while (uncolored_count > 0) {
    for (std::size_t i = 0; i < uncolored_count; ++i) {
      const ContactBodies bodies = bodies_[contacts_[work.uncolored[i]]];
      for (const std::uint32_t row : {bodies.a, bodies.b})
        if (row != no_body) work.body_colors[row] = {0, 0};
    }
    uncolored_count = color_pass(
        uncolored_count, [&](std::size_t i) { return work.uncolored[i]; }, pass_count++, work);
  }
  fill_slots(parallel, block, pass_count, work);
}

void color_contacts(const ContactsOfSet& contacts, std::span<const std::uint32_t> rows, bool may_split,
                    const Parallel& parallel, ContactColors& colors, IslandBlocks& blocks, ColoringWork& work) {
  const std::size_t body_count = contacts.masses.size();
  const bool same_contacts = colors.follow_contacts(contacts, parallel);
  const IslandBlocksKey key{colors.bodies(), rows, body_count, same_contacts && colors.valid_for(blocks.generation())};
  const bool is_split = may_split && blocks.follow(key, parallel.chunk_size_forced, work.blocks);
  colors.follow_division(is_split ? &blocks : nullptr, body_count, parallel, work);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
