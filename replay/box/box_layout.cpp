// Divides a black box into head and slots, and decodes its header. Each size is checked before anything is read with
// it.
// SPDX-License-Identifier: MIT
#include "replay/box/box_layout.h"

#include <algorithm>

#include "base/hash.h"

namespace ticktrue::replay {
namespace {

constexpr std::uint16_t slot_count_default = 8;
constexpr std::size_t checked_size = 40 - 8;  // bytes of the header before its check

}  // namespace

Result<BoxLayout> divide_box(std::uint64_t size) {
  const auto wanted = static_cast<std::uint16_t>(
      std::clamp<std::uint64_t>(size / box_slot_size_min, box_slot_count_min, slot_count_default));
  BoxLayout layout;
  layout.slot_count = wanted;
  layout.slot_size = size / wanted / box_page_size * box_page_size;
  if (layout.slot_size >= box_slot_size_min && layout.slot_size <= box_slot_size_max) return layout;
  return Error{ErrorCode::usage,
               "black box: size: found " + std::to_string(size) + " bytes, expected " +
                   std::to_string(box_slot_count_min * box_slot_size_min) + ".." +
                   std::to_string(slot_count_default * box_slot_size_max),
               ""};
}

void encode_box_header(const BoxLayout& layout, ByteWriter& out) {
  for (const std::uint8_t byte : box_magic) out.u8(byte);
  out.u16(box_version);
  out.u16(layout.slot_count);
  out.u32(layout.head_size);
  out.u64(layout.slot_size);
  out.u64(layout.file_size());
  out.u64(hash64(out.view()));
  out.u32(0);
}

bool is_box(ByteView first_bytes) {
  return first_bytes.size() >= box_magic.size() && std::equal(box_magic.begin(), box_magic.end(), first_bytes.begin());
}

Result<BoxLayout> decode_box_header(ByteView bytes, const std::string& name) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::corrupt, name + ": black box: header: " + what, "nothing of it can be read"};
  };
  ByteReader in(bytes.subspan(box_magic.size()));
  const std::uint16_t version = in.u16();
  BoxLayout layout;
  layout.slot_count = in.u16();
  layout.head_size = in.u32();
  layout.slot_size = in.u64();
  const std::uint64_t file_size = in.u64();
  if (in.u64() != hash64(bytes.first(checked_size))) return refuse("its check does not match");
  if (version != box_version)
    return Error{
        ErrorCode::incompatible,
        name + ": black box: version: found " + std::to_string(version) + ", expected " + std::to_string(box_version),
        "use a newer ticktrue"};
  if (layout.slot_count < box_slot_count_min || layout.slot_count > box_slot_count_max)
    return refuse("slots: found " + std::to_string(layout.slot_count));
  if (layout.slot_size < box_slot_size_min || layout.slot_size > box_slot_size_max ||
      layout.slot_size % box_page_size != 0)
    return refuse("size of a slot: found " + std::to_string(layout.slot_size));
  if (layout.head_size > box_head_size_max || file_size != layout.file_size())
    return refuse("sizes that do not fit together");
  return layout;
}

std::uint64_t box_slot_check(std::uint64_t generation, std::uint64_t first_tick, std::uint64_t seed) {
  ByteWriter bytes;
  bytes.u64(generation);
  bytes.u64(first_tick);
  return hash64(bytes.view(), seed);
}

BoxSlotHeader decode_box_slot_header(ByteView bytes, std::uint64_t seed) {
  ByteReader in(bytes);
  BoxSlotHeader header;
  header.generation = in.u64();
  header.first_tick = in.u64();
  const std::uint64_t check = in.u64();
  header.committed = in.u32();
  header.is_right = in.ok() && check == box_slot_check(header.generation, header.first_tick, seed);
  return header;
}

}  // namespace ticktrue::replay
