// Bytes that make wrong results loud, in memory that a tick must not read before writing it.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>
#include <vector>

namespace ticktrue::engine {

template <typename T>
void poison_rows(std::vector<T>& rows) {
  rows.resize(rows.capacity());
  if (!rows.empty()) std::memset(static_cast<void*>(rows.data()), 0xff, rows.size() * sizeof(T));
  rows.clear();
}

/// Rows that are only ever added to.
template <typename T>
void poison_in_place(std::vector<T>& rows) {
  if (!rows.empty()) std::memset(static_cast<void*>(rows.data()), 0xff, rows.size() * sizeof(T));
}

/// poison_rows of each.
template <typename... Rows>
void poison_all(Rows&... rows) {
  (poison_rows(rows), ...);
}

}  // namespace ticktrue::engine
