// A file of the store: head, kind, key, writer, content, checksum.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/bytes.h"

namespace ticktrue::verifier {

struct VerdictEntry {
  enum class Kind : std::uint8_t { verdict = 1, conflict = 2, agreement = 3, history = 4 };
  Kind kind = Kind::verdict;
  std::string key;
  std::string by;  // build and process, for people
  Bytes content;   // for a verdict: encode_report; for a conflict: text; else defined by the caller
};

Bytes encode_entry(const VerdictEntry& entry);

/// Nothing: the bytes are damaged.
std::optional<VerdictEntry> decode_entry(ByteView bytes);

}  // namespace ticktrue::verifier
