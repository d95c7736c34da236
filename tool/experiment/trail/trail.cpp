// A side is a program whose session writes a log, or the trace, which holds marks and sometimes lists.
// SPDX-License-Identifier: MIT
#include "tool/experiment/trail/trail.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <utility>

#include "base/count_text.h"
#include "replay/trace_reader.h"
#include "verifier/locate/compare_marks.h"

namespace ticktrue::trail {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t log_size_max = std::uint64_t{1} << 30;

/// The marks of ticks. A missing tick is unknown.
using TickMap = std::map<std::uint64_t, std::optional<replay::TickMarks>>;

struct ProgramRun {
  shake::Outcome outcome;
  replay::MarkLog log;
};

Error refused(const std::string& what, const std::string& hint) {
  return {ErrorCode::usage, what, hint};
}

Result<Bytes> read_log(const std::string& path) {
  std::error_code failed;
  const std::uintmax_t size = fs::file_size(path, failed);
  if (failed) return Bytes();  // no session wrote a log
  if (size > log_size_max)
    return Error{
        ErrorCode::limit,
        path + ": bytes of marks: found " + std::to_string(size) + ", expected at most " + std::to_string(log_size_max),
        "verify fewer ticks: record a shorter session"};
  std::ifstream in(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

/// Runs a program on the trace. `tick`: the tick whose marks are listed.
Result<ProgramRun> run_program(const TrailOptions& options, const std::vector<std::string>& words,
                               std::optional<std::uint64_t> tick) {
  shake::LaunchOptions launch = options.launch;
  launch.words = words;
  const std::string log = launch.folder + "/marks";
  std::error_code ignored;
  fs::remove(log, ignored);
  shake::Conditions conditions;
  conditions.has_shim = !options.calls.empty();
  conditions.environment.emplace_back(replay::trail_variable, log);
  if (tick) conditions.environment.emplace_back(replay::trail_tick_variable, std::to_string(*tick));
  if (!options.calls.empty()) conditions.environment.emplace_back(replay::calls_variable, options.calls);
  shake::Launcher launcher(launch);
  Result<shake::Run> run = launcher.run(conditions);
  if (!run) return run.error();
  ProgramRun done;
  done.outcome = std::move(run->outcome);
  const Result<Bytes> bytes = read_log(log);
  if (!bytes) return bytes.error();
  done.log = replay::decode_mark_log(*bytes);
  fs::remove(log, ignored);
  if (!done.log.ticks.empty()) return done;
  const bool has_result = done.outcome.kind != shake::OutcomeKind::no_result;
  return refused(words.front() + ": no tick was compared" +
                     (done.outcome.reason.empty() ? std::string() : ": " + done.outcome.reason),
                 has_result ? "run the program with --verify: what does its report say?"
                            : "is it a program with a session of libticktrue 0.1.0 or later, that takes --verify?");
}

/// The marks in the trace. `list`: of the requested tick, if stored.
struct RecordedSide {
  bool has_marks = false;
  TickMap ticks;
  std::optional<replay::MarkList> list;
};

Result<RecordedSide> read_trace(const std::string& path) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(path);
  if (!reader) return reader.error();
  RecordedSide side;
  side.has_marks = reader->setup().has(replay::Feature::marks);
  for (; side.has_marks;) {
    const replay::TraceReader::Item& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* tick = std::get_if<replay::TickRecord>(&item);
    if (tick != nullptr && tick->has_bound) side.ticks[tick->tick] = tick->marks;
  }
  return side;
}

std::optional<replay::MarkList> list_in_trace(const std::string& path, std::uint64_t wanted) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(path);
  if (!reader || !reader->setup().is_full(wanted)) return std::nullopt;
  reader->seek(wanted);
  for (;;) {
    const replay::TraceReader::Item& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) return std::nullopt;
    const auto* tick = std::get_if<replay::TickRecord>(&item);
    if (tick == nullptr || tick->tick < wanted) continue;
    if (tick->tick > wanted || !tick->has_bound) return std::nullopt;
    return tick->mark_list ? tick->mark_list : std::optional(replay::MarkList{});
  }
}

TickMap ticks_of(const replay::MarkLog& log) {
  TickMap ticks;
  for (const replay::LoggedTick& tick : log.ticks) ticks[tick.tick] = tick.marks;
  return ticks;
}

