// The rules for records outside of the chain: names, marks, notes.
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
  /// Empty, or why the record may not stand in this tick.
  std::string check(const Record& record, const TraceSetup& setup, std::uint64_t tick);
  /// The records behind this belong to the next tick.
  void end_tick() {
    has_marks_ = false;
    list_size_ = 0;
  }

 private:
  std::string check_name(ByteView body);
  std::string check_marks(ByteView body);
  std::string check_mark_list(ByteView body);

  std::size_t size_ = 0;         // bytes of all records of the chunk
  std::set<std::string> names_;  // of the chunk
  bool has_marks_ = false;       // in this tick
  std::size_t list_size_ = 0;    // in this tick
};

}  // namespace ticktrue::replay
