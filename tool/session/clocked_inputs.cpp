// Combines the inputs of a session with the dt of a clock.
// SPDX-License-Identifier: MIT
#include "tool/session/clocked_inputs.h"

#include "base/limits.h"

namespace ticktrue::tool {

ClockedInputs::ClockedInputs(engine::Engine& engine, std::unique_ptr<replay::InputSource> inputs,
                             std::unique_ptr<HostFrames> frames)
    : engine_(engine),
      inputs_(std::move(inputs)),
      frames_(std::move(frames)),
      clock_(engine.scene().settings.clock, engine.scene().settings.dt),
      control_(engine),
      adaptive_(engine.scene().settings.clock.kind == engine::ClockKind::adaptive) {}

Result<std::optional<double>> ClockedInputs::next_dt() {
  while (true) {
    double wanted_s = 0;
    if (adaptive_ && clock_.due_s() >= limits::dt_min_s) {
      const Result<double> chosen = control_.choose(engine_, clock_.due_s(), clock_.report);
      tick_failed_ = !chosen;
      if (!chosen) return chosen.error();
      wanted_s = *chosen;
    }
    if (const std::optional<double> dt = clock_.next_tick(wanted_s)) return dt;
    const Result<std::optional<double>> frame = frames_->next();
    frames_failed_ = !frame;
    if (!frame) return frame.error();
    if (!*frame) return std::optional<double>();
    clock_.add_frame(**frame);
  }
}

Result<std::optional<TickInput>> ClockedInputs::next(std::uint64_t tick) {
  Result<std::optional<TickInput>> input = inputs_->next(tick);
  if (!input || !*input) return input;
  const Result<std::optional<double>> dt = next_dt();
  if (!dt) return dt.error();
  if (!*dt) return std::optional<TickInput>();
  return std::optional<TickInput>(TickInput{**dt, (*input)->inputs});
}

}  // namespace ticktrue::tool
