// Text from outside cannot control a terminal or a runner. Harmless text stays unchanged.
// SPDX-License-Identifier: MIT
#include "base/plain_text.h"

#include <string>

#include "tests/support/catch.h"

using ticktrue::plain_line;
using ticktrue::plain_text;

TEST_CASE("text without controls stays as it is", "[base][plain_text][analytic]") {
  for (const std::string text : {"", "crate_7", "a: b :: c # d [e]\n\tf\n",
                                 "gr\xc3\xbc\xc3\x9f"
                                 "e \xe2\x82\xac \xf0\x9f\x98\x80",
                                 "#[x", "# #[x", ": ::x"})
    CHECK(plain_text(text) == text);
}

TEST_CASE("every control character, C1 and directions included, becomes \\uXXXX", "[base][plain_text][analytic]") {
  CHECK(plain_text("\x1b[2J\a\r\x7f") == "\\u001b[2J\\u0007\\u000d\\u007f");
  CHECK(plain_text(std::string("a\0b", 3)) == "a\\u0000b");
  CHECK(plain_text("\xc2\x9b"
                   "31m") == "\\u009b31m");
  CHECK(plain_text("\xe2\x80\xae"
                   "x\xe2\x81\xa6\xd8\x9c\xe2\x80\xa8") == "\\u202ex\\u2066\\u061c\\u2028");
  CHECK(plain_text("a\nb\tc") == "a\nb\tc");
  CHECK(plain_line("a\nb\tc") == "a\\u000ab\\u0009c");
}

TEST_CASE("bytes that are no UTF-8 become the replacement character", "[base][plain_text][analytic]") {
  const std::string mark = "\xef\xbf\xbd";
  CHECK(plain_text("\xff\xfe") == mark + mark);
  CHECK(plain_text("a\xc2") == "a" + mark);
  CHECK(plain_text("\xe2\x82") == mark);
  CHECK(plain_text("\xc0\xaf") == mark + mark);             // overlong
  CHECK(plain_text("\xe0\x80\xaf") == mark);                // overlong
  CHECK(plain_text("\xed\xa0\x80") == mark);                // a surrogate
  CHECK(plain_text("\xf4\x90\x80\x80") == mark);            // beyond U+10FFFF
  CHECK(plain_text("\xe2\x1b[2J") == mark + "\\u001b[2J");  // bytes after a truncated character are escaped as well
}

TEST_CASE("no line begins a workflow command, and none holds the older form", "[base][plain_text][analytic]") {
  CHECK(plain_text("::error::x") == "\\u003a:error::x");
  CHECK(plain_text("a\n  ::error::x\n\t::y") == "a\n  \\u003a:error::x\n\t\\u003a:y");
  CHECK(plain_text("a ::error::x") == "a ::error::x");
  CHECK(plain_text("a ##[error]x") == "a #\\u0023[error]x");
  CHECK(plain_text("###[x") == "##\\u0023[x");
  bool at_line_start = true;
  CHECK(plain_text("a", at_line_start) == "a");
  CHECK_FALSE(at_line_start);
  CHECK(plain_text("::b\n ", at_line_start) == "::b\n ");
  CHECK(at_line_start);
  CHECK(plain_text("::c", at_line_start) == "\\u003a:c");
}
