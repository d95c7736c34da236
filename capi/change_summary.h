// Finds tables that stayed empty and columns that never changed during a session.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/state/kept_state.h"
#include "base/state/state_view.h"

namespace ticktrue::capi {

/// Watches each confirmed state. A column that has changed costs no more time.
class ChangeSummary {
 public:
  /// `table_hashes`: of this state. A table with the hash that it had in the first state counts as unchanged.
  void add(const StateView& state, std::span<const std::uint64_t> table_hashes);
  /// One line each. Empty: nothing to report, or nothing changed at all.
  std::vector<std::string> lines() const;

 private:
  struct Table {
    bool had_rows = false;
    std::vector<std::size_t> constant;  // columns without a change so far, without keys
  };
  void compare(std::size_t number, const TableRows& rows);

  std::optional<KeptState> first_;
  std::vector<std::uint64_t> first_hashes_;  // [table]
  std::vector<Table> tables_;
};

}  // namespace ticktrue::capi
