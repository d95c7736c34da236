// Escapes character by character: invalid UTF-8, control characters, the beginning of a workflow command.
// SPDX-License-Identifier: MIT
#include "base/plain_text.h"

#include <cstddef>
#include <cstdint>

namespace ticktrue {
namespace {

struct Character {
  std::uint32_t code = 0;
  std::size_t size = 1;  // bytes
  bool is_valid = true;
};

/// The first character of `text`: UTF-8 without overlong forms and surrogates (RFC 3629).
Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) -> std::uint32_t {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const std::uint32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  const std::size_t size = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4) return {0, 1, false};
  std::uint32_t code = lead & (0x7fu >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {0, i, false};
    code = (code << 6) | (byte(i) & 0x3f);
  }
  constexpr std::uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = code >= 0xd800 && code <= 0xdfff;
  return {code, size, code >= least[size] && code <= 0x10ffff && !is_surrogate};
}

bool steers(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x061c || code == 0x200e || code == 0x200f ||
         (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

void append_escaped(std::uint32_t code, std::string& out) {
  constexpr char digits[] = "0123456789abcdef";
  out += "\\u";
  for (int shift = 12; shift >= 0; shift -= 4) out += digits[(code >> shift) & 0xf];
}

/// The number of bytes at the start of `text` that need no escape. Most text is of this kind.
std::size_t ordinary_size(std::string_view text, bool at_line_start) {
  std::size_t size = 0;
  while (size < text.size() && text[size] > ' ' && text[size] < 0x7f && text[size] != '#' &&
         !(size == 0 && at_line_start && text[size] == ':'))
    ++size;
  return size;
}

std::string escaped(std::string_view text, bool allows_lines, bool& at_line_start) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    if (const std::size_t size = ordinary_size(text.substr(i), at_line_start); size > 0) {
      out += text.substr(i, size);
      i += size;
      at_line_start = false;
      continue;
    }
    const std::string_view rest = text.substr(i);
    const Character c = first_character(rest);
    i += c.size;
    const bool is_allowed_control = allows_lines && (c.code == '\n' || c.code == '\t');
    const bool begins_command =
        rest.substr(0, 2) == "#[" ? i >= 2 && text[i - 2] == '#' : at_line_start && rest.substr(0, 2) == "::";
    if (!c.is_valid)
      out += "\xef\xbf\xbd";
    else if ((steers(c.code) && !is_allowed_control) || begins_command)
      append_escaped(c.code, out);
    else
      out += rest.substr(0, c.size);
    // Spaces before a command count as the beginning of the line, since a runner skips them.
    at_line_start = allows_lines && c.code == '\n' ? true : at_line_start && (c.code == ' ' || c.code == '\t');
  }
  return out;
}

}  // namespace

std::string plain_text(std::string_view text, bool& at_line_start) {
  return escaped(text, true, at_line_start);
}

std::string plain_text(std::string_view text) {
  bool at_line_start = true;
  return escaped(text, true, at_line_start);
}

std::string plain_line(std::string_view text) {
  bool at_line_start = true;
  return escaped(text, false, at_line_start);
}

}  // namespace ticktrue
