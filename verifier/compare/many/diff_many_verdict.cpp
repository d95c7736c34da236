// Decides what the comparison of several traces means: blame, causes, verdict, commands.
// SPDX-License-Identifier: MIT
#include "verifier/compare/many/diff_many_verdict.h"

#include <algorithm>
#include <utility>

#include "verifier/compare/setup_difference.h"
#include "verifier/compare/trace_side.h"

namespace ticktrue::verifier {
namespace {

using replay::TraceCondition;
using replay::TraceSetup;
using replay::TraceTail;

class ManyConclusion {
 public:
  ManyConclusion(std::span<const OpenedTrace> traces, const TraceGroup& comparable, const DiffOptions& options,
                 DiffManyReport& report)
      : traces_(traces), comparable_(comparable), options_(options), report_(report) {}

  void run() {
    find_blame();
    if (report_.state) find_causes();
    judge();
    add_again();
  }

 private:
  const TraceSetup& setup_of(std::size_t trace) const { return traces_[trace].reader->setup(); }
  const TraceTail& tail_of(std::size_t trace) const { return report_.traces[trace].side.end.tail; }
  std::uint64_t end_tick(std::size_t trace) const {
    return report_.traces[trace].first_tick + report_.traces[trace].side.ticks.value_or(0);
  }

  /// Inputs of a tick come before its state.
  void find_blame() {
    const auto& inputs = report_.inputs;
    const auto& state = report_.state;
    const bool inputs_first =
        inputs && (!state || inputs->tick < state->tick || (inputs->tick == state->tick && !state->is_start));
    if (!inputs && !state) return;
    const TraceGroups& who = inputs_first ? inputs->who : state->who;
    if (!who.has_majority()) return;
    report_.blame = Blame{who.odd(), inputs_first ? "inputs" : "state", inputs_first ? inputs->tick : state->tick};
  }

  /// Other inputs and another setup explain any difference. A cause must apply against each trace of the reference.
  void find_causes() {
    StateFinding& finding = *report_.state;
    for (OddState& odd : finding.odd) {
      if (has_other_inputs(odd.traces) || has_other_setup(odd.traces)) continue;
      bool is_first = true;
      for (const std::size_t trace : finding.reference) {
        Symptoms symptoms;
        symptoms.simulation = report_.simulation;
        symptoms.divergence = &odd.divergence;
        symptoms.build_a = &report_.traces[trace].side.build;
        symptoms.build_b = &report_.traces[odd.traces.front()].side.build;
        const std::vector<Cause> causes = likely_causes(symptoms);
        if (std::exchange(is_first, false)) odd.why = causes;
        std::erase_if(odd.why,
                      [&](Cause cause) { return std::find(causes.begin(), causes.end(), cause) == causes.end(); });
      }
    }
  }

  bool has_other_inputs(const TraceGroup& group) const {
    if (!report_.inputs || report_.inputs->tick > report_.state->tick) return false;
    const auto group_of = [&](std::size_t trace) -> const InputGroup* {
      for (const InputGroup& one : report_.inputs->groups)
        if (std::find(one.traces.begin(), one.traces.end(), trace) != one.traces.end()) return &one;
      return nullptr;
    };
    return std::any_of(group.begin(), group.end(), [&](std::size_t trace) {
      return group_of(trace) != group_of(report_.state->reference.front());
    });
  }

  bool has_other_setup(const TraceGroup& group) const {
    std::vector<SetupDifference> differences;
    for (const std::size_t trace : group)
      compare_setups(setup_of(report_.state->reference.front()), setup_of(trace), differences);
    return !differences.empty();
  }

  /// Whether the setups of compared traces differ.
  bool setups_differ() const {
    std::vector<SetupDifference> differences;
    for (const std::size_t trace : comparable_)
      compare_setups(setup_of(comparable_.front()), setup_of(trace), differences);
    return !differences.empty();
  }

  bool any_ends(TraceCondition condition) const {
    return std::any_of(comparable_.begin(), comparable_.end(),
                       [&](std::size_t trace) { return tail_of(trace).condition == condition; });
  }

