// The inputs and dt of a trace, to run its session again.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "replay/recorder.h"
#include "replay/trace_reader.h"

namespace ticktrue::verifier {

/// Returns the inputs and the dt of every tick as recorded.
class TraceInputs : public replay::InputSource {
 public:
  explicit TraceInputs(replay::TraceReader reader) : reader_(std::move(reader)) {}
  /// Errors: corrupt (the trace is damaged before its end).
  Result<std::optional<TickInput>> next(std::uint64_t tick) override;
  bool repeatable() const override { return true; }

 private:
  replay::TraceReader reader_;
};

}  // namespace ticktrue::verifier
