// Texts and byte strings in reports: quoted, escaped, and shortened around the difference.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Number of bytes in a report before the first differing byte, and from this byte on.
inline constexpr std::size_t content_before_max = 24;
inline constexpr std::size_t content_behind_max = 40;

/// The text in quotes, on one line. Quotes, backslashes and control characters are escaped as in C. A byte that is not
/// valid UTF-8 becomes \xNN.
std::string quoted(std::string_view text);
inline constexpr std::size_t hex_bytes_max = 16;
/// "00 1f ff", at most hex_bytes_max bytes.
std::string hex_bytes(std::string_view bytes);

/// Two digits per byte, without spaces, and the reverse, which returns nothing for another text.
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
/// The values of both sides, and the place of the difference.
std::string content_values(const ContentReport& content, const std::string& expected_name, const std::string& got_name);

/// Size in bytes of the UTF-8 character at the begin of the text; 0: there is none.
std::size_t utf8_size(std::string_view text);

}  // namespace ticktrue::verifier
