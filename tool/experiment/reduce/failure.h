// A failure of a session: its kind, its place, and whether another failure is the same.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/state/state_view.h"

namespace ticktrue::reduce {

struct Failure {
  std::string kind;        // "not_finite", "diverged", ...: the first word of reports
  std::uint64_t tick = 0;  // the first wrong tick
  // The place where the failure first appears; empty: unknown.
  std::string stage;
  std::string table;
  std::string column;
  std::optional<std::uint64_t> row;   // index in the table
  std::vector<std::uint32_t> bodies;  // ids of the affected bodies, most affected first; empty: unknown
  std::string what;                   // one line of text
};

/// Same kind and, unless `is_loose`, same stage, table and column. Ticks and state rows change as a session shrinks.
bool is_same(const Failure& a, const Failure& b, bool is_loose);

/// The known parts of the place: "tgs_soft, bodies.velocity".
std::string place_text(const Failure& failure);

/// Ids of the bodies that a state row refers to. Empty if the rows of its table refer to no bodies.
std::vector<std::uint32_t> bodies_of_row(const StateView& state, std::size_t table, std::size_t row);

/// Parses table, column and stage from messages of the engine and of the oracle, such as "tick 3: stage tgs_soft:
/// bodies.velocity row 4: ..." and "table bodies, column velocity, row 4 ...".
void read_place(std::string_view message, Failure& failure);

}  // namespace ticktrue::reduce
