// Little-endian encoding: the written bytes are as specified, and no reader runs past its end.
// SPDX-License-Identifier: MIT
#include "base/bytes.h"

#include <limits>

#include "tests/support/catch.h"

namespace ticktrue {
namespace {

Bytes varint_bytes(std::uint64_t value) {
  ByteWriter out;
  out.varint(value);
  return out.take();
}

TEST_CASE("values are written little-endian", "[base][bytes][golden]") {
  ByteWriter out;
  out.u8(0x01);
  out.u16(0x0203);
  out.u32(0x04050607);
  out.u64(0x08090a0b0c0d0e0fu);
  out.i32(-2);
  out.f64(1.0);
  out.text("ab");
  const Bytes expected{0x01, 0x03, 0x02, 0x07, 0x06, 0x05, 0x04, 0x0f, 0x0e, 0x0d, 0x0c,
                       0x0b, 0x0a, 0x09, 0x08, 0xfe, 0xff, 0xff, 0xff, 0x00, 0x00, 0x00,
                       0x00, 0x00, 0x00, 0xf0, 0x3f, 0x02, 0x00, 0x00, 0x00, 'a',  'b'};
  CHECK(out.take() == expected);
}

TEST_CASE("what is written is read back, bit for bit", "[base][bytes][equivalence]") {
  ByteWriter out;
  out.u8(255);
  out.u16(65535);
  out.u32(0xdeadbeef);
  out.u64(std::numeric_limits<std::uint64_t>::max());
  out.i32(std::numeric_limits<std::int32_t>::min());
  out.f64(-0.0);
  out.f64(double_of_bits(0x7ff8000000000001u));
  out.text("crate_7");
  out.varint(300);
  const Bytes bytes = out.take();
  ByteReader in(bytes);
  CHECK(in.u8() == 255);
  CHECK(in.u16() == 65535);
  CHECK(in.u32() == 0xdeadbeef);
  CHECK(in.u64() == std::numeric_limits<std::uint64_t>::max());
  CHECK(in.i32() == std::numeric_limits<std::int32_t>::min());
  CHECK(bits_of(in.f64()) == 0x8000000000000000u);
  CHECK(bits_of(in.f64()) == 0x7ff8000000000001u);
  CHECK(in.text(7) == "crate_7");
  CHECK(in.varint() == 300);
  CHECK(in.ok());
  CHECK(in.at_end());
  CHECK(in.offset() == bytes.size());
}

TEST_CASE("a reader cut anywhere fails, and keeps failing", "[base][bytes][corruption]") {
  ByteWriter out;
  out.u16(7);
  out.u64(8);
  out.text("abc");
  out.varint(1u << 20);
  const Bytes bytes = out.take();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    CAPTURE(size);
    ByteReader in(ByteView(bytes).first(size));
    in.u16();
    in.u64();
    in.text(100);
    in.varint();
    CHECK_FALSE(in.ok());
    CHECK(in.remaining() == 0);
    CHECK(in.u8() == 0);
    CHECK(in.bytes(0).empty());
    CHECK_FALSE(in.ok());
  }
}

TEST_CASE("a failed group reads as zeros", "[base][bytes][corruption]") {
  const Bytes bytes{0xff, 0xff, 0xff};
  ByteReader in(bytes);
  CHECK(in.u32() == 0);
  CHECK(in.u8() == 0);  // 0, although the next byte is 0xff: the position is unknown
  CHECK_FALSE(in.ok());
}

TEST_CASE("a text longer than allowed fails before it is allocated", "[base][bytes][corruption]") {
  const Bytes huge{0xff, 0xff, 0xff, 0xff, 'a'};
  ByteReader in(huge);
  CHECK(in.text(std::numeric_limits<std::size_t>::max()).empty());
  CHECK_FALSE(in.ok());

  ByteWriter out;
  out.text("abcd");
  const Bytes bytes = out.take();
  ByteReader allowed(bytes);
  CHECK(allowed.text(4) == "abcd");
  CHECK(allowed.ok());
  ByteReader refused(bytes);
  refused.text(3);
  CHECK_FALSE(refused.ok());
}

TEST_CASE("varints have one form only", "[base][bytes][corruption]") {
  CHECK(varint_bytes(0) == Bytes{0x00});
  CHECK(varint_bytes(127) == Bytes{0x7f});
  CHECK(varint_bytes(128) == Bytes{0x80, 0x01});
  CHECK(varint_bytes(300) == Bytes{0xac, 0x02});
  CHECK(varint_bytes(std::numeric_limits<std::uint64_t>::max()) ==
        Bytes{0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01});
  for (int bit = 0; bit < 64; ++bit)
    for (const std::uint64_t value : {(1ull << bit) - 1, 1ull << bit, (1ull << bit) + 1}) {
      const Bytes bytes = varint_bytes(value);
      ByteReader in(bytes);
      CHECK(in.varint() == value);
      CHECK(in.at_end());
      CHECK(in.ok());
    }

  const Bytes bad[] = {
      {0x80},        // ends early
      {0x80, 0x00},  // padded
      {0xff, 0x80, 0x00},
      {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x02},        // 65 bits
      {0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x01},  // 11 bytes
  };
  for (const Bytes& bytes : bad) {
    CAPTURE(bytes.size(), int(bytes.back()));
    ByteReader in(bytes);
    in.varint();
    CHECK_FALSE(in.ok());
  }
}

TEST_CASE("scalars are reversed one by one", "[base][bytes][analytic]") {
  Bytes bytes{1, 2, 3, 4, 5, 6, 7, 8};
  reverse_scalar_bytes(bytes.data(), 1, 8);
  CHECK(bytes == Bytes{1, 2, 3, 4, 5, 6, 7, 8});
  reverse_scalar_bytes(bytes.data(), 2, 4);
  CHECK(bytes == Bytes{2, 1, 4, 3, 6, 5, 8, 7});
  reverse_scalar_bytes(bytes.data(), 4, 2);
  CHECK(bytes == Bytes{3, 4, 1, 2, 7, 8, 5, 6});
  reverse_scalar_bytes(bytes.data(), 8, 1);
  CHECK(bytes == Bytes{6, 5, 8, 7, 2, 1, 4, 3});
}

// Only quiet NaNs: i386 returns floats in x87 registers, which make a signalling NaN quiet.
TEST_CASE("float bits survive the round trip, NaN payloads included", "[base][bytes][equivalence]") {
  for (const std::uint32_t bits : {0u, 0x80000000u, 1u, 0x7f7fffffu, 0x7f800000u, 0x7fc00001u, 0xffc00001u})
    CHECK(bits_of(float_of_bits(bits)) == bits);
  for (const std::uint64_t bits : {0ull, 0x8000000000000000ull, 1ull, 0x7ff0000000000000ull, 0x7ff8000000000123ull})
    CHECK(bits_of(double_of_bits(bits)) == bits);
}

}  // namespace
}  // namespace ticktrue
