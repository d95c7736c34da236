// PNG: rows filtered by what is left or above, then matches of up to 258 bytes and fixed Huffman codes.
// SPDX-License-Identifier: MIT
// Source: Portable Network Graphics, W3C Recommendation, 2003; Deutsch, RFC 1950 (zlib) and RFC 1951 (deflate), 1996.
#include "tool/play/picture/png.h"

#include <array>
#include <cstdlib>
#include <string_view>

namespace ticktrue::play {
namespace {

std::uint32_t crc_of(const Bytes& bytes, std::size_t begin) {
  std::uint32_t crc = 0xffffffffu;
  for (std::size_t i = begin; i < bytes.size(); ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

void put_big_endian(Bytes& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

void put_chunk(Bytes& out, std::string_view type, const Bytes& data) {
  put_big_endian(out, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = out.size();
  for (const char letter : type) out.push_back(static_cast<std::uint8_t>(letter));
  out.insert(out.end(), data.begin(), data.end());
  put_big_endian(out, crc_of(out, begin));
}

/// Bits of a deflate stream, lowest first.
class BitWriter {
 public:
  explicit BitWriter(Bytes& out) : out_(out) {}
  void bits(std::uint32_t value, int count) {
    held_ |= value << held_count_;
    held_count_ += count;
    while (held_count_ >= 8) {
      out_.push_back(static_cast<std::uint8_t>(held_));
      held_ >>= 8;
      held_count_ -= 8;
    }
  }
  /// A Huffman code: its highest bit first.
  void code(std::uint32_t value, int count) {
    for (int bit = count - 1; bit >= 0; --bit) bits((value >> bit) & 1u, 1);
  }
  void finish() {
    if (held_count_ > 0) bits(0, 8 - held_count_);
  }

 private:
  Bytes& out_;
  std::uint32_t held_ = 0;
  int held_count_ = 0;
};

/// The fixed code of RFC 1951, section 3.2.6.
void put_symbol(BitWriter& out, std::uint32_t symbol) {
  if (symbol < 144)
    out.code(0x30 + symbol, 8);
  else if (symbol < 256)
    out.code(0x190 + symbol - 144, 9);
  else if (symbol < 280)
    out.code(symbol - 256, 7);
  else
    out.code(0xc0 + symbol - 280, 8);
}

constexpr std::array<std::uint16_t, 29> length_base{3,  4,  5,  6,  7,  8,  9,  10, 11,  13,  15,  17,  19,  23, 27,
                                                    31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
constexpr std::array<std::uint8_t, 29> length_bits{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                                   2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
constexpr std::array<std::uint16_t, 30> distance_base{1,    2,    3,    4,    5,    7,    9,    13,    17,    25,
                                                      33,   49,   65,   97,   129,  193,  257,  385,   513,   769,
                                                      1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577};
constexpr std::array<std::uint8_t, 30> distance_bits{0, 0, 0, 0, 1, 1, 2, 2,  3,  3,  4,  4,  5,  5,  6,
                                                     6, 7, 7, 8, 8, 9, 9, 10, 10, 11, 11, 12, 12, 13, 13};

template <typename Bases>
std::size_t place_of(const Bases& bases, std::size_t value) {
  std::size_t place = bases.size() - 1;
  while (bases[place] > value) --place;
  return place;
}

void put_match(BitWriter& out, std::size_t length, std::size_t distance) {
  const std::size_t l = place_of(length_base, length);
  put_symbol(out, static_cast<std::uint32_t>(257 + l));
  out.bits(static_cast<std::uint32_t>(length - length_base[l]), length_bits[l]);
  const std::size_t d = place_of(distance_base, distance);
  out.code(static_cast<std::uint32_t>(d), 5);
  out.bits(static_cast<std::uint32_t>(distance - distance_base[d]), distance_bits[d]);
}

/// One block of a zlib stream: at each place the longer of two matches, with the byte before and with the last place
/// that began with the same three bytes.
Bytes compressed(const Bytes& data) {
  constexpr std::size_t length_max = 258, reach = 32768, hash_count = 1 << 15;
  Bytes out{0x78, 0x01};
  BitWriter bits(out);
  bits.bits(1, 1);                                 // the last block
  bits.bits(1, 2);                                 // fixed codes
  std::vector<std::uint32_t> last(hash_count, 0);  // place + 1
  const auto length_at = [&](std::size_t at, std::size_t from) {
    std::size_t length = 0;
    while (length < length_max && at + length < data.size() && data[from + length] == data[at + length]) ++length;
    return length;
  };
  for (std::size_t at = 0; at < data.size();) {
    std::size_t length = 0, distance = 0;
    if (at > 0) {
      length = length_at(at, at - 1);
      distance = 1;
    }
    if (at + 2 < data.size()) {
      const std::uint32_t key = ((data[at] << 10 ^ data[at + 1] << 5 ^ data[at + 2]) * 2654435761u >> 15) % hash_count;
      const std::size_t from = last[key];
      last[key] = static_cast<std::uint32_t>(at + 1);
      if (from > 0 && at - (from - 1) <= reach) {
        const std::size_t found = length_at(at, from - 1);
        if (found > length) {
          length = found;
          distance = at - (from - 1);
        }
      }
    }
    if (length >= 4) {
      put_match(bits, length, distance);
      at += length;
    } else {
      put_symbol(bits, data[at++]);
    }
  }
  put_symbol(bits, 256);
  bits.finish();
  std::uint32_t a = 1, b = 0;  // Adler-32
  for (const std::uint8_t byte : data) {
    a = (a + byte) % 65521;
    b = (b + a) % 65521;
  }
  put_big_endian(out, b << 16 | a);
  return out;
}

}  // namespace

Bytes png_of(const Canvas& canvas) {
  const auto width = static_cast<std::size_t>(canvas.width());
  const auto height = static_cast<std::size_t>(canvas.height());
  const std::size_t scanline_size = 3 * width;
  Bytes above(scanline_size, 0), scanline(scanline_size, 0), data;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::uint32_t pixel = canvas.pixels()[y * width + x];
      for (std::size_t channel = 0; channel < 3; ++channel)
        scanline[3 * x + channel] = static_cast<std::uint8_t>(pixel >> (16 - 8 * channel));
    }
    data.push_back(2);  // the difference from the row above
    for (std::size_t i = 0; i < scanline_size; ++i) data.push_back(static_cast<std::uint8_t>(scanline[i] - above[i]));
    above.swap(scanline);
  }
  Bytes head;
  put_big_endian(head, static_cast<std::uint32_t>(width));
  put_big_endian(head, static_cast<std::uint32_t>(height));
  head.insert(head.end(), {8, 2, 0, 0, 0});  // 8 bits, red green blue
  Bytes file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  put_chunk(file, "IHDR", head);
  put_chunk(file, "IDAT", compressed(data));
  put_chunk(file, "IEND", {});
  return file;
}

}  // namespace ticktrue::play
