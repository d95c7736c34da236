// Marks and notes of ticks: what a program counts during a tick, and its records in a ticks chunk.
// SPDX-License-Identifier: MIT
//
// Format: docs/trace_format.md, section 20. These records are outside the chain.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
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
  std::uint32_t hash = 0;  // of the values in their order

  bool operator==(const NameMarks&) const = default;
};

/// The marks of one tick. A tick without marks has no record.
struct TickMarks {
  std::uint64_t trail = 0;       // of all marks in their order
  std::vector<NameMarks> names;  // each name once

  /// Whether the marks did not fit into the trace. Then they are not compared.
  bool is_left_out() const { return trail == 0 && names.empty(); }
  bool operator==(const TickMarks&) const = default;
};

/// One mark.
struct Mark {
  std::uint32_t name = 0;  // index in MarkList::names
  std::uint64_t value = 0;

  bool operator==(const Mark&) const = default;
};

/// All marks of one tick, in order.
struct MarkList {
  std::vector<std::string> names;
  std::vector<Mark> marks;
  bool is_cut = false;  // further marks were dropped

  bool operator==(const MarkList&) const = default;
};

struct Note {
  std::string topic;
  std::string text;

  bool operator==(const Note&) const = default;
};

// ---- Records ----

/// Encodes the body of a marks record. `ids`: ids of the names in their chunk, in the order of `marks.names`.
void encode_marks(const TickMarks& marks, const std::vector<std::uint32_t>& ids, ByteWriter& out);
/// Requires: a checked record. `chunk_names`: the names in the chunk up to this record.
TickMarks decode_marks(ByteView body, const std::vector<std::string>& chunk_names);

/// Encodes the body of a mark list record with as many marks as fit. `ids`: ids of its names in their chunk.
void encode_mark_list(const MarkList& list, const std::vector<std::uint32_t>& ids, ByteWriter& out);
/// Appends the marks of a record. Requires: as for decode_marks.
void decode_mark_list(ByteView body, const std::vector<std::string>& chunk_names, MarkList& list);

/// Encodes the body of a note record. Requires: topic and text within their limits.
void encode_note(const Note& note, ByteWriter& out);
/// Requires: a checked record.
Note decode_note(ByteView body);

}  // namespace ticktrue::replay
