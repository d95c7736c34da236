// The inputs of `run` and `record`: checked before anything begins, and the place of what is refused later.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/result.h"
#include "base/simulation.h"
#include "engine/scene.h"
#include "replay/recorder.h"
#include "verifier/input_source.h"

namespace ticktrue::cli {

struct SessionInputs {
  std::unique_ptr<replay::InputSource> source;
  const verifier::JsonLinesInputs* lines = nullptr;  // the same, where there are any
  std::uint64_t ticks_expected = 0;                  // for the progress bar; 0: not known
};

/// `path` empty: no inputs; "-": standard input. A file is read and checked as a whole first. Without `tick_count`
/// the inputs must say when the session ends. `scene` must outlive the source.
/// Errors: usage (neither tick count nor end), io, invalid_input, limit.
Result<SessionInputs> open_session_inputs(const engine::Scene& scene, const std::string& path,
                                          std::optional<std::uint64_t> tick_count);

/// Adds "file:line" to an error of a tick that the simulation refused; other errors stay as they are.
Error with_input_place(const Error& error, const SessionInputs& inputs, const Simulation& simulation);

}  // namespace ticktrue::cli
