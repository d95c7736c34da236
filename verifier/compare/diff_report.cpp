// The result of diff as text and as JSON.
// SPDX-License-Identifier: MIT
#include <cstdio>
#include <utility>

#include "base/hash.h"
#include "base/plain_text.h"
#include "verifier/compare/diff.h"
#include "verifier/report/json_parts.h"

namespace ticktrue::verifier {
namespace {

using Json = nlohmann::ordered_json;

std::string seconds_text(double value) {
  return lane_text(ScalarType::f64, bits_of(value));
}

Json side_json(const DiffSide& side) {
  return {{"file", side.file},
          {"ticks", side.ticks ? Json(*side.ticks) : Json(nullptr)},
          {"end", end_json(side.end)},
          {"build", facts_json(side.build)}};
}

/// Likely causes. None if inputs or setup differ: these explain any difference.
std::vector<Cause> causes_of(const DiffReport& report) {
  if (report.inputs || !report.setup.empty()) return {};
  Symptoms symptoms;
  symptoms.simulation = report.simulation;
  symptoms.divergence = report.divergence ? &*report.divergence : nullptr;
  symptoms.build_a = &report.a.build;
  symptoms.build_b = &report.b.build;
  return likely_causes(symptoms);
}

}  // namespace

std::string diff_text(const DiffReport& report) {
  std::string text(diff_verdict_info(report.verdict).name);
  text += "  " + plain_line(report.a.file) + "  " + plain_line(report.b.file) + "  ";
  if (report.divergence) {
    char seconds[40];
    std::snprintf(seconds, sizeof seconds, "%.3f s", report.divergence->time_s);
    text += "tick " + std::to_string(report.divergence->tick) + " of " + std::to_string(report.ticks_compared) + " (" +
            seconds + ")\n";
  } else {
    text += std::to_string(report.ticks_compared) + " ticks compared\n";
  }
  const auto line = [&](std::string label, const std::string& content) {
    label.resize(7, ' ');
    text += "  " + label + " " + plain_line(content) + "\n";
  };
  if (!report.reason.empty()) line("reason", report.reason);
  for (const SetupDifference& difference : report.setup)
    line("setup", difference.what + ": " + difference.a + ".  other: " + difference.b);
  if (report.divergence) text += divergence_text(*report.divergence, "a", "b");
  if (report.inputs) {
    const InputDifference& inputs = *report.inputs;
    line("inputs", "differ first at tick " + std::to_string(inputs.tick));
    if (bits_of(inputs.dt_a) != bits_of(inputs.dt_b))
      line("dt", "a " + seconds_text(inputs.dt_a) + " s.  b " + seconds_text(inputs.dt_b) + " s");
    for (const auto& [label, lines] :
         {std::pair<const char*, const std::string*>{"a", &inputs.inputs_a}, {"b", &inputs.inputs_b}})
      for (const std::string& input : split_lines(*lines)) line(label, input);
  }
  const char* why = "why";
  for (const std::string& cause : cause_lines(causes_of(report))) line(std::exchange(why, ""), cause);
  for (const auto& [label, side] : {std::pair<const char*, const DiffSide*>{"a", &report.a}, {"b", &report.b}})
    if (side->end.tail.condition != replay::TraceCondition::complete)
      line(label, side->end.tail.message + " (" + std::to_string(side->end.tail.ticks_intact) + " ticks are intact)");
  for (const std::string& note : report.notes) line("note", note);
  if (report.verdict != DiffVerdict::equal) {
    line("builds", "a " + facts_line(report.a.build));
    line("", "b " + facts_line(report.b.build));
    const std::string program_a = program_line(report.a.build);
    const std::string program_b = program_line(report.b.build);
    if (!program_a.empty() || !program_b.empty()) {
      line("program", "a " + (program_a.empty() ? std::string("not known") : program_a));
      line("", "b " + (program_b.empty() ? std::string("not known") : program_b));
    }
    const char* label = "differs";
    for (const FactDifference& difference : fact_differences(report.a.build, report.b.build)) {
      line(label, difference_line(difference, "a", "b"));
      label = "";
    }
  }
  for (const std::string& command : report.again) line("again", command);
  return text;
}

std::string diff_json(const DiffReport& report) {
  Json object = {{"schema", "ticktrue.diff/2"},
                 {"verdict", diff_verdict_info(report.verdict).name},
                 {"reason", report.reason},
                 {"ticks_compared", report.ticks_compared},
                 {"checkpoints_compared", report.checkpoints_compared},
                 {"compared", compared_json(report.compared)},
                 {"a", side_json(report.a)},
                 {"b", side_json(report.b)}};
  Json setup = Json::array();
  for (const SetupDifference& difference : report.setup)
    setup.push_back({{"what", difference.what}, {"a", difference.a}, {"b", difference.b}});
  object["setup"] = std::move(setup);
  object["inputs"] = nullptr;
  if (report.inputs)
    object["inputs"] = {{"tick", report.inputs->tick},
                        {"dt_a", hex64(bits_of(report.inputs->dt_a))},
                        {"dt_b", hex64(bits_of(report.inputs->dt_b))},
                        {"inputs_a", input_lines_json(report.inputs->inputs_a)},
                        {"inputs_b", input_lines_json(report.inputs->inputs_b)}};
  const std::vector<FactDifference> differences = fact_differences(report.a.build, report.b.build);
  if (!differences.empty()) object["build_differences"] = differences_json(differences, "a", "b");
  object["divergence"] = report.divergence ? divergence_json(*report.divergence) : Json(nullptr);
  if (Json why = causes_json(causes_of(report)); !why.empty()) object["why"] = std::move(why);
  object["notes"] = report.notes;
  object["again"] = report.again;
  return plain_text(object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace ticktrue::verifier
