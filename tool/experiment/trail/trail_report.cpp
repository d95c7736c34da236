// The text begins with the differing call. Facts about its tick follow.
// SPDX-License-Identifier: MIT
#include "tool/experiment/trail/trail_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/count_text.h"
#include "base/hash.h"
#include "base/plain_text.h"
#include "base/state/state_view.h"
#include "verifier/report/exit_codes.h"

namespace ticktrue::trail {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t callers_shown_max = 8;
constexpr std::size_t frames_shown_max = 8;

class Lines {
 public:
  void add(std::string label, const std::string& content) {
    if (label.size() < 7) label.resize(7, ' ');
    text_ += "  " + label + " " + plain_line(content) + "\n";
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

std::string there_name(const TrailSubject& subject) {
  return subject.against.empty() ? "recorded" : "there";
}

/// "0x1b (27)"; for a result of libm, the float.
std::string value_text(const MarkPlace& mark) {
  const bool is_libm = mark.name.compare(0, 5, "libm.") == 0;
  const ScalarType type = !is_libm ? ScalarType::u64 : mark.name.back() == 'f' ? ScalarType::f32 : ScalarType::f64;
  return lane_hex(type, mark.value) + " (" + lane_text(type, mark.value) + ")";
}

/// "7 more calls of rand from Shuffle: 12 here, 5 there"
std::string caller_text(const CallerCount& count, const std::string& there) {
  const std::string of = " of " + count.name + (count.caller.empty() ? "" : " from " + count.caller);
  if (!count.there) return count_text(count.here, "call") + of + " here";
  const std::uint64_t before = *count.there;
  const bool is_more = count.here > before;
  const std::uint64_t by = is_more ? count.here - before : before - count.here;
  return std::to_string(by) + (is_more ? " more call" : " fewer call") + (by == 1 ? "" : "s") + of + ": " +
         std::to_string(count.here) + " here, " + std::to_string(before) + " " + there;
}

std::string first_text(const FirstMark& first, const std::string& there_name) {
  const std::string where = "mark " + std::to_string(first.index + 1) + " of the tick: ";
  switch (first.kind) {
    case FirstKind::extra:
      return where + first.here->name + " " + value_text(*first.here) + " is extra here; " +
             (first.there ? there_name + " comes " + first.there->name : there_name + " comes no more");
    case FirstKind::missing:
      return where + first.there->name + " " + value_text(*first.there) + " is missing here; " +
             (first.here ? "here comes " + first.here->name : "here comes no more");
    default:
      return where + "here " + first.here->name + " " + value_text(*first.here) + ", " + there_name + " " +
             first.there->name + " " + value_text(*first.there);
  }
}

void add_stack(const std::string& label, const std::optional<MarkPlace>& mark, Lines& lines) {
  if (!mark) return;
  for (std::size_t i = 0; i < std::min(mark->stack.size(), frames_shown_max); ++i) {
    lines.add(i == 0 ? label : "", mark->stack[i].text());
    if (mark->stack[i].function == "main") return;
  }
}

std::string outcome_line(const shake::Outcome& outcome) {
  if (outcome.kind == shake::OutcomeKind::match) return "match, as recorded";
  return std::string(shake::outcome_name(outcome.kind)) + "  " + shake::outcome_text(outcome);
}

void add_difference(const TrailReport& report, const TrailSubject& subject, Lines& lines) {
  const std::string there = there_name(subject);
  lines.add("marks", verifier::marks_text(*report.marks, there.c_str()));
  const std::vector<CallerCount>& callers = report.lists.callers;
  for (std::size_t i = 0; i < std::min(callers.size(), callers_shown_max); ++i)
    lines.add(i == 0 ? "calls" : "", caller_text(callers[i], there));
  if (callers.size() > callers_shown_max)
    lines.add("", "and " + count_text(callers.size() - callers_shown_max, "more line") + " (--json has all)");
  if (report.lists.first) {
    lines.add("first", first_text(*report.lists.first, there));
    add_stack("here", report.lists.first->here, lines);
    add_stack(there == "there" ? there : "", report.lists.first->there, lines);
  }
  if (!report.has_list_there && report.verdict == TrailVerdict::differ)
    lines.add("note", "the trace has counts and hashes of tick " + std::to_string(report.marks->tick) +
                          " alone: which of these calls is the first that differs, and where the recorded ones came "
                          "from, is not known");
}

std::string headline(const TrailReport& report, const TrailSubject& subject) {
  const std::string file = "  " + plain_line(subject.trace) + "  ";
  if (report.verdict == TrailVerdict::same)
    return "marks are the same" + file + count_text(report.tick_count, "tick") + " compared";
  std::string text = "marks differ" + file + "tick " + std::to_string(report.marks->tick);
  if (report.verdict == TrailVerdict::not_reproducible)
    text = "not_reproducible" + file + "tick " + std::to_string(report.marks->tick);
  if (report.here.kind != shake::OutcomeKind::diverged) return text;
  if (report.here.tick == report.marks->tick) return text + ", in which the state diverges";
  return text + ", " + count_text(report.here.tick - report.marks->tick, "tick") + " before the state diverges";
}

std::vector<std::string> next_steps(const TrailReport& report, const TrailSubject& subject) {
  if (report.verdict == TrailVerdict::not_reproducible) {
    std::vector<std::string> words = subject.words;
    if (report.is_against_lost) words.front() = subject.against;
    return {shake::shake_command(subject.trace, words) + "  # tells what reaches its state from outside"};
  }
  if (report.verdict == TrailVerdict::same && report.here.kind == shake::OutcomeKind::diverged)
    return {"mark more of what tick " + std::to_string(report.here.tick) + " does" +
            (subject.calls.empty() ? ", or let calls be marked: --calls random,libm" : "")};
  if (report.verdict == TrailVerdict::differ && !report.has_list_there)
    return {"name the build that recorded the trace by --against: then both lists are compared, with stacks"};
  return {};
}

Json place_json(const std::optional<MarkPlace>& mark) {
  if (!mark) return nullptr;
  Json stack = Json::array();
  for (const shake::CallSite& site : mark->stack)
    stack.push_back({{"function", site.function}, {"file", site.file}, {"line", site.line}, {"module", site.module}});
  return {{"name", mark->name}, {"value", hex64(mark->value)}, {"stack", std::move(stack)}};
}

Json outcome_json(const shake::Outcome& outcome) {
  Json object = {{"outcome", shake::outcome_name(outcome.kind)}, {"reason", outcome.reason}};
  object["diverged_at"] = outcome.kind == shake::OutcomeKind::diverged ? Json(outcome.tick) : Json(nullptr);
  return object;
}

}  // namespace

int exit_code(const TrailReport& report) {
  if (report.verdict == TrailVerdict::not_reproducible) return verifier::exit_not_reproducible;
  const bool is_quiet = report.verdict == TrailVerdict::same && report.here.kind == shake::OutcomeKind::match;
  return is_quiet ? verifier::exit_ok : verifier::exit_finding;
}

std::string trail_text(const TrailReport& report, const TrailSubject& subject) {
  Lines lines;
  if (report.marks) add_difference(report, subject, lines);
  lines.add("run", "here " + outcome_line(report.here));
  if (report.there) lines.add("", "there " + outcome_line(*report.there));
  for (const std::string& note : report.notes) lines.add("note", note);
  for (const std::string& step : next_steps(report, subject)) lines.add("next", step);
  return headline(report, subject) + "\n" + lines.take();
}

std::string trail_json(const TrailReport& report, const TrailSubject& subject) {
  Json object = {{"schema", "ticktrue.trail/1"},
                 {"file", subject.trace},
                 {"program", subject.words},
                 {"against", subject.against.empty() ? Json(nullptr) : Json(subject.against)},
                 {"verdict", name_of(report.verdict)},
                 {"ticks_compared", report.tick_count},
                 {"here", outcome_json(report.here)},
                 {"there", report.there ? outcome_json(*report.there) : Json(nullptr)},
                 {"tick", report.marks ? Json(report.marks->tick) : Json(nullptr)}};
  object["names"] = Json::array();
  if (report.marks)
    for (const verifier::NameDifference& name : report.marks->names)
      object["names"].push_back({{"name", name.name}, {"there", name.expected}, {"here", name.got}});
  object["has_list_there"] = report.has_list_there;
  object["calls"] = Json::array();
  for (const CallerCount& count : report.lists.callers)
    object["calls"].push_back({{"name", count.name},
                               {"function", count.caller},
                               {"here", count.here},
                               {"there", count.there ? Json(*count.there) : Json(nullptr)}});
  object["first"] = nullptr;
  if (const std::optional<FirstMark>& first = report.lists.first)
    object["first"] = {{"kind", name_of(first->kind)},
                       {"index", first->index},
                       {"here", place_json(first->here)},
                       {"there", place_json(first->there)}};
  object["notes"] = report.notes;
  object["next"] = next_steps(report, subject);
  return plain_text(object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace ticktrue::trail
