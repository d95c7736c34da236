// Numbers as text, over the C library's correctly rounded conversions.
// SPDX-License-Identifier: MIT
#include "engine/json/number_text.h"

#include <cstdio>
#include <cstdlib>

namespace ticktrue::engine {

std::string number_text(double value) {
  char text[40];
  // Numbers that people write have few digits, computed numbers have 16 or 17. Try few digits first, and skip the
  // middle.
  for (const int digits : {6, 9, 12, 15, 16, 17}) {
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    if (std::strtod(text, nullptr) == value) break;
  }
  return text;
}

std::optional<double> parse_number(std::string_view text) {
  constexpr std::size_t size_max = 64;  // longer than any number that a program prints
  if (text.empty() || text.size() > size_max) return std::nullopt;
  bool has_digit = false;
  for (const char c : text) {
    has_digit = has_digit || (c >= '0' && c <= '9');
    if (!(c >= '0' && c <= '9') && c != '-' && c != '+' && c != '.' && c != 'e' && c != 'E') return std::nullopt;
  }
  if (!has_digit) return std::nullopt;
  const std::string copy(text);
  char* end = nullptr;
  const double value = std::strtod(copy.c_str(), &end);
  if (end != copy.c_str() + copy.size() || !(value - value == 0)) return std::nullopt;
  return value;
}

}  // namespace ticktrue::engine
