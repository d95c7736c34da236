// Compares two lists of marks of one tick: the first difference, and the number of calls from each function.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "replay/format/mark_log.h"
#include "tool/experiment/shake/call_site.h"

namespace ticktrue::trail {

/// The marks of one side.
struct MarkSide {
  replay::MarkList list;
  /// Functions of the program, innermost first. Empty: the places of the marks are unknown.
  std::vector<std::vector<shake::CallSite>> stacks;
  std::vector<std::uint32_t> of_marks;  // [mark] index in `stacks`

  bool has_stacks() const { return !stacks.empty(); }
};

/// Converts logged marks, with stacks as functions.
MarkSide side_of(const replay::LoggedList& logged);

struct MarkPlace {
  std::string name;
  std::uint64_t value = 0;
  std::vector<shake::CallSite> stack;
};

/// `extra`: only here. `missing`: only there. `value`: the same mark with another value. `other`: another mark.
enum class FirstKind : std::uint8_t { extra, missing, value, other };
const char* name_of(FirstKind kind);

struct FirstMark {
  FirstKind kind = FirstKind::other;
  std::uint64_t index = 0;  // in the tick, from 0
  std::optional<MarkPlace> here;
  std::optional<MarkPlace> there;
};

/// The marks of one name from one calling function.
struct CallerCount {
  std::string name;
  std::string caller;  // "Shuffle", or "draw < Shuffle" if draw makes all marks of this name
  std::uint64_t here = 0;
  std::optional<std::uint64_t> there;  // absent: unknown
};

struct ListDifference {
  std::optional<FirstMark> first;    // absent: the lists are equal as far as they go
  std::vector<CallerCount> callers;  // that differ; if only one side has stacks: of names that differ
  bool compares_callers = false;     // both sides know the functions of their marks
};

/// Requires: `there` is null or a list.
ListDifference compare_lists(const MarkSide& here, const MarkSide* there, const std::vector<std::string>& names);

}  // namespace ticktrue::trail
