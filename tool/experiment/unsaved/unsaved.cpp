// Converts the log of the session to findings, or to an error that explains a failed search.
// SPDX-License-Identifier: MIT
#include "tool/experiment/unsaved/unsaved.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/count_text.h"
#include "base/plain_text.h"
#include "tool/experiment/unsaved/things.h"

namespace ticktrue::unsaved {
namespace {

namespace fs = std::filesystem;
constexpr const char* log_variable = "TICKTRUE_UNSAVED";
constexpr std::uint64_t log_size_max = std::uint64_t{256} << 20;

Error refused(const std::string& what, const std::string& hint) {
  return {ErrorCode::usage, what, hint};
}

/// Null if no session wrote a complete log.
nlohmann::ordered_json read_log(const std::string& path) {
  std::error_code failed;
  const std::uintmax_t size = fs::file_size(path, failed);
  if (failed || size > log_size_max) return nlohmann::ordered_json();
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  nlohmann::ordered_json log = nlohmann::ordered_json::parse(text, nullptr, false);
  return log.is_object() ? log : nlohmann::ordered_json();
}

std::vector<UnsavedFinding> findings_of(const nlohmann::ordered_json& list, ThingNames& names) {
  std::vector<UnsavedFinding> findings;
  for (const nlohmann::ordered_json& json : list) {
    UnsavedFinding finding;
    finding.things = names.things(json.at("units"));
    finding.is_joint = json.at("is_joint").get<bool>();
    finding.tick = json.at("tick").get<std::uint64_t>();
    finding.window = json.at("window").get<std::uint64_t>();
    for (const nlohmann::ordered_json& column : json.at("columns"))
      finding.columns.push_back(plain_line(column.get<std::string>()));
    // Parts of one block or variable are merged into one finding.
    const auto same = std::find_if(findings.begin(), findings.end(), [&](const UnsavedFinding& other) {
      return !other.things.empty() && !finding.things.empty() && is_same_place(other.things[0], finding.things[0]);
    });
    if (same == findings.end()) {
      findings.push_back(std::move(finding));
      continue;
    }
    merge(same->things[0], finding.things[0]);
    if (finding.tick < same->tick) {
      same->tick = finding.tick;
      same->columns = finding.columns;
    }
  }
  std::stable_sort(findings.begin(), findings.end(),
                   [](const UnsavedFinding& a, const UnsavedFinding& b) { return a.tick < b.tick; });
  return findings;
}

/// Things that differ without an effect. Omits the stack, and blocks or variables of which a part has an effect.
std::vector<Thing> harmless_of(const nlohmann::ordered_json& units, const std::vector<UnsavedFinding>& findings,
                               ThingNames& names) {
  std::vector<Thing> things = names.things(units);
  std::erase_if(things, [&](const Thing& thing) {
    if (thing.kind == ThingKind::stack) return true;
    for (const UnsavedFinding& finding : findings)
      for (const Thing& found : finding.things)
        if (is_same_place(thing, found)) return true;
    return false;
  });
  return things;
}

std::string find_cause(const UnsavedOptions& options) {
  return options.shake_command + "  # looks for the cause: a clock, random bytes, addresses";
}

/// If the session gives no hint, the hint is the command that finds the cause.
std::string hint_of(const nlohmann::ordered_json& log, const UnsavedOptions& options) {
  const auto hint = log.at("hint").get<std::string>();
  return hint.empty() ? find_cause(options) : hint;
}

/// The reason why the run says nothing, as an error; ok if it says something.
Status check_run(const UnsavedReport& report, const nlohmann::ordered_json& log, const UnsavedOptions& options) {
  const std::string& program = options.launch.words.front();
  const shake::Outcome& outcome = report.outcome;
  const std::string how = outcome.reason.empty() ? std::string() : ": " + outcome.reason;
  if (log.is_null())
    return refused(program + ": no session wrote findings" + how,
                   outcome.has_session ? "its libticktrue is older than this tool: link it anew"
                                       : "is it a program with a session of libticktrue, that takes --verify?");
  if (const auto why = log.at("refusal").get<std::string>(); !why.empty() && report.window_count == 0)
    return refused(program + ": " + why, hint_of(log, options));
  if (!outcome.has_shim)
    return refused(program + ": found no preload library in it, expected it in front of malloc",
                   "a statically linked program, or one with other privileges, loads none: link it dynamically");
  if (!report.findings.empty() || !report.unexplained.empty() || !report.not_loaded.empty()) return {};
  if (const auto threads = log.at("threads").get<std::uint64_t>(); threads > 1 && report.window_count == 0)
    return refused(program + ": found " + std::to_string(threads) + " threads, expected one",
                   "the search runs copies of the process, and a copy has one thread: run the program with one");
  if (outcome.kind == shake::OutcomeKind::crashed || outcome.kind == shake::OutcomeKind::hung ||
      outcome.kind == shake::OutcomeKind::no_result || outcome.kind == shake::OutcomeKind::not_started)
    return refused(program + ": " + shake::outcome_name(outcome.kind) + how,
                   "run the program with --verify: what does its report say?");
  if (outcome.kind != shake::OutcomeKind::match)
    return refused(program + ": " + shake::outcome_text(outcome) + ": it differs from the trace without any load",
                   options.shake_command + "  # looks for the cause of that");
  const auto lost = log.at("lost").get<std::uint64_t>();
  if (report.window_count > 0 && lost == report.window_count)
    return refused(program + ": no window was run twice: " + log.at("lost_reason").get<std::string>(),
                   "a loop that runs ticks twice counts them by its state or by ticktrue_tick");
  if (report.window_count == 0)
    return refused(program + ": found no save in " + count_text(report.tick_count, "tick") + ", expected one",
                   log.at("missing_saves").get<std::uint64_t>() > 0
                       ? "the save callback returns TICKTRUE_SAVE_FAILED each time"
                       : "record a longer session");
  return {};
}

void add_notes(const nlohmann::ordered_json& log, UnsavedReport& report) {
  const auto lost = log.at("lost").get<std::uint64_t>();
  if (lost > 0)
    report.notes.push_back(count_text(lost, "window") +
                           " without a result: " + log.at("lost_reason").get<std::string>());
  if (const auto bytes = log.at("left_out").get<std::uint64_t>(); bytes > 0)
    report.notes.push_back(std::to_string((bytes >> 20) + 1) +
                           " MiB were not compared: a variable above 256 MiB, or the heap behind its first 512 MiB");
  if (const auto windows = log.at("unexamined").get<std::uint64_t>(); windows > 0)
    report.notes.push_back(count_text(windows, "window") +
                           " with other columns were not examined to the end: mend what is named, and run again");
  if (const auto threads = log.at("threads").get<std::uint64_t>(); threads > 1)
    report.notes.push_back("windows with " + std::to_string(threads) + " threads were left out");
  if (const auto missing = log.at("missing_saves").get<std::uint64_t>(); missing > 0)
    report.notes.push_back(count_text(missing, "time") + " the save callback returned TICKTRUE_SAVE_FAILED");
  if (!log.at("has_ended").get<bool>())
    report.notes.push_back(
        "the program ended before its session: " +
        (report.outcome.reason.empty() ? std::string("it never called ticktrue_close") : report.outcome.reason));
}

}  // namespace

const char* name_of(UnsavedVerdict verdict) {
  constexpr std::array<const char*, 3> names{"nothing", "found", "not_reproducible"};
  return names[static_cast<std::size_t>(verdict)];
}

Result<UnsavedReport> run_unsaved(const UnsavedOptions& options) {
  if (options.launch.shim_path.empty())
    return refused("unsaved: " + options.launch.no_shim,
                   "it is built beside this tool, on GNU/Linux alone: copy it from that build or package");
  const std::string path = options.launch.folder + "/unsaved.json";
  shake::Conditions conditions;
  conditions.settings.heap_kept = 1;
  conditions.environment.emplace_back(log_variable, path);
  shake::Launcher launcher(options.launch);
  const Result<shake::Run> run = launcher.run(conditions);
  if (!run) return run.error();
  UnsavedReport report;
  report.outcome = run->outcome;
  const nlohmann::ordered_json log = read_log(path);
  if (!log.is_null()) try {
      ThingNames names;
      report.window_count = log.at("windows").get<std::uint64_t>();
      report.trial_count = log.at("trials").get<std::uint64_t>();
      report.tick_count = log.at("ticks").get<std::uint64_t>();
      report.findings = findings_of(log.at("findings"), names);
      report.unexplained = findings_of(log.at("unexplained"), names);
      report.not_loaded = findings_of(log.at("not_loaded"), names);
      report.harmless = harmless_of(log.at("harmless"), report.findings, names);
    } catch (const nlohmann::ordered_json::exception& wrong) {
      return refused(options.launch.words.front() + ": findings: " + wrong.what(),
                     "its libticktrue is of another version than this tool: link it anew");
    }
  if (const Status status = check_run(report, log, options); !status) return status.error();
  add_notes(log, report);
  const bool has_any = !report.findings.empty() || !report.unexplained.empty() || !report.not_loaded.empty();
  report.verdict = has_any ? UnsavedVerdict::found : UnsavedVerdict::nothing;
  if (const auto why = log.at("refusal").get<std::string>(); !why.empty()) {
    report.notes.push_back(why);
    if (report.findings.empty()) report.verdict = UnsavedVerdict::not_reproducible;
  }
  if (report.verdict == UnsavedVerdict::found)
    report.next = {"write each into what save gives, and read it back in load"};
  if (report.verdict == UnsavedVerdict::not_reproducible) report.next = {find_cause(options)};
  return report;
}

}  // namespace ticktrue::unsaved
