// Searches the notes. Each size is compared with the remaining bytes.
// SPDX-License-Identifier: MIT
#include "verifier/report/build_id_note.h"

#include <algorithm>
#include <cstdint>

namespace ticktrue::verifier {
namespace {

constexpr std::size_t header_size = 12;  // sizes of name and content, type
constexpr std::size_t build_id_size_max = 64;
constexpr std::uint32_t build_id_type = 3;  // NT_GNU_BUILD_ID
constexpr std::string_view owner{"GNU\0", 4};

std::uint32_t number_at(ByteView bytes, ByteOrder order) {
  const std::uint32_t little = ByteReader(bytes).u32();
  return order == ByteOrder::little ? little
                                    : little >> 24 | (little >> 8 & 0xff00) | (little << 8 & 0xff0000) | little << 24;
}

std::string digits_of(ByteView bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text;
}

}  // namespace

std::string build_id_among(ByteView notes, std::size_t alignment, ByteOrder order) {
  const auto padded = [alignment](std::uint64_t size) { return (size + alignment - 1) / alignment * alignment; };
  while (notes.size() >= header_size) {
    const std::uint32_t name_size = number_at(notes, order);
    const std::uint32_t content_size = number_at(notes.subspan(4), order);
    const std::uint32_t type = number_at(notes.subspan(8), order);
    notes = notes.subspan(header_size);
    const std::uint64_t content = padded(name_size);
    const std::uint64_t size = content + content_size;
    if (size > notes.size()) return "";
    if (type == build_id_type && name_size == owner.size() && content_size <= build_id_size_max &&
        std::equal(owner.begin(), owner.end(), notes.begin()))
      return digits_of(notes.subspan(static_cast<std::size_t>(content), content_size));
    notes = notes.subspan(static_cast<std::size_t>(std::min<std::uint64_t>(padded(size), notes.size())));
  }
  return "";
}

}  // namespace ticktrue::verifier
