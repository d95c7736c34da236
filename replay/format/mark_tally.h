// Counts the marks of the running tick, in a few nanoseconds each.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "replay/format/marks.h"

namespace ticktrue::replay {

/// Counts the marks of the running tick. add() is for programs that call it thousands of times per tick.
class MarkTally {
 public:
  static constexpr std::size_t name_count_max = 4'096;  // in a session

  /// `is_constant`: whether the text at an address never changes, as with a string literal.
  explicit MarkTally(bool (*is_constant)(const char* name)) : is_constant_(is_constant) {}

  /// Counts a mark, if its name is constant and was marked before in this tick. False: another name; nothing was
  /// counted.
  bool add_again(const char* name, std::uint64_t value) {
    const MarkSlot& slot = slots_[slot_of(name)];
    if (slot.name != name || !slot.is_constant) return false;
    Entry& of_name = entries_[slot.entry];
    if (of_name.count == 0) return false;
    count(of_name, value);
    return true;
  }

  /// Index of the name. name_count_max: the name is null, empty or too long, or there are too many names.
  std::uint32_t find(const char* name);
  /// Requires: find() returned `entry`, and `entry` is below name_count_max.
  void add(std::uint32_t entry, std::uint64_t value) {
    Entry& of_name = entries_[entry];
    if (of_name.count == 0) {
      of_name.hash = of_name.key;
      active_.push_back(entry);
    }
    count(of_name, value);
  }
  /// Records a mark whose name has no index. The marks of this tick can then not be compared.
  void leave_out() { is_left_out_ = true; }

  const std::string& name(std::uint32_t entry) const { return entries_[entry].name; }
  /// Returns the marks since the last call, in the order of their first marks; nothing: no mark.
  std::optional<TickMarks> take();

 private:
  struct Entry {
    std::string name;
    std::uint64_t key = 0;   // hash of the name
    std::uint64_t hash = 0;  // of the values in this tick
    std::uint64_t count = 0;
  };
  struct MarkSlot {
    const char* name = nullptr;
    std::uint32_t entry = 0;
    bool is_constant = false;  // the text at this address never changes and need not be compared
  };
  static constexpr std::size_t slot_count = 64;

  static std::size_t slot_of(const char* name) {
    const auto address = reinterpret_cast<std::uintptr_t>(name);
    return (address ^ (address >> 6)) % slot_count;
  }
  void count(Entry& of_name, std::uint64_t value) {
    ++of_name.count;
    trail_ = mix_mark(mix_mark(trail_, of_name.key), value);
    of_name.hash = mix_mark(of_name.hash, value);
  }

  bool (*is_constant_)(const char* name);
  std::array<MarkSlot, slot_count> slots_;
  std::vector<Entry> entries_;
  std::unordered_map<std::string, std::uint32_t> numbers_;
  std::vector<std::uint32_t> active_;  // entries with marks in this tick
  std::uint64_t trail_ = mark_trail_begin;
  bool is_left_out_ = false;
};

}  // namespace ticktrue::replay
