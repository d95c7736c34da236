// A failure of a session: what went wrong, where, and whether another one is the same.
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
  std::uint64_t tick = 0;  // the first one that is wrong
  // Where it shows first; empty: not known.
  std::string stage;
  std::string table;
  std::string column;
  std::optional<std::uint64_t> row;   // of the table
  std::vector<std::uint32_t> bodies;  // ids of those concerned, most concerned first; empty: not known
  std::string what;                   // for people, one line
};

/// The same kind and, unless `is_loose`, the same stage, table and column. Ticks and rows change as a session shrinks.
bool is_same(const Failure& a, const Failure& b, bool is_loose);

/// "tgs_soft, bodies.velocity": what is known of the place.
std::string place_text(const Failure& failure);

/// Ids of the bodies that a row of a state is about; none where its table knows no bodies.
std::vector<std::uint32_t> bodies_of_row(const StateView& state, std::size_t table, std::size_t row);

/// Reads table, column and stage out of messages of the engine and of the oracle, as in "tick 3: stage tgs_soft:
/// bodies.velocity row 4: ..." and "table bodies, column velocity, row 4 ...".
void read_place(std::string_view message, Failure& failure);

}  // namespace ticktrue::reduce
