// The result of diff_many as text and as JSON.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include "base/count_text.h"
#include "base/hash.h"
#include "base/plain_text.h"
#include "verifier/compare/many/diff_many.h"
#include "verifier/compare/many/trace_facts.h"
#include "verifier/report/fact_differences.h"
#include "verifier/report/json_parts.h"

namespace ticktrue::verifier {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t input_bytes_json_max = 256;

/// Indented lines, each with a label.
class ManyLines {
 public:
  void add(std::string label, const std::string& content) {
    if (label.size() < 7) label.resize(7, ' ');
    text_ += "  " + label + " " + plain_line(content) + "\n";
  }
  /// Adds finished lines.
  void add_text(const std::string& text) { text_ += text; }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

TraceGroup opened(const DiffManyReport& report) {
  TraceGroup traces;
  for (std::size_t i = 0; i < report.traces.size(); ++i)
    if (report.traces[i].error.empty()) traces.push_back(i);
  return traces;
}

/// "a, b 0.016.  c 0.033".
std::string values_text(const TraceFact& fact) {
  std::string text;
  for (const FactValue& value : fact.values)
    text += (text.empty() ? "" : ".  ") + labels_text(value.traces) + " " + value.value;
  return text;
}

/// "c (carol.ttr), e (eve.ttr)".
std::string files_text(const DiffManyReport& report, const TraceGroup& traces) {
  std::string text;
  for (const std::size_t trace : traces)
    text += (text.empty() ? "" : ", ") + trace_label(trace) + " (" + report.traces[trace].side.file + ")";
  return text;
}

/// Whether a blamed trace has another value of a setup fact.
bool is_of_other_setup(const DiffManyReport& report) {
  return std::any_of(report.setup.begin(), report.setup.end(), [&](const TraceFact& fact) {
    const TraceGroup& most = fact.values.front().traces;
    return std::any_of(report.blame->traces.begin(), report.blame->traces.end(),
                       [&](std::size_t trace) { return std::find(most.begin(), most.end(), trace) == most.end(); });
  });
}

std::string who_line(const DiffManyReport& report) {
  if (!report.blame) {
    const bool inputs_first = report.inputs && (!report.state || report.inputs->tick <= report.state->tick);
    return who_text(inputs_first ? report.inputs->who : report.state->who);
  }
  const Blame& blame = *report.blame;
  const bool by_inputs = blame.by == "inputs";
  return files_text(report, blame.traces) + ": other " + std::string(blame.by) + (by_inputs ? "" : "s") +
         " than the majority from tick " + std::to_string(blame.tick) + " on" +
         (by_inputs ? "" : ", with the same inputs up to there") +
         (is_of_other_setup(report) ? ", and another setup" : "");
}

std::string trace_line(const ManyTrace& trace) {
  std::string text = trace.side.file + "  ";
  const std::string place = trace.side.file + ": ";
  if (!trace.error.empty())
    return text + "not opened: " + trace.error.substr(trace.error.starts_with(place) ? place.size() : 0);
  text += count_text(trace.side.ticks.value_or(0), "tick");
  if (trace.first_tick > 0) text += " from tick " + std::to_string(trace.first_tick) + " on";
  if (!trace.is_compared) text += ", not compared";
  if (trace.inputs_from) text += ", other inputs from tick " + std::to_string(*trace.inputs_from) + " on";
  if (trace.state_from) text += ", other state from tick " + std::to_string(*trace.state_from) + " on";
  return text;
}

/// The end of a trace that did not end as planned.
std::string end_text(const ManyTrace& trace) {
  const replay::TraceTail& tail = trace.side.end.tail;
  if (tail.condition != replay::TraceCondition::complete)
    return tail.message + " (" + std::to_string(tail.ticks_intact) + " ticks are intact)";
  if (!tail.end || tail.end->reason == replay::EndReason::complete) return "";
  for (const replay::EndReasonInfo& info : replay::end_reasons)
    if (info.reason == tail.end->reason)
      return std::string(info.name) + ": " + std::string(info.summary) +
             (tail.end->note.empty() ? "" : " (" + tail.end->note + ")");
  return "";
}

void add_traces(const DiffManyReport& report, ManyLines& lines) {
  for (std::size_t i = 0; i < report.traces.size(); ++i) lines.add(trace_label(i), trace_line(report.traces[i]));
  for (std::size_t i = 0; i < report.traces.size(); ++i)
    if (const std::string text = end_text(report.traces[i]); report.traces[i].error.empty() && !text.empty())
      lines.add("end", trace_label(i) + " " + text);
}

/// Adds the builds that differ; if all are equal, one line.
void add_builds(const DiffManyReport& report, ManyLines& lines) {
  const auto add = [&](std::string label, auto text_of) {
    std::vector<std::string> values;
    for (const ManyTrace& trace : report.traces) values.push_back(text_of(trace.side.build));
    const TraceFact fact = fact_of("", opened(report), values);
    if (fact.values.size() == 1 && fact.values.front().value.empty()) return;
    for (const FactValue& value : fact.values)
      lines.add(std::exchange(label, ""), (fact.values.size() == 1 ? "all" : labels_text(value.traces)) + " " +
                                              (value.value.empty() ? "not known" : value.value));
  };
  add("builds", facts_line);
  add("program", program_line);
  const char* label = "differs";
  for (const TraceFact& fact : report.build)
    lines.add(std::exchange(label, ""),
              fact.what + ": " + values_text(fact) + (fact.changes_bits ? " (changes bits)" : ""));
}

std::string ticks_later(std::uint64_t tick, std::uint64_t from) {
  return "tick " + std::to_string(tick) + ", " + count_text(tick - from, "tick") + " later";
}

/// "c: an input is missing; c has it in tick 103, 3 ticks later".
std::string odd_inputs_text(const InputsFinding& inputs, const OddInputs& odd) {
  const std::string label = trace_label(odd.trace);
  std::string text = label + ": " + std::string(input_change_info(odd.change).text);
  if (odd.later) text += "; " + label + " has what the majority has here in " + ticks_later(*odd.later, inputs.tick);
  if (odd.before) text += "; the majority has what " + label + " has here in " + ticks_later(*odd.before, inputs.tick);
  return text;
}

void add_inputs(const DiffManyReport& report, ManyLines& lines) {
  if (!report.inputs) return;
  const InputsFinding& inputs = *report.inputs;
  lines.add("inputs", "differ first at tick " + std::to_string(inputs.tick) + ": " + who_text(inputs.who));
  const bool other_dt = std::any_of(inputs.groups.begin(), inputs.groups.end(), [&](const InputGroup& group) {
    return bits_of(group.dt) != bits_of(inputs.groups.front().dt);
  });
  for (const InputGroup& group : inputs.groups) {
    std::string label = labels_text(group.traces);
    if (other_dt) lines.add(std::exchange(label, ""), "dt " + lane_text(ScalarType::f64, bits_of(group.dt)) + " s");
    if (group.lines.empty()) lines.add(label, input_bytes_text(group.bytes));
    for (const std::string& input : split_lines(group.lines)) lines.add(std::exchange(label, ""), input);
  }
  for (const OddInputs& odd : inputs.odd) lines.add("", odd_inputs_text(inputs, odd));
}

void add_state(const DiffManyReport& report, ManyLines& lines) {
  if (!report.state) return;
  const StateFinding& state = *report.state;
  lines.add("state", std::string(state.is_start ? "differs before tick " : "differs first after tick ") +
                         std::to_string(state.tick) + ": " + who_text(state.who));
  const std::string reference = labels_text(state.reference);
  for (const OddState& odd : state.odd) {
    const std::string label = labels_text(odd.traces);
    if (state.odd.size() > 1) lines.add("between", reference + " and " + label);
    lines.add_text(divergence_text(odd.divergence, reference.c_str(), label.c_str()));
    const char* why = "why";
    for (const std::string& cause : cause_lines(odd.why)) lines.add(std::exchange(why, ""), cause);
  }
}

Json values_json(const TraceFact& fact) {
  Json values = Json::array();
  for (const FactValue& value : fact.values) values.push_back({{"value", value.value}, {"traces", value.traces}});
  return values;
}

Json number_or_null(const std::optional<std::uint64_t>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json trace_json(const ManyTrace& trace, std::size_t index) {
  Json object = {{"label", trace_label(index)},
                 {"file", trace.side.file},
                 {"error", trace.error.empty() ? Json(nullptr) : Json(trace.error)},
                 {"compared", trace.is_compared},
                 {"first_tick", trace.first_tick},
                 {"ticks", number_or_null(trace.side.ticks)},
                 {"inputs_from", number_or_null(trace.inputs_from)},
                 {"state_from", number_or_null(trace.state_from)}};
  object["end"] = trace.error.empty() ? end_json(trace.side.end) : Json(nullptr);
  object["build"] = facts_json(trace.side.build);
  return object;
}

Json inputs_json(const InputsFinding& inputs) {
  Json groups = Json::array();
  for (const InputGroup& group : inputs.groups)
    groups.push_back(
        {{"traces", group.traces},
         {"dt", hex64(bits_of(group.dt))},
         {"inputs", input_lines_json(group.lines)},
         {"size", group.bytes.size()},
         {"bytes", input_hex(ByteView(group.bytes).first(std::min(group.bytes.size(), input_bytes_json_max)))}});
  Json odd = Json::array();
  for (const OddInputs& one : inputs.odd)
    odd.push_back({{"trace", one.trace},
                   {"change", input_change_info(one.change).name},
                   {"missing", one.missing},
                   {"extra", one.extra},
                   {"later", number_or_null(one.later)},
                   {"before", number_or_null(one.before)}});
  return {{"tick", inputs.tick},
          {"majority", inputs.who.has_majority()},
          {"groups", std::move(groups)},
          {"odd", std::move(odd)}};
}

Json state_json(const StateFinding& state) {
  Json odd = Json::array();
  for (const OddState& one : state.odd) {
    Json object = {{"traces", one.traces}, {"divergence", divergence_json(one.divergence)}};
    if (!one.why.empty()) object["why"] = causes_json(one.why);
    odd.push_back(std::move(object));
  }
  return {{"tick", state.tick},         {"before_tick", state.is_start}, {"majority", state.who.has_majority()},
          {"groups", state.who.groups}, {"reference", state.reference},  {"others", std::move(odd)}};
}

}  // namespace

std::string diff_many_text(const DiffManyReport& report) {
  std::string text(diff_verdict_info(report.verdict).name);
  text += "  " + count_text(report.traces.size(), "trace") + "  " + count_text(report.ticks_compared, "tick") +
          " compared\n";
  ManyLines lines;
  if (!report.reason.empty()) lines.add("reason", report.reason);
  if (report.inputs || report.state) lines.add("who", who_line(report));
  add_traces(report, lines);
  for (const TraceFact& fact : report.setup) lines.add("setup", fact.what + ": " + values_text(fact));
  if (report.verdict != DiffVerdict::equal) add_builds(report, lines);
  add_inputs(report, lines);
  add_state(report, lines);
  for (const std::string& contradiction : report.contradictions) lines.add("record", contradiction);
  for (const std::string& note : report.notes) lines.add("note", note);
  for (const std::string& command : report.again) lines.add("again", command);
  return text + lines.take();
}

std::string diff_many_json(const DiffManyReport& report) {
  Json object = {{"schema", "ticktrue.diff_many/2"},
                 {"verdict", diff_verdict_info(report.verdict).name},
                 {"reason", report.reason},
                 {"ticks_compared", report.ticks_compared},
                 {"checkpoints_compared", report.checkpoints_compared},
                 {"compared", compared_json(report.compared)}};
  object["blame"] = nullptr;
  if (report.blame)
    object["blame"] = {{"traces", report.blame->traces}, {"by", report.blame->by}, {"tick", report.blame->tick}};
  object["traces"] = Json::array();
  for (std::size_t i = 0; i < report.traces.size(); ++i) object["traces"].push_back(trace_json(report.traces[i], i));
  object["setup"] = Json::array();
  for (const TraceFact& fact : report.setup)
    object["setup"].push_back({{"what", fact.what}, {"values", values_json(fact)}});
  object["build_differences"] = Json::array();
  for (const TraceFact& fact : report.build)
    object["build_differences"].push_back(
        {{"what", fact.what}, {"changes_bits", fact.changes_bits}, {"values", values_json(fact)}});
  object["inputs"] = report.inputs ? inputs_json(*report.inputs) : Json(nullptr);
  object["state"] = report.state ? state_json(*report.state) : Json(nullptr);
  object["contradictions"] = report.contradictions;
  object["notes"] = report.notes;
  object["again"] = report.again;
  return plain_text(object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace ticktrue::verifier
