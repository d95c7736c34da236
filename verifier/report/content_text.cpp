// Words for texts and strings of bytes that differ.
// SPDX-License-Identifier: MIT
#include "verifier/report/content_text.h"

#include <algorithm>

namespace ticktrue::verifier {
namespace {

constexpr char digits[] = "0123456789abcdef";
constexpr std::size_t hex_bytes_max = 16;

/// One side. `is_whole`: nothing of it is left out.
std::string side_text(const ContentReport& content, const std::optional<std::string>& bytes, std::uint64_t size) {
  if (!bytes) return "no such row";
  if (size == 0) return content.is_text ? "\"\"" : "nothing";
  if (!content.is_text) {
    if (content.offset >= size) return "ends before it";
    const std::size_t skipped = static_cast<std::size_t>(
        std::min<std::uint64_t>(content.offset - std::min(content.first, content.offset), bytes->size()));
    const std::string_view behind = std::string_view(*bytes).substr(skipped);
    return hex_bytes(behind) + (content.offset + std::min(behind.size(), hex_bytes_max) < size ? " ..." : "");
  }
  return (content.first > 0 ? "..." : "") + quoted(*bytes) + (content.first + bytes->size() < size ? "..." : "");
}

}  // namespace

std::size_t utf8_size(std::string_view text) {
  if (text.empty()) return 0;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t size = lead >= 0xc2 && lead < 0xe0   ? 2
                           : lead >= 0xe0 && lead < 0xf0 ? 3
                           : lead >= 0xf0 && lead < 0xf5 ? 4
                                                         : 0;
  if (size == 0 || size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  // Encodings that are too long, surrogates, and what is beyond U+10FFFF.
  if ((lead == 0xe0 && byte(1) < 0xa0) || (lead == 0xed && byte(1) > 0x9f) || (lead == 0xf0 && byte(1) < 0x90) ||
      (lead == 0xf4 && byte(1) > 0x8f))
    return 0;
  return size;
}

std::string quoted(std::string_view text) {
  std::string out = "\"";
  while (!text.empty()) {
    const std::size_t size = utf8_size(text);
    const auto byte = static_cast<unsigned char>(text[0]);
    if (byte == '"' || byte == '\\') {
      out += '\\';
      out += text[0];
    } else if (byte == '\n') {
      out += "\\n";
    } else if (byte == '\t') {
      out += "\\t";
    } else if (size == 0 || byte < 0x20 || byte == 0x7f) {
      out += "\\x";
      out += digits[byte >> 4];
      out += digits[byte & 15];
    } else {
      out += text.substr(0, size);
    }
    text.remove_prefix(std::max<std::size_t>(size, 1));
  }
  return out + "\"";
}

std::string hex_bytes(std::string_view bytes) {
  std::string text;
  for (const char c : bytes.substr(0, hex_bytes_max)) {
    const auto byte = static_cast<unsigned char>(c);
    if (!text.empty()) text += ' ';
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text;
}

std::string hex_text(std::string_view bytes) {
  std::string text;
  for (const char c : bytes) {
    text += digits[static_cast<unsigned char>(c) >> 4];
    text += digits[static_cast<unsigned char>(c) & 15];
  }
  return text;
}

std::optional<std::string> bytes_of_hex(std::string_view text) {
  const auto digit = [](char c) { return std::string_view(digits).find(c); };
  if (text.size() % 2 != 0) return std::nullopt;
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); i += 2) {
    if (digit(text[i]) > 15 || digit(text[i + 1]) > 15) return std::nullopt;
    bytes += static_cast<char>(digit(text[i]) << 4 | digit(text[i + 1]));
  }
  return bytes;
}

std::string content_place(const ContentReport& content) {
  std::string text = content.place;
  if (!content.id && content.name.empty()) return text;
  text += "  (";
  if (content.id) text += "id " + std::to_string(*content.id);
  if (content.id && !content.name.empty()) text += ", ";
  if (!content.name.empty()) text += "name \"" + content.name + "\"";
  return text + ")";
}

std::string content_values(const ContentReport& content, const std::string& expected_name,
                           const std::string& got_name) {
  std::string text = expected_name + " " + side_text(content, content.expected, content.expected_size) + ".  " +
                     got_name + " " + side_text(content, content.got, content.got_size) + ".";
  if (!content.expected || !content.got) return text;
  text += content.character ? "  differs at character " + std::to_string(*content.character)
                            : "  differs at byte " + std::to_string(content.offset);
  if (content.expected_size != content.got_size)
    text += "; " + std::to_string(content.expected_size) + " and " + std::to_string(content.got_size) + " bytes";
  else if (!content.is_text)
    text += " of " + std::to_string(content.expected_size);
  return text;
}

}  // namespace ticktrue::verifier
