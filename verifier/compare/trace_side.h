// One of several compared traces, read tick by tick.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "replay/trace_reader.h"
#include "verifier/locate/compare_tick.h"

namespace ticktrue::verifier {

/// Whether the recorder of this end was stopped, or died, before its own end.
bool ends_early(const replay::TraceTail& tail);

/// Stores one tick and at most two checkpoints at a time.
class TraceSide {
 public:
  /// Rewinds the reader. The reader must outlive this object.
  explicit TraceSide(replay::TraceReader& reader) : reader_(reader) { reader_.rewind(); }

  /// The next tick, valid until the next call; null: the end. Keeps a checkpoint on the way.
  const replay::TickRecord* advance();

  /// The last checkpoint on the way to the present tick, if it has the state after `ticks_done` ticks.
  const StoredCheckpoint* checkpoint_at(std::uint64_t ticks_done) const {
    return checkpoint_ && checkpoint_->tick == ticks_done ? &*checkpoint_ : nullptr;
  }
  std::uint64_t ticks() const { return ticks_; }
  /// The last checkpoint on the way; it stays after freeze_last.
  const std::optional<StoredCheckpoint>& last() const { return last_; }
  void freeze_last() { updates_last_ = false; }
  /// Requires: advance() returned null.
  const replay::TraceTail& tail() const { return reader_.tail(); }
  std::uint64_t first_tick() const { return reader_.first_tick(); }
  std::uint64_t end_tick() const { return first_tick() + ticks_; }
  /// Simulated time before the last checkpoint on the way.
  double time_s() const { return time_s_; }
  /// Whether the recorder was stopped, or died, before its end. Requires: advance() returned null.
  bool was_stopped() const { return ends_early(tail()); }

 private:
  replay::TraceReader& reader_;
  std::optional<StoredCheckpoint> checkpoint_;
  std::optional<StoredCheckpoint> last_;
  bool updates_last_ = true;
  std::uint64_t ticks_ = 0;
  double time_s_ = 0;
  bool ended_ = false;
};

/// Counts the stored parts of a tick.
void count_parts(const replay::TickRecord& record, ComparedParts& counts);

}  // namespace ticktrue::verifier
