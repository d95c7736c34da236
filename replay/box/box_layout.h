// The bytes of a black box: header, head, slots. Shared by writer and recovery.
// SPDX-License-Identifier: MIT
//
// Format: docs/decisions/0023-trace-format-3/design.md, section 12. The head, followed by the committed bytes of a
// slot, is a truncated trace.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/bytes.h"
#include "base/result.h"

namespace ticktrue::replay {

inline constexpr std::array<std::uint8_t, 8> box_magic{0x89, 'T', 'T', 'B', 0x0d, 0x0a, 0x1a, 0x0a};
inline constexpr std::uint16_t box_version = 1;
inline constexpr std::uint64_t box_page_size = 4096;
inline constexpr std::size_t box_header_size = 44;       // up to `state`; the rest of its page is 0
inline constexpr std::size_t box_state_offset = 40;      // u32: 1 after the session closed the box, else 0
inline constexpr std::size_t box_slot_header_size = 64;  // generation, first tick, check, committed
inline constexpr std::size_t box_committed_offset = 24;
inline constexpr std::uint16_t box_slot_count_min = 2;
inline constexpr std::uint16_t box_slot_count_max = 64;
inline constexpr std::uint64_t box_slot_size_min = 64u << 10;
inline constexpr std::uint64_t box_slot_size_max = (std::uint64_t{1} << 30) - box_page_size;
inline constexpr std::uint32_t box_head_size_max = 64u << 20;

struct BoxLayout {
  std::uint16_t slot_count = 0;
  std::uint32_t head_size = 0;
  std::uint64_t slot_size = 0;  // including its header

  std::uint64_t slot_offset(std::size_t slot) const {
    return box_page_size + (head_size + box_page_size - 1) / box_page_size * box_page_size + slot * slot_size;
  }
  std::uint64_t file_size() const { return slot_offset(slot_count); }
};

/// Makes 8 slots, or fewer if each would be too small. `head_size` stays 0. Errors: usage (too small or too large).
Result<BoxLayout> divide_box(std::uint64_t size);

void encode_box_header(const BoxLayout& layout, ByteWriter& out);
/// Requires: box_header_size bytes that begin with the magic. Errors: corrupt; incompatible (a newer version).
Result<BoxLayout> decode_box_header(ByteView bytes, const std::string& name);
bool is_box(ByteView first_bytes);

struct BoxSlotHeader {
  std::uint64_t generation = 0;  // 0: empty
  std::uint64_t first_tick = 0;
  std::uint32_t committed = 0;
  bool is_right = false;  // whether its check is right
};
/// `seed`: the hash of the head.
std::uint64_t box_slot_check(std::uint64_t generation, std::uint64_t first_tick, std::uint64_t seed);
BoxSlotHeader decode_box_slot_header(ByteView bytes, std::uint64_t seed);

}  // namespace ticktrue::replay
