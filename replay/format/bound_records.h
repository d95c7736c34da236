// The rules for records outside the chain: names, marks, notes.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

#include "replay/format/chunk.h"
#include "replay/format/trace.h"

namespace ticktrue::replay {

/// Checks the bound records of one ticks chunk, in their order.
class BoundRules {
 public:
  /// Returns why the record must not be in this tick; empty: it may.
  std::string check(const Record& record, const TraceSetup& setup, std::uint64_t tick);
  /// Ends the tick: later records belong to the next tick.
  void end_tick() {
    has_marks_ = false;
    list_size_ = 0;
  }

 private:
  std::string check_name(ByteView body);
  std::string check_marks(ByteView body);
  std::string check_mark_list(ByteView body);

  std::size_t size_ = 0;         // bytes of all records in the chunk
  std::set<std::string> names_;  // names of marks in the chunk
  bool has_marks_ = false;       // in this tick
  std::size_t list_size_ = 0;    // bytes of mark lists in this tick
};

}  // namespace ticktrue::replay
