// Poison: bytes that make wrong results obvious, in memory that a tick must not read before it writes.
// SPDX-License-Identifier: MIT
// A workspace lists its fields once, in list_fields(workspace, visit), by a structured binding. If a field is missing
// there, the code does not compile. Poisoning and the list of caches use this list.
// while a field is not named there. Poisoning and the list of caches follow from it.
#pragma once

#include <array>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "engine/model/caches.h"

namespace ticktrue::engine {

template <typename T>
void poison_rows(std::vector<T>& rows) {
  static_assert(std::is_trivially_copyable_v<T>);
  rows.resize(rows.capacity());
  if (!rows.empty()) std::memset(static_cast<void*>(rows.data()), 0xff, rows.size() * sizeof(T));
  rows.clear();
}

/// A field whose rows are only appended: poisoning keeps their number.
template <typename T>
struct InPlace {
  std::vector<T>& rows;
};
template <typename T>
InPlace<T> in_place(std::vector<T>& rows) {
  return {rows};
}

/// Takes fields and does nothing with them.
struct IgnoreFields {
  template <typename... Fields>
  void operator()(Fields&&...) const {}
};
template <typename T>
concept Workspace = requires(T& field) {
  list_fields(field, IgnoreFields{});
};

/// Overwrites a field, unless it is a cache. Overwrites the fields of a workspace one by one.
struct Poison {
  template <typename... Fields>
  void operator()(Fields&&... fields) const {
    (overwrite(fields), ...);
  }

 private:
  template <typename T>
  void overwrite(InPlace<T>& field) const {
    if constexpr (Workspace<T> || !std::is_trivially_copyable_v<T>) {
      for (T& row : field.rows) overwrite(row);
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      if (!field.rows.empty()) std::memset(static_cast<void*>(field.rows.data()), 0xff, field.rows.size() * sizeof(T));
    }
  }
  template <typename T>
  void overwrite(std::vector<T>& rows) const {
    poison_rows(rows);
  }
  template <typename T>
  void overwrite(std::span<T>& rows) const {
    rows = {};
  }
  template <typename T, std::size_t count>
  void overwrite(std::array<T, count>& fields) const {
    for (T& field : fields) overwrite(field);
  }
  template <typename T>
  void overwrite(T& field) const {
    if constexpr (Workspace<T>) {
      list_fields(field, *this);
    } else if constexpr (std::is_same_v<T, bool>) {
      field = !field;  // a bool has no other bit patterns
    } else if constexpr (!std::is_base_of_v<TickCache, T>) {
      static_assert(std::is_trivially_copyable_v<T>);
      std::memset(static_cast<void*>(&field), 0xff, sizeof field);
    }
  }
};

/// Appends the caches among the fields of a workspace.
struct ListCaches {
  std::vector<TickCache*>& caches;

  template <typename... Fields>
  void operator()(Fields&&... fields) const {
    (add(fields), ...);
  }

 private:
  template <typename T>
  void add(T& field) const {
    if constexpr (std::is_base_of_v<TickCache, T>)
      caches.push_back(&field);
    else if constexpr (Workspace<T>)
      list_fields(field, *this);
  }
};

}  // namespace ticktrue::engine
