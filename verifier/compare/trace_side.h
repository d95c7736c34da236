// One of the traces that are compared, tick by tick.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "replay/trace_reader.h"
#include "verifier/locate/compare_tick.h"

namespace ticktrue::verifier {

/// Holds one tick and at most two checkpoints at a time, however long the trace is.
class TraceSide {
 public:
  /// The reader must outlive this. It is rewound.
  explicit TraceSide(replay::TraceReader& reader) : reader_(reader) { reader_.rewind(); }

  /// The next tick, valid until the next call, or null at the end. Stores the checkpoint that it passes.
  const replay::TickRecord* advance();

  /// The one passed on the way to the present tick, if it holds the state with so many ticks done.
  const StoredCheckpoint* checkpoint_at(std::uint64_t ticks_done) const {
    return checkpoint_ && checkpoint_->tick == ticks_done ? &*checkpoint_ : nullptr;
  }
  std::uint64_t ticks() const { return ticks_; }
  /// The last checkpoint passed; fixed after freeze_last.
  const std::optional<StoredCheckpoint>& last() const { return last_; }
  void freeze_last() { updates_last_ = false; }
  /// Requires: advance() gave null.
  const replay::TraceTail& tail() const { return reader_.tail(); }
  std::uint64_t first_tick() const { return reader_.first_tick(); }
  std::uint64_t end_tick() const { return first_tick() + ticks_; }
  /// Simulated before the checkpoint passed last.
  double time_s() const { return time_s_; }
  /// Whether the recorder was stopped, or died, before its end. Requires: advance() gave null.
  bool was_stopped() const;

 private:
  replay::TraceReader& reader_;
  std::optional<StoredCheckpoint> checkpoint_;
  std::optional<StoredCheckpoint> last_;
  bool updates_last_ = true;
  std::uint64_t ticks_ = 0;
  double time_s_ = 0;
  bool ended_ = false;
};

/// Counts the parts that are stored of a tick.
void count_parts(const replay::TickRecord& record, ComparedParts& counts);

}  // namespace ticktrue::verifier
