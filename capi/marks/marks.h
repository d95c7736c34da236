// The marks of the tick that runs: counted always, listed where the tick is stored in full or `ticktrue trail` asks.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "replay/format/mark_log.h"
#include "replay/format/mark_tally.h"

namespace ticktrue::capi {

/// Marks and notes of one tick: stored in the trace outside of its chain.
struct BoundContents {
  std::optional<replay::TickMarks> marks;     // nothing: no mark
  std::optional<replay::MarkList> mark_list;  // nothing: not wanted, or no mark
  replay::MarkStacks stacks;                  // of the list, where they are wanted
  std::vector<replay::Note> notes;
};

/// Where the marks of one tick were made. Equal call stacks are stored once.
class StackCollector {
 public:
  /// The stack of the call that returns to `caller`. Elsewhere than with glibc: nothing.
  void add(const void* caller);
  replay::MarkStacks take();

 private:
  std::map<std::vector<const void*>, std::uint32_t> numbers_;
  std::vector<std::uint32_t> of_marks_;
};

/// counts: counts and hashes alone. list: the marks in order as well. stacks: the list with the call stack of each
/// mark.
enum class MarkDetail : std::uint8_t { counts, list, stacks };

class SessionMarks {
 public:
  SessionMarks();

  /// Off: marks are dropped.
  bool is_on() const { return is_on_; }
  void turn_on() { is_on_ = true; }

  void begin_tick(MarkDetail detail) { detail_ = detail; }
  /// Counts a mark, if that takes no more than an addition. False: add() does it.
  bool add_again(const char* name, std::uint64_t value) {
    return detail_ == MarkDetail::counts && tally_.add_again(name, value);
  }
  /// Requires: is_on(), a tick runs. `caller`: where the call returns to.
  void add(const char* name, std::uint64_t value, const void* caller);
  /// The marks made since begin_tick().
  BoundContents take();

 private:
  bool is_on_ = false;
  MarkDetail detail_ = MarkDetail::counts;
  replay::MarkTally tally_;
  std::vector<replay::Mark> list_;
  StackCollector stacks_;
};

}  // namespace ticktrue::capi
