// The sources of the page, put into the program when it is built.
// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace ticktrue::tool {

extern const std::string_view page_html;  // with {{names}} of what is put in
extern const std::string_view page_css;
extern const std::string_view page_js;

}  // namespace ticktrue::tool
