// Reads the inputs of a trace tick by tick.
// SPDX-License-Identifier: MIT
#include "verifier/verify/trace_inputs.h"

namespace ticktrue::verifier {

Result<std::optional<TickInput>> TraceInputs::next(std::uint64_t) {
  for (;;) {
    const replay::TraceReader::Item& item = reader_.next();
    if (const auto* record = std::get_if<replay::TickRecord>(&item))
      return std::optional<TickInput>(TickInput{record->dt, record->inputs});
    if (!std::holds_alternative<std::monostate>(item)) continue;
    const replay::TraceTail& tail = reader_.tail();
    if (tail.condition != replay::TraceCondition::damaged) return std::optional<TickInput>();
    return Error{ErrorCode::corrupt, reader_.name() + ": " + tail.message,
                 "ticks before " + std::to_string(tail.ticks_intact) + " are intact: --ticks " +
                     std::to_string(tail.ticks_intact)};
  }
}

}  // namespace ticktrue::verifier
