// The checks before the first tick.
// SPDX-License-Identifier: MIT
#include "verifier/verify/comparable.h"

#include <algorithm>
#include <span>
#include <string>

#include "base/float_behaviour.h"
#include "verifier/locate/schema_difference.h"

namespace ticktrue::verifier {
namespace {

/// Why the two schemas cannot be compared; empty: they can.
std::string schema_difference(const StateSchema& recorded, const StateSchema& here) {
  const auto difference = first_schema_difference(recorded, here, Ranges::inside);
  if (!difference) return "";
  return schema_text(*difference);
}

std::string stage_difference(std::span<const std::string> recorded, std::span<const std::string> here) {
  if (std::equal(recorded.begin(), recorded.end(), here.begin(), here.end())) return "";
  const auto list = [](std::span<const std::string> names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
  };
  return "stages: recorded " + list(recorded) + "; here " + list(here);
}

bool tolerates(const WalkContext& context, const std::string& difference, Findings& findings) {
  if (context.options.mode == VerifyMode::twice) {
    findings.warnings.push_back(difference);
    return true;
  }
  findings.decide(Verdict::not_comparable, difference, "build the version that recorded it, or record again");
  return false;
}

}  // namespace

bool check_comparable(const WalkContext& context, Findings& findings) {
  const auto refuse = [&](const std::string& reason, const std::string& hint = "") {
    findings.decide(Verdict::not_comparable, reason, hint);
    return false;
  };
  const replay::TraceSetup& setup = context.setup;
  if (const Status floats = check_float_behaviour(); !floats)
    return refuse(floats.error().message, floats.error().hint);
  const SimulationInfo* info = context.options.simulation;
  if (info == nullptr || info->name != setup.simulation)
    return refuse("simulation " + setup.simulation + " is not available in this build");
  if (context.options.mode == VerifyMode::threads && !info->make_on_threads)
    return refuse("threads: " + setup.simulation + " of this build has one thread: there is nothing to compare",
                  "--mode replay compares with the recording");
  if (info->physics_version != setup.physics_version &&
      !tolerates(context,
                 "physics version: recorded with " + std::to_string(setup.physics_version) + ", here " +
                     std::to_string(info->physics_version),
                 findings))
    return false;
  const auto simulation = make_simulation(context, findings);
  if (!simulation) return false;
  for (const std::string& text : {schema_difference(setup.schema, *simulation->state().schema),
                                  stage_difference(setup.stages, simulation->stage_names())})
    if (!text.empty() && !tolerates(context, text, findings)) return false;
  return true;
}

}  // namespace ticktrue::verifier
