// JSON on standard output: one object, keys in the order in which they were added.
// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

#include "tool/output/cli.h"

namespace ticktrue::cli {

using Json = nlohmann::ordered_json;

/// `indent` -1: on one line, for JSON Lines. Bytes that are no UTF-8 (of a file name) become U+FFFD.
inline void print_json(const Json& object, int indent = 2) {
  print(object.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace ticktrue::cli
