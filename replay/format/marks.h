// Marks and notes of ticks: what a program counts while a tick runs, as the records of a ticks chunk hold it.
// SPDX-License-Identifier: MIT
//
// Format: docs/trace_format.md, section 20. Nothing of it is in the chain.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/bytes.h"

namespace ticktrue::replay {

inline constexpr std::uint64_t mark_trail_begin = 0x9e3779b9;
/// One step of a chain of marks: `mix` of section 12 of docs/trace_format.md.
inline std::uint64_t mix_mark(std::uint64_t hash, std::uint64_t word) {
  const std::uint64_t x = (hash ^ word) * 0xd6e8feb86659fd93;
  return x ^ (x >> 32);
}

/// The marks of one name in one tick.
struct NameMarks {
  std::string name;
  std::uint64_t count = 0;
  std::uint32_t hash = 0;  // of its values in their order

  bool operator==(const NameMarks&) const = default;
};

/// The marks of one tick. A tick without marks has no record.
struct TickMarks {
  std::uint64_t trail = 0;       // of all marks in their order
  std::vector<NameMarks> names;  // each once

  /// They did not fit into the trace: they are compared with nothing.
  bool is_left_out() const { return trail == 0 && names.empty(); }
  bool operator==(const TickMarks&) const = default;
};

/// One mark.
struct Mark {
  std::uint32_t name = 0;  // index in MarkList::names
  std::uint64_t value = 0;

  bool operator==(const Mark&) const = default;
};

/// Each mark of one tick, in order.
struct MarkList {
  std::vector<std::string> names;
  std::vector<Mark> marks;
  bool is_cut = false;  // there were more

  bool operator==(const MarkList&) const = default;
};

struct Note {
  std::string topic;
  std::string text;

  bool operator==(const Note&) const = default;
};

/// Counts the marks of the tick that runs. add() is for programs that call it thousands of times a tick.
class MarkTally {
 public:
  static constexpr std::size_t name_count_max = 4'096;  // of a session

  /// Index of the name, or name_count_max where there is no room or the name is empty or too long.
  std::uint32_t find(const char* name) {
    const Slot& slot = slots_[slot_of(name)];
    // The text at an address may have changed: comparing it costs less than a wrong name.
    if (slot.name == name && std::string_view(name) == entries_[slot.entry].name) return slot.entry;
    return find_slowly(name);
  }
  /// Requires: `entry` is of find() and below name_count_max.
  void add(std::uint32_t entry, std::uint64_t value) {
    Entry& of_name = entries_[entry];
    if (of_name.count++ == 0) {
      of_name.hash = of_name.key;
      active_.push_back(entry);
    }
    trail_ = mix_mark(mix_mark(trail_, of_name.key), value);
    of_name.hash = mix_mark(of_name.hash, value);
  }
  /// A mark has no name here: those of this tick cannot be compared.
  void leave_out() { is_left_out_ = true; }

  const std::string& name(std::uint32_t entry) const { return entries_[entry].name; }
  /// The marks since the last call, in the order of their first marks; nothing without a mark.
  std::optional<TickMarks> take();

 private:
  struct Entry {
    std::string name;
    std::uint64_t key = 0;   // hash of the name
    std::uint64_t hash = 0;  // of this tick
    std::uint64_t count = 0;
  };
  struct Slot {
    const char* name = nullptr;
    std::uint32_t entry = 0;
  };
  static constexpr std::size_t slot_count = 64;

  static std::size_t slot_of(const char* name) {
    const auto address = reinterpret_cast<std::uintptr_t>(name);
    return (address ^ (address >> 6)) % slot_count;
  }
  std::uint32_t find_slowly(const char* name);

  std::array<Slot, slot_count> slots_;
  std::vector<Entry> entries_;
  std::unordered_map<std::string, std::uint32_t> numbers_;
  std::vector<std::uint32_t> active_;  // entries with marks in this tick
  std::uint64_t trail_ = mark_trail_begin;
  bool is_left_out_ = false;
};

// ---- Records ----

/// Body of a marks record. `ids`: of the names in their chunk, in the order of `marks.names`.
void encode_marks(const TickMarks& marks, const std::vector<std::uint32_t>& ids, ByteWriter& out);
/// Requires: the record was checked. `chunk_names`: of the chunk so far.
TickMarks decode_marks(ByteView body, const std::vector<std::string>& chunk_names);

/// Body of a mark list record: as many of the marks as fit. `ids`: of its names in their chunk.
void encode_mark_list(const MarkList& list, const std::vector<std::uint32_t>& ids, ByteWriter& out);
/// Appends the marks of a record. Requires: as for decode_marks.
void decode_mark_list(ByteView body, const std::vector<std::string>& chunk_names, MarkList& list);

/// Body of a note record. Requires: topic and text within their limits.
void encode_note(const Note& note, ByteWriter& out);
/// Requires: the record was checked.
Note decode_note(ByteView body);

}  // namespace ticktrue::replay
