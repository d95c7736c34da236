// The marks of the running tick. They are always counted. They are listed if the tick is stored in full, or for
// `ticktrue trail`.
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

/// Marks and notes of one tick: stored in the trace outside its chain.
struct BoundContents {
  std::optional<replay::TickMarks> marks;     // nothing: no mark
  std::optional<replay::MarkList> mark_list;  // nothing: not requested, or no mark
  replay::MarkStacks stacks;                  // of the list, if they are requested
  std::vector<replay::Note> notes;
};

/// Collects the call stacks of the marks in one tick. Equal call stacks are stored once.
class StackCollector {
 public:
  /// Adds the stack of the call that returns to `caller`. Without glibc it adds nothing.
  void add(const void* caller);
  replay::MarkStacks take();

 private:
  std::map<std::vector<const void*>, std::uint32_t> numbers_;
  std::vector<std::uint32_t> of_marks_;
};

/// counts: only counts and hashes. list: also the marks in order. stacks: also the call stack of each mark.
enum class MarkDetail : std::uint8_t { counts, list, stacks };

class SessionMarks {
 public:
  SessionMarks();

  /// False: marks are dropped.
  bool is_on() const { return is_on_; }
  void turn_on() { is_on_ = true; }

  void begin_tick(MarkDetail detail) { detail_ = detail; }
  /// Counts a mark if this takes only an addition. False: the caller must call add().
  bool add_again(const char* name, std::uint64_t value) {
    return detail_ == MarkDetail::counts && tally_.add_again(name, value);
  }
  /// Requires: is_on(), a running tick. `caller`: the return address of the call.
  void add(const char* name, std::uint64_t value, const void* caller);
  /// Returns the marks since begin_tick().
  BoundContents take();

 private:
  bool is_on_ = false;
  MarkDetail detail_ = MarkDetail::counts;
  replay::MarkTally tally_;
  std::vector<replay::Mark> list_;
  StackCollector stacks_;
};

}  // namespace ticktrue::capi
