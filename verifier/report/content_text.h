// Texts and strings of bytes in reports: quoted, escaped, and no more than what stands around the difference.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Bytes that a report shows before the first that differs, and from it on.
inline constexpr std::size_t content_before_max = 24;
inline constexpr std::size_t content_behind_max = 40;

/// Between quotes, on one line. Quotes, backslashes and control characters are escaped as in C; a byte that is no UTF-8
/// is \xNN.
std::string quoted(std::string_view text);
inline constexpr std::size_t hex_bytes_max = 16;
/// "00 1f ff", at most hex_bytes_max bytes.
std::string hex_bytes(std::string_view bytes);

/// Two digits a byte, without spaces, and back: nothing where it is no such text.
std::string hex_text(std::string_view bytes);
std::optional<std::string> bytes_of_hex(std::string_view text);

/// One side of a text or a string of bytes that differs.
struct ContentSide {
  std::string bytes;       // around the first that differs
  std::uint64_t size = 0;  // bytes of the whole
  bool operator==(const ContentSide&) const = default;
};

/// A side for people; nothing is "no such row". `first`: place of the first of its bytes in the whole. `offset`: of the
/// first byte that differs.
std::string content_side(bool is_text, std::uint64_t first, std::uint64_t offset,
                         const std::optional<ContentSide>& side);

/// Place and owner: "units[3].name  (id 7)".
std::string content_place(const std::string& place, std::optional<std::uint64_t> id, const std::string& name);
std::string content_place(const ContentReport& content);
/// Both sides, and where they differ.
std::string content_values(const ContentReport& content, const std::string& expected_name, const std::string& got_name);

/// Bytes of the UTF-8 character at the begin of the text; 0: there is none.
std::size_t utf8_size(std::string_view text);

}  // namespace ticktrue::verifier
