// Counts marks. Names are found by their address first, then by their text.
// SPDX-License-Identifier: MIT
#include "replay/format/mark_tally.h"

#include <cstring>

#include "base/hash.h"
#include "base/limits.h"

namespace ticktrue::replay {

std::uint32_t MarkTally::find(const char* name) {
  constexpr auto none = static_cast<std::uint32_t>(name_count_max);
  if (name == nullptr) return none;
  MarkSlot& slot = slots_[slot_of(name)];
  // The text at an address can change.
  if (slot.name == name && (slot.is_constant || std::strcmp(name, entries_[slot.entry].name.c_str()) == 0))
    return slot.entry;
  const std::size_t size = ::strnlen(name, limits::name_size_max + 1);
  if (size == 0 || size > limits::name_size_max) return none;
  const std::string text(name, size);
  auto found = numbers_.find(text);
  if (found == numbers_.end()) {
    if (entries_.size() == name_count_max) return none;
    found = numbers_.emplace(text, static_cast<std::uint32_t>(entries_.size())).first;
    Entry& entry = entries_.emplace_back();
    entry.name = text;
    entry.key = hash64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  slot = {name, found->second, slot.name != name && is_constant_(name)};
  return found->second;
}

std::optional<TickMarks> MarkTally::take() {
  std::optional<TickMarks> marks;
  if (!active_.empty() || is_left_out_) marks.emplace();
  if (!is_left_out_ && marks) {
    marks->trail = trail_;
    marks->names.reserve(active_.size());
  }
  for (const std::uint32_t index : active_) {
    Entry& entry = entries_[index];
    if (!is_left_out_)
      marks->names.push_back({entry.name, entry.count, static_cast<std::uint32_t>(mix_mark(entry.hash, entry.count))});
    entry.count = 0;
  }
  active_.clear();
  trail_ = mark_trail_begin;
  is_left_out_ = false;
  return marks;
}

}  // namespace ticktrue::replay
