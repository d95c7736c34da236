// Opening the inputs of a session.
// SPDX-License-Identifier: MIT
#include "verifier/cli/session_inputs.h"

#include <algorithm>

#include "verifier/cli/cli.h"
#include "verifier/cli/progress.h"

namespace ticktrue::cli {

Result<SessionInputs> open_session_inputs(const engine::Scene& scene, const std::string& path,
                                          std::optional<std::uint64_t> tick_count) {
  SessionInputs session;
  session.ticks_expected = tick_count.value_or(0);
  if (path.empty()) {
    if (!tick_count)
      return Error{ErrorCode::usage, "--ticks: found neither --ticks nor --inputs, expected one that ends the session",
                   "give --ticks N, or --inputs FILE with an `end` input"};
    session.source = std::make_unique<replay::NoInputs>(scene.settings.dt);
    return session;
  }

  verifier::JsonLinesInputs::Options options;
  options.needs_end = !tick_count;
  options.stop = stop_requested;
  auto source = verifier::JsonLinesInputs::open(scene, path, options);
  if (!source) return source.error();
  session.lines = source->get();
  session.source = std::move(*source);
  if (!session.source->repeatable()) return session;

  Progress progress("check " + path, 0, "bytes");
  const auto summary = verifier::check_inputs(
      scene, path, [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); });
  progress.finish();
  if (!summary) return summary.error();
  if (!summary->end_tick && !tick_count)
    return Error{
        ErrorCode::usage, path + ": found neither --ticks nor an `end` input, expected one that ends the session",
        "give --ticks N, or append {\"tick\":" + std::to_string(summary->last_tick + 1) + ",\"kind\":\"end\"}"};
  if (summary->end_tick) session.ticks_expected = std::min(tick_count.value_or(*summary->end_tick), *summary->end_tick);
  if (tick_count && summary->count > 0 && summary->last_tick >= *tick_count)
    print_note(path + ": inputs from tick " + std::to_string(*tick_count) + " on are not used (--ticks " +
               std::to_string(*tick_count) + ")");
  return session;
}

Error with_input_place(const Error& error, const SessionInputs& inputs, const Simulation& simulation) {
  // The source's own errors begin with the place.
  if (error.code != ErrorCode::invalid_input || inputs.lines == nullptr || inputs.lines->gave_error()) return error;
  return Error{error.code, inputs.lines->place_of_refused(simulation) + ": " + error.message, error.hint};
}

}  // namespace ticktrue::cli
