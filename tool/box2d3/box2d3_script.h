// The text of peer.mjs, put into the program when it is built.
// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace ticktrue::tool {

extern const std::string_view box2d3_script;

}  // namespace ticktrue::tool
