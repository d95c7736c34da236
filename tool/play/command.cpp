// `ticktrue play`: interactive recording in a scene, or playback of a trace.
// SPDX-License-Identifier: MIT
#include "tool/play/display.h"
#include "tool/session/session_inputs.h"

namespace ticktrue::cli {

int run_play(const PlayOptions& options) {
  catch_stop_signals();
  const bool is_trace = is_trace_argument(options.what);
  const auto refuse = [](const std::string& what, const std::string& hint) {
    return fail_usage(Error{ErrorCode::usage, what, hint});
  };
  if (is_trace && !options.output.empty())
    return refuse("--output: found a trace to play, expected a scene: playing a trace records nothing", "");
  if (!is_trace && !options.against.empty())
    return refuse("--against: found a scene to play, expected a trace", "ticktrue play ONE.ttr --against OTHER.ttr");
  if (!is_trace && options.from != 0)
    return refuse("--from: found a scene to play, expected a trace: a scene begins at its start", "");
  return is_trace ? play::play_trace_file(options) : play::play_in_scene(options);
}

}  // namespace ticktrue::cli
