// Reads on inside a damaged ticks chunk, as far as recovery would.
// SPDX-License-Identifier: MIT
#include "verifier/verify/trace_source.h"

#include <variant>

namespace ticktrue::verifier {
namespace {

/// Reads to the end. Returns the number of ticks that recovery would save; nothing: the file does not just end.
std::optional<std::uint64_t> count_recoverable(replay::TraceReader& before_damage) {
  while (!std::holds_alternative<std::monostate>(before_damage.next())) {
  }
  const replay::TraceTail& tail = before_damage.tail();
  if (tail.condition != replay::TraceCondition::truncated || tail.ticks_intact < replay::salvage_margin)
    return std::nullopt;
  return tail.ticks_intact - replay::salvage_margin;
}

bool is_same_recording(const replay::TraceSetup& a, const replay::TraceSetup& b) {
  return a.simulation == b.simulation && a.title == b.title && a.dt == b.dt && a.setup == b.setup;
}

}  // namespace

const replay::TraceReader::Item& ReaderSource::next() {
  if (is_salvaging_) return next_salvaged();
  const replay::TraceReader::Item& item = reader_.next();
  if (!std::holds_alternative<std::monostate>(item)) return item;
  begin_salvage();
  return is_salvaging_ ? next_salvaged() : item;
}

void ReaderSource::begin_salvage() {
  const replay::TraceTail& tail = reader_.tail();
  if (tail.condition != replay::TraceCondition::damaged || tail.end) return;
  Result<replay::TraceReader> opened = replay::TraceReader::open(reader_.name(), tail.offset);
  // The file may have been replaced, or the reader reads memory.
  if (!opened || !is_same_recording(opened->setup(), setup())) return;
  const std::optional<std::uint64_t> recoverable = count_recoverable(*opened);
  if (!recoverable || *recoverable <= tail.ticks_intact) return;
  opened->rewind();
  before_damage_ = std::move(*opened);
  salvaged_from_ = tail.ticks_intact;
  tail_ = tail;
  tail_.ticks_intact = *recoverable;
  is_salvaging_ = true;
}

const replay::TraceReader::Item& ReaderSource::next_salvaged() {
  for (;;) {
    const replay::TraceReader::Item& item = before_damage_->next();
    if (std::holds_alternative<std::monostate>(item)) return end_;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr || record->tick < *salvaged_from_) continue;
    return record->tick < tail_.ticks_intact ? item : end_;
  }
}

bool ReaderSource::seek(std::uint64_t tick) {
  is_salvaging_ = false;
  return reader_.seek(tick);
}

void ReaderSource::rewind() {
  is_salvaging_ = false;
  reader_.rewind();
}

}  // namespace ticktrue::verifier
