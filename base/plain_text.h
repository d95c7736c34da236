// Escapes text from outside for a terminal, a log or a page, so that none of its characters can control the display.
// SPDX-License-Identifier: MIT
//
// Escapes have the form \uXXXX, as in JSON. Escaped are: control characters (C0, DEL, C1); the characters that change
// the direction of text or end a line (U+061C, U+200E, U+200F, U+2028..U+202E, U+2066..U+2069); the `##[` of a workflow
// command anywhere; and the first colon of `::` at the beginning of a line. Bytes that are no UTF-8 become U+FFFD.
#pragma once

#include <string>
#include <string_view>

namespace ticktrue {

/// Several lines:
///  and \t stay. In JSON only texts change, and their meaning stays the same. `at_line_start`: in: whether the text
/// begins a line; out: whether the next text does.
std::string plain_text(std::string_view text, bool& at_line_start);
std::string plain_text(std::string_view text);

/// One line: \n and \t are escaped, too.
std::string plain_line(std::string_view text);

}  // namespace ticktrue
