// Numbers as text: shortest form that reads back exactly, and strict reading.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ticktrue::engine {

/// The shortest decimal of at most 17 digits that reads back to the same double.
std::string number_text(double value);

/// Reads a text that is one finite decimal number: sign, digits, point, exponent. Anything else gives nothing: spaces,
/// hexadecimal, "nan", "inf", overflow.
std::optional<double> parse_number(std::string_view text);

}  // namespace ticktrue::engine