  /// Complete traces that end before the last one. `was_stopped`: traces whose recorders were stopped, or the other
  /// ones.
  TraceGroup shorter(bool was_stopped) const {
    std::uint64_t end = 0;
    for (const std::size_t trace : comparable_) end = std::max(end, end_tick(trace));
    TraceGroup found;
    for (const std::size_t trace : comparable_)
      if (tail_of(trace).condition == TraceCondition::complete && end_tick(trace) < end &&
          ends_early(tail_of(trace)) == was_stopped)
        found.push_back(trace);
    return found;
  }

  std::string not_compared_text() const {
    TraceGroup others;
    for (std::size_t i = 0; i < traces_.size(); ++i)
      if (traces_[i].reader != nullptr && !report_.traces[i].is_compared) others.push_back(i);
    if (others.empty()) return "";
    return labels_text(others) + " cannot be compared with " + labels_text(comparable_);
  }

  /// What differs if the states do not.
  std::string what_differs(bool setups) const {
    if (report_.inputs) return setups ? "the setups and the inputs differ" : "the inputs differ";
    return setups ? "the setups differ" : "a record contradicts itself";
  }

  void judge() {
    const auto is = [&](DiffVerdict verdict, std::string reason) {
      report_.verdict = verdict;
      report_.reason = std::move(reason);
    };
    const bool setups = setups_differ();
    const std::string not_compared = not_compared_text();
    const TraceGroup ended = shorter(false), stopped = shorter(true);
    if (report_.state || report_.inputs || setups || !report_.contradictions.empty())
      is(DiffVerdict::different,
         report_.state || report_.ticks_compared == 0 ? "" : "states equal; " + what_differs(setups));
    else if (!ended.empty())
      is(DiffVerdict::different, "lengths: " + labels_text(ended) + " ended first; equal as far as they go");
    else if (any_ends(TraceCondition::damaged))
      is(DiffVerdict::damaged, "equal as far as all are intact");
    else if (!not_compared.empty())
      is(DiffVerdict::not_comparable, not_compared);
    else if (!stopped.empty())
      is(DiffVerdict::incomplete, "equal as far as they go; " + labels_text(stopped) + " ended early");
    else if (any_ends(TraceCondition::truncated))
      is(DiffVerdict::incomplete, "equal as far as they go");
    else if (report_.ticks_compared == 0)
      is(DiffVerdict::incomplete, "no tick was compared");
  }

  /// Adds commands that show the values, one for each recording build.
  void add_again() {
    if (!report_.state) return;
    const StateFinding& finding = *report_.state;
    if (std::none_of(finding.odd.begin(), finding.odd.end(),
                     [](const OddState& odd) { return !odd.divergence.has_values(); }))
      return;
    const std::string number = std::to_string(finding.tick);
    if (options_.tool.empty()) {
      report_.again.push_back("record all again with detail full:" + number + ".." + number +
                              ", each with the program that recorded it, and compare those");
      return;
    }
    std::string compare = options_.tool + " diff";
    for (const TraceGroup& group : finding.who.groups) {
      const std::string& file = report_.traces[group.front()].side.file;
      const std::string out = "full_" + trace_label(group.front()) + ".ttr";
      report_.again.push_back(options_.tool + " record " + shell_word(file) + " --ticks " +
                              std::to_string(finding.tick + 1) + " --detail full:" + number + ".." + number + " -o " +
                              out);
      compare += " " + out;
    }
    report_.again.push_back(compare + ", each recorded by the build of its trace");
  }

  std::span<const OpenedTrace> traces_;
  const TraceGroup& comparable_;
  const DiffOptions& options_;
  DiffManyReport& report_;
};

}  // namespace

void conclude_diff(std::span<const OpenedTrace> traces, const TraceGroup& comparable, const DiffOptions& options,
                   DiffManyReport& report) {
  ManyConclusion(traces, comparable, options, report).run();
}

}  // namespace ticktrue::verifier