/// Compares the ticks that both sides have, up to the first difference.
void compare_ticks(const TickMap& here, const TickMap& there, TrailReport& report) {
  for (const auto& [tick, marks] : here) {
    const auto found = there.find(tick);
    if (found == there.end()) continue;
    ++report.tick_count;
    report.marks = verifier::compare_marks(tick, found->second ? &*found->second : nullptr, marks ? &*marks : nullptr);
    if (report.marks) break;
  }
  report.verdict = report.marks ? TrailVerdict::differ : TrailVerdict::same;
}

/// Runs a program again for the list of the tick. Absent: the program made other marks this time.
Result<std::optional<MarkSide>> list_of(const TrailOptions& options, const std::vector<std::string>& words,
                                        std::uint64_t tick, const std::optional<replay::TickMarks>& before) {
  const Result<ProgramRun> run = run_program(options, words, tick);
  if (!run) return run.error();
  const TickMap ticks = ticks_of(run->log);
  const auto found = ticks.find(tick);
  if (found == ticks.end() || found->second != before) return std::optional<MarkSide>();
  if (!run->log.list) return std::optional<MarkSide>(MarkSide{});
  return std::optional<MarkSide>(side_of(*run->log.list));
}

/// Names that were marked more or less often. Without any, the names with other values.
std::vector<std::string> names_of(const verifier::MarksDifference& marks) {
  std::vector<std::string> counted, all;
  for (const verifier::NameDifference& name : marks.names) {
    all.push_back(name.name);
    if (name.expected != name.got) counted.push_back(name.name);
  }
  return counted.empty() ? all : counted;
}

/// Compares the lists of the tick in which marks differ.
Status compare_tick_lists(const TrailOptions& options, const TickMap& here, const TickMap& there, TrailReport& report) {
  const std::uint64_t tick = report.marks->tick;
  const auto lost = [&](const std::vector<std::string>& words) {
    report.verdict = TrailVerdict::not_reproducible;
    report.is_against_lost = &words == &options.against;
    report.notes.push_back(words.front() + " made other marks in tick " + std::to_string(tick) + " when it ran again");
    return Status();
  };
  const auto list_here = list_of(options, options.words, tick, here.at(tick));
  if (!list_here) return list_here.error();
  if (!*list_here) return lost(options.words);
  report.has_list_here = true;
  std::optional<MarkSide> list_there;
  if (!options.against.empty()) {
    auto other = list_of(options, options.against, tick, there.at(tick));
    if (!other) return other.error();
    if (!*other) return lost(options.against);
    list_there = std::move(*other);
  } else if (auto recorded = list_in_trace(options.trace, tick)) {
    list_there.emplace().list = std::move(*recorded);
  }
  report.has_list_there = list_there.has_value();
  report.lists = compare_lists(**list_here, list_there ? &*list_there : nullptr, names_of(*report.marks));
  if ((*list_here)->list.is_cut || (list_there && list_there->list.is_cut))
    report.notes.push_back("the list of the tick is cut: marks behind its end are not compared");
  if (report.marks->names.empty() && !list_there)
    report.notes.push_back("the order differs: only two lists tell which mark moved");
  return {};
}

}  // namespace

const char* name_of(TrailVerdict verdict) {
  constexpr std::array<const char*, 3> names{"marks_differ", "marks_same", "not_reproducible"};
  return names[static_cast<std::size_t>(verdict)];
}

Result<TrailReport> run_trail(const TrailOptions& options) {
  if (!options.calls.empty() && options.launch.shim_path.empty())
    return refused("--calls: " + options.launch.no_shim,
                   "it is built beside this tool, on GNU/Linux alone: copy it from that build or package");
  TrailReport report;
  TickMap there;
  if (options.against.empty()) {
    Result<RecordedSide> recorded = read_trace(options.trace);
    if (!recorded) return recorded.error();
    if (!recorded->has_marks)
      return refused(options.trace + ": found no marks in it, expected some to compare with",
                     "record it with TICKTRUE_MARKS, or name another build of the program by --against");
    there = std::move(recorded->ticks);
  } else {
    const Result<ProgramRun> other = run_program(options, options.against, std::nullopt);
    if (!other) return other.error();
    report.there = other->outcome;
    there = ticks_of(other->log);
  }
  const Result<ProgramRun> first = run_program(options, options.words, std::nullopt);
  if (!first) return first.error();
  report.here = first->outcome;
  const TickMap here = ticks_of(first->log);
  compare_ticks(here, there, report);
  if (report.marks)
    if (const Status compared = compare_tick_lists(options, here, there, report); !compared) return compared.error();
  return report;
}

}  // namespace ticktrue::trail
