// The marks of the tick that runs: counted always, listed where the tick is stored in full.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "replay/format/mark_tally.h"

namespace ticktrue::capi {

/// What a program gives in a tick beside inputs and state.
struct BoundContents {
  std::optional<replay::TickMarks> marks;     // nothing: no mark
  std::optional<replay::MarkList> mark_list;  // nothing: not wanted
  std::vector<replay::Note> notes;
};

class SessionMarks {
 public:
  SessionMarks();

  /// Off: marks are dropped.
  bool is_on() const { return is_on_; }
  void turn_on() { is_on_ = true; }

  void begin_tick(bool wants_list) { lists_ = wants_list; }
  /// Requires: is_on(), a tick runs.
  void add(const char* name, std::uint64_t value) {
    if (name != nullptr && !lists_) {
      const std::uint32_t entry = tally_.find(name);
      if (entry < replay::MarkTally::name_count_max) return tally_.add(entry, value);
    }
    add_slowly(name, value);
  }
  /// Those since begin_tick().
  BoundContents take();

 private:
  void add_slowly(const char* name, std::uint64_t value);

  bool is_on_ = false;
  bool lists_ = false;
  replay::MarkTally tally_;
  std::vector<replay::Mark> list_;
};

}  // namespace ticktrue::capi
