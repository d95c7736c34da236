// The hash equals published values, so that other implementations can check a trace.
// SPDX-License-Identifier: MIT
#include "base/hash.h"

#include <algorithm>

#include "base/hash128.h"
#include "tests/support/catch.h"

namespace ticktrue {
namespace {

ByteView view_of(const char* text, std::size_t size) {
  return {reinterpret_cast<const std::uint8_t*>(text), size};
}

TEST_CASE("the hash of nothing is XXH3-64's", "[base][hash][golden]") {
  CHECK(hash64({}) == 0x2d06800538d394c2u);
}

TEST_CASE("the hash of short, medium and long inputs does not change", "[base][hash][golden]") {
  // XXH3 uses separate code for 1..3, 4..8, 9..16, 17..128, 129..240 and more bytes. One value tests each.
  Bytes bytes;
  for (int i = 0; i < 5000; ++i) bytes.push_back(static_cast<std::uint8_t>(i * 31 + (i >> 8)));
  const struct {
    std::size_t size;
    std::uint64_t seed;
    std::uint64_t expected;
  } cases[] = {
      {1, 0, 0xc44bdff4074eecdbu},    {1, 1, 0x5eaac1f7b17ef730u},    {3, 0, 0x3698b80191e625f9u},
      {3, 1, 0x86ae6c50d7b69671u},    {4, 0, 0x2e4ac2f1c52157fcu},    {4, 1, 0x491b981740bf928au},
      {8, 0, 0x60e1baa91347a1f2u},    {8, 1, 0xda04492cb1abfceeu},    {9, 0, 0x9c88fc32c37b56cbu},
      {9, 1, 0xfca7d7f3ecb9bcedu},    {16, 0, 0xf9fbd0260ba978dfu},   {16, 1, 0xa797812e1ae94fafu},
      {17, 0, 0xc56f339d36cc73d7u},   {17, 1, 0x9dc72b02c021c9f5u},   {128, 0, 0x31ccf8dec850d035u},
      {128, 1, 0x1ced4dbbfa238603u},  {129, 0, 0xc72af4c6ac4dea94u},  {129, 1, 0x5f6fd67147e89935u},
      {240, 0, 0xe315d53d5129eedeu},  {240, 1, 0x7579bca686f0d85au},  {241, 0, 0x18773c512b008a63u},
      {241, 1, 0xd361d7f2160409deu},  {1024, 0, 0x5a1893edffa2577cu}, {1024, 1, 0xf0cab413b996ef88u},
      {5000, 0, 0xc0dd97972a4d2de3u}, {5000, 1, 0x772e79d31d3fa36eu},
  };
  for (const auto& c : cases) {
    CAPTURE(c.size, c.seed);
    CHECK(hex64(hash64(ByteView(bytes).first(c.size), c.seed)) == hex64(c.expected));
  }
}

TEST_CASE("the hash of 128 bits gives what xxh128sum gives, in one piece and in parts", "[base][hash][golden]") {
  Bytes bytes;
  for (int i = 0; i < 5000; ++i) bytes.push_back(static_cast<std::uint8_t>(i * 31 + (i >> 8)));
  const struct {
    std::size_t size;
    std::string expected;
  } cases[] = {
      {0, "99aa06d3014798d86001c324468d497f"},    {1, "a6cd5e9392000f6ac44bdff4074eecdb"},
      {3, "4af3603b5bd30dfe3698b80191e625f9"},    {4, "11527735d62fce43eecdfa5a3b083ba8"},
      {8, "791e22cdc30880ba073a25812fe4f600"},    {9, "22775b5e55c2ace94557529981ebbef0"},
      {16, "8d0b1cd2088b9620843f49fff931d541"},   {17, "340f6f9202ad1131a378e80882221151"},
      {128, "9ac3a2d505dc8bbaffb5b9abed8b314d"},  {129, "4f3f783d604d0184c83022477e6bf25a"},
      {240, "550b8ce07c44bc98c018ce69a32b5a7c"},  {241, "8e7e1f2fe4156df918773c512b008a63"},
      {1024, "ea65234127f4dd7b5a1893edffa2577c"}, {5000, "47aa050a1d2c0b8cc0dd97972a4d2de3"},
  };
  for (const auto& c : cases) {
    CAPTURE(c.size);
    const ByteView whole = ByteView(bytes).first(c.size);
    CHECK(hex128(hash128(whole)) == c.expected);
    Hash128Stream parts;
    for (std::size_t at = 0; at < c.size; at += 7) parts.add(whole.subspan(at, std::min<std::size_t>(7, c.size - at)));
    CHECK(hex128(parts.value()) == c.expected);
  }
}

TEST_CASE("one changed bit, another length and another seed change the hash", "[base][hash][analytic]") {
  Bytes bytes(300, 0x5a);
  const std::uint64_t whole = hash64(bytes);
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    if (hash64(bytes) == whole) FAIL_CHECK("bit " << bit << " does not count");
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
  }
  CHECK(hash64(ByteView(bytes).first(299)) != whole);
  CHECK(hash64(bytes, 1) != whole);
}

TEST_CASE("hashes print as lower-case hexadecimal of full width", "[base][hash][analytic]") {
  CHECK(hex64(0) == "0000000000000000");
  CHECK(hex64(0x0123456789abcdefu) == "0123456789abcdef");
  CHECK(hex32(0xbeef) == "0000beef");
  CHECK(hex64(hash64(view_of("ticktrue", 8))).size() == 16);
}

}  // namespace
}  // namespace ticktrue
