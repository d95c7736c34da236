// Inputs of a session whose dt comes from a clock and the frames of a host.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "engine/clock/step_control.h"
#include "engine/clock/tick_clock.h"
#include "replay/recorder.h"
#include "tool/session/host_frames.h"

namespace ticktrue::verifier {

/// Returns the inputs of another source, stamped by tick as they are, with the dt of the scene's clock. The session
/// also ends where the host's frames do.
class ClockedInputs : public replay::InputSource {
 public:
  /// `engine` is the one that the session runs on; it must outlive this.
  ClockedInputs(engine::Engine& engine, std::unique_ptr<replay::InputSource> inputs,
                std::unique_ptr<HostFrames> frames);

  Result<std::optional<TickInput>> next(std::uint64_t tick) override;
  bool repeatable() const override { return inputs_->repeatable() && frames_->repeatable(); }
  bool tick_failed() const override { return tick_failed_; }

  const engine::ClockReport& report() const { return clock_.report; }
  /// Whether next() failed on the frames: then the message names the place already.
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

}  // namespace ticktrue::verifier
