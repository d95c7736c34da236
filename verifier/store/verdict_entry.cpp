// Encodes and checks the file of a verdict.
// SPDX-License-Identifier: MIT
#include "verifier/store/verdict_entry.h"

#include <cstring>
#include <string_view>
#include <utility>

#include "base/hash.h"

namespace ticktrue::verifier {
namespace {

constexpr std::string_view head = "ticktrue verdict 1\n";
constexpr std::size_t checksum_size = 8;
constexpr std::size_t key_size = 32;

}  // namespace

Bytes encode_entry(const VerdictEntry& entry) {
  ByteWriter out;
  for (const char c : head) out.u8(static_cast<std::uint8_t>(c));
  out.u8(static_cast<std::uint8_t>(entry.kind));
  out.text(entry.key);
  out.text(entry.by);
  out.u64(entry.content.size());
  out.bytes(entry.content);
  out.u64(hash64(out.view()));
  return out.take();
}

std::optional<VerdictEntry> decode_entry(ByteView bytes) {
  if (bytes.size() < head.size() + checksum_size) return std::nullopt;
  const ByteView covered = bytes.first(bytes.size() - checksum_size);
  ByteReader checksum(bytes.last(checksum_size));
  if (checksum.u64() != hash64(covered)) return std::nullopt;
  if (std::memcmp(covered.data(), head.data(), head.size()) != 0) return std::nullopt;
  ByteReader in(covered.subspan(head.size()));
  VerdictEntry entry;
  const std::uint8_t kind = in.u8();
  if (kind < static_cast<std::uint8_t>(VerdictEntry::Kind::verdict) ||
      kind > static_cast<std::uint8_t>(VerdictEntry::Kind::history))
    return std::nullopt;
  entry.kind = static_cast<VerdictEntry::Kind>(kind);
  entry.key = in.text(key_size);
  entry.by = in.text(in.remaining());
  const std::uint64_t size = in.u64();
  if (!in.ok() || size != in.remaining()) return std::nullopt;
  const ByteView content = in.bytes(static_cast<std::size_t>(size));
  entry.content.assign(content.begin(), content.end());
  return in.ok() ? std::optional<VerdictEntry>(std::move(entry)) : std::nullopt;
}

}  // namespace ticktrue::verifier
