// Inputs of a session whose dt comes from a clock and the frames of a host.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "engine/clock/step_control.h"
#include "engine/clock/tick_clock.h"
#include "replay/recorder.h"
#include "tool/session/host_frames.h"

namespace ticktrue::tool {

/// Returns the inputs of another source with the dt of the scene's clock. The tick of each input is unchanged. The
/// session also ends when the host has no more frames.
class ClockedInputs : public replay::InputSource {
 public:
  /// `engine`: the engine of the session; must outlive this object.
  ClockedInputs(engine::Engine& engine, std::unique_ptr<replay::InputSource> inputs,
                std::unique_ptr<HostFrames> frames);

  Result<std::optional<TickInput>> next(std::uint64_t tick) override;
  bool repeatable() const override { return inputs_->repeatable() && frames_->repeatable(); }
  bool tick_failed() const override { return tick_failed_; }

  const engine::ClockReport& report() const { return clock_.report; }
  /// Whether next() failed because of the frames. The message then already names the place.
  bool frames_failed() const { return frames_failed_; }

 private:
  Result<std::optional<double>> next_dt();

  engine::Engine& engine_;
  std::unique_ptr<replay::InputSource> inputs_;
  std::unique_ptr<HostFrames> frames_;
  engine::TickClock clock_;
  engine::StepControl control_;
  bool adaptive_;
  bool frames_failed_ = false;
  bool tick_failed_ = false;
};

}  // namespace ticktrue::tool
