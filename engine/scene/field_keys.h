// Which fields a kind has, with their JSON keys: what the rows of such tables are made of.
// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace ticktrue::engine {

template <typename Field>
struct FieldKey {
  Field field{};
  std::string_view key;  // empty: ends the row
  bool required = false;
};

/// The key of a field in a row of these tables; empty where the kind has no such field.
template <typename Row, typename Field>
constexpr std::string_view key_of(const Row& row, Field field) {
  for (const auto& entry : row.keys)
    if (!entry.key.empty() && entry.field == field) return entry.key;
  return {};
}

}  // namespace ticktrue::engine
