// Keys of JSON Schemas, and of the readers of such files.
// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "tests/support/catch.h"

namespace ticktrue::test {

inline std::set<std::string> keys_of(const nlohmann::json& object) {
  std::set<std::string> keys;
  for (const auto& item : object.items()) keys.insert(item.key());
  return keys;
}

/// The keys that a reader knows, from the list in its message about the key "?".
inline std::set<std::string> reader_keys(const std::string& message) {
  REQUIRE(message.find("unknown key: found \"?\", expected ") != std::string::npos);
  std::string list = message.substr(message.find("expected ") + 9);
  list = list.substr(0, list.find('\n'));
  for (std::size_t at = list.find(" or "); at != std::string::npos; at = list.find(" or ")) list.replace(at, 4, ", ");
  std::set<std::string> keys;
  std::istringstream in(list);
  for (std::string key; std::getline(in, key, ',');) keys.insert(key.substr(key.find_first_not_of(' ')));
  return keys;
}

}  // namespace ticktrue::test
