// Reads a trace tick by tick and keeps the checkpoints on the way.
// SPDX-License-Identifier: MIT
#include "verifier/compare/trace_side.h"

#include <variant>

namespace ticktrue::verifier {

const replay::TickRecord* TraceSide::advance() {
  checkpoint_.reset();
  if (ended_) return nullptr;
  for (;;) {
    const replay::TraceReader::Item& item = reader_.next();
    if (const auto* record = std::get_if<replay::TickRecord>(&item)) {
      ++ticks_;
      return record;
    }
    if (std::holds_alternative<std::monostate>(item)) {
      ended_ = true;
      return nullptr;
    }
    checkpoint_ = copy_of(std::get<replay::CheckpointRecord>(item));
    time_s_ = std::get<replay::CheckpointRecord>(item).time_s.value_or(0);
    if (updates_last_) last_ = checkpoint_;
  }
}

bool ends_early(const replay::TraceTail& tail) {
  if (!tail.end) return false;
  const replay::EndReason reason = tail.end->reason;
  return reason == replay::EndReason::recovered || reason == replay::EndReason::interrupted;
}

void count_parts(const replay::TickRecord& record, ComparedParts& counts) {
  ++counts.ticks;
  counts.stage_hashes += record.stage_hashes.empty() ? 0 : 1;
  counts.images += record.image ? 1 : 0;
  counts.cells += record.cells == nullptr ? 0 : 1;
}

}  // namespace ticktrue::verifier
