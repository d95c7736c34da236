// A few bytes that unpack to half a gigabyte are refused within the size that the part states.
// SPDX-License-Identifier: MIT
#include <chrono>

#include "replay/format/chunk.h"
#include "replay/format/payload.h"
#include "tests/support/catch.h"

using namespace ticktrue;
using namespace ticktrue::replay;

namespace {

constexpr std::uint32_t block_size = 128u << 10;  // the largest of zstd

/// A zstd frame (RFC 8878) of `block_count` blocks, each one byte repeated `block_size` times: 4 bytes a block.
Bytes frame_of_zeros(std::uint32_t block_count) {
  ByteWriter out;
  out.u32(0xfd2fb528);  // magic
  out.u8(0);            // no content size, no checksum, no dictionary
  out.u8(0x58);         // window of 2 MiB
  for (std::uint32_t i = 0; i < block_count; ++i) {
    const std::uint32_t is_last = i + 1 == block_count ? 1 : 0;
    const std::uint32_t header = is_last | 1u << 1 | block_size << 3;  // type 1: repeated byte
    out.u8(static_cast<std::uint8_t>(header));
    out.u8(static_cast<std::uint8_t>(header >> 8));
    out.u8(static_cast<std::uint8_t>(header >> 16));
    out.u8(0);
  }
  return out.take();
}

}  // namespace

TEST_CASE("a compressed part that unpacks to more than it states is refused", "[replay][bomb][corruption]") {
  SKIP_UNLESS(has_codec(Codec::zstd), "a build without zstd");
  ImagePart part;
  part.image_size = part.size = image_part_size;
  part.codec = Codec::zstd;
  const Bytes honest = frame_of_zeros(static_cast<std::uint32_t>(image_part_size / block_size));
  part.stored = honest;
  Bytes out{1, 2, 3};
  REQUIRE(unpack_image_part(part, out));
  CHECK(out.size() == 3 + image_part_size);

  const Bytes bomb = frame_of_zeros(4096);
  CHECK(bomb.size() < 20'000);  // for 512 MiB
  part.stored = bomb;
  out.resize(3);
  out.shrink_to_fit();
  const auto start = std::chrono::steady_clock::now();
  const Status status = unpack_image_part(part, out);
  REQUIRE_FALSE(status);
  CHECK(status.error().code == ErrorCode::corrupt);
  CHECK(out == Bytes{1, 2, 3});
  CHECK(out.capacity() < 4 * image_part_size);
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(5));
}
