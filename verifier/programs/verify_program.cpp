// Runs the program once, and again after a finding. Both runs are judged in the same way.
// SPDX-License-Identifier: MIT
#include "verifier/programs/verify_program.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <sstream>
#include <utility>

#include "base/hash.h"
#include "base/plain_text.h"
#include "replay/trace_reader.h"
#include "verifier/programs/command_words.h"
#include "verifier/programs/program_run.h"
#include "verifier/report/report_read.h"
#include "verifier/verify/trace_source.h"
#include "verifier/verify/verify.h"

namespace ticktrue::verifier {
namespace {

/// What a run shows about the trace.
struct Judged {
  Report report;
  std::string finding;    // equal for two runs with the same result
  bool repeats = false;   // a second run shows whether the result repeats
  bool is_whole = false;  // as in ProgramVerdict
};

class ProgramVerification {
 public:
  ProgramVerification(std::string file, const ProgramCommand& command, std::string name, replay::TraceReader reader)
      : file_(std::move(file)), command_(command), name_(std::move(name)), reader_(std::move(reader)) {
    std::error_code failure;
    const auto path = std::filesystem::canonical(file_, failure);
    words_ = with_trace(command_.words, failure ? file_ : path.string());
  }

  Report verify() {
    Judged first = run();
    if (!first.repeats) return std::move(first.report);
    Judged second = run();
    Report report = std::move(first.report);
    report.again = {"ticktrue shake " + shell_word(file_) + " -- " + command_text() +
                    "  # looks for the cause: clock, heap, threads, libm, ..."};
    if (first.finding == second.finding) {
      report.notes.push_back("the program ran twice, with the same result");
      return report;
    }
    report.reason = "two runs of the program differ: first " + told(report) + "; then " + told(second.report);
    report.verdict = Verdict::not_reproducible;
    report.hint = "";
    return report;
  }

  std::vector<EscapedChild> escaped;
  bool is_whole = true;
  std::optional<std::vector<std::string>> mapped;

 private:
  std::string command_text() const {
    std::string text;
    for (const std::string& word : command_.words) {
      const bool is_mark = word == "{}" || word == "{trace}";
      text += (text.empty() ? "" : " ") + (is_mark ? std::string("{trace}") : shell_word(word));
    }
    return text;
  }

  static std::string told(const Report& report) {
    std::string text(verdict_info(report.verdict).name);
    if (report.divergence) {
      text += " at tick " + std::to_string(report.divergence->tick);
      if (!report.divergence->rows.empty())
        text += " in " + report.divergence->rows[0].table + "." + report.divergence->rows[0].column;
      else if (!report.divergence->contents.empty())
        text += " in " + report.divergence->contents[0].place;
      else if (!report.divergence->tables.empty())
        text += " in " + report.divergence->tables[0].table;
      return text + " (hash " + hex64(report.divergence->got_root) + ")";
    }
    return report.reason.empty() ? text : text + ": " + report.reason;
  }

  Report empty_report(Verdict verdict, const std::string& reason, const std::string& hint) const {
    Report report;
    report.title = reader_.setup().title;
    report.simulation = reader_.setup().simulation;
    report.mode = "replay";
    report.verdict = verdict;
    report.reason = reason;
    report.hint = hint;
    report.recorded_build = reader_.facts();
    report.ticks_recorded = reader_.tick_count_hint();
    if (report.ticks_recorded) *report.ticks_recorded -= std::min(reader_.first_tick(), *report.ticks_recorded);
    return report;
  }

  Judged run() {
    Result<ProgramRun> run = run_program(words_, command_.folder, name_, command_.time_s);
    Judged judged;
    if (run)
      judged = judge(*run);
    else
      judged.report = empty_report(Verdict::error, run.error().message, run.error().hint);
    judged.report.file = file_;
    is_whole = is_whole && judged.is_whole;
    if (run) mapped = run->mapped;
    if (!run || run->child.end.escaped.empty()) return judged;
    escaped.insert(escaped.end(), run->child.end.escaped.begin(), run->child.end.escaped.end());
    judged.report.warnings.push_back("the program left running: " + escaped_text(run->child.end.escaped) +
                                     "; ended with the command");
    return judged;
  }

  Judged judge(const ProgramRun& run) {
    using How = ChildEnd::How;
    const How how = run.child.end.how;
    if (how == How::not_started)
      return {empty_report(Verdict::error, command_.words.front() + ": " + run.failure,
                           "no shell runs the command: its first word is a program"),
              "", false};
    std::optional<ReadReport> read;
    if (const std::string wrong = read_results(run.results, read); !wrong.empty())
      return {empty_report(Verdict::incomplete, "result of the program: " + wrong,
                           "sessions write it to the file that TICKTRUE_RESULT names, and nobody else"),
              "", false};
    if (!run.failure.empty()) return broken_off(run, read);
    if (!read) return without_result(run);
    if (read->report.verdict == Verdict::match) return confirm(run, std::move(*read));
    return finding(std::move(*read));
  }

  /// Uses the first report that is not a match. Returns what is wrong with the lines; empty: nothing.
  std::string read_results(const std::string& results, std::optional<ReadReport>& read) const {
    const StateSchema& schema = reader_.setup().whole_schema ? *reader_.setup().whole_schema : reader_.setup().schema;
    std::istringstream lines(results);
    for (std::string line; std::getline(lines, line);) {
      std::optional<ReadReport> next = read_report(line, schema);
      if (!next) return "found a line that is no report of schema ticktrue.verify/2";
      std::error_code failure;
      if (!std::filesystem::equivalent(next->report.file, file_, failure))
        return "found a report of " + plain_line(next->report.file) + ", expected one of " + file_;
      if (!read || read->report.verdict == Verdict::match) read = std::move(next);
    }
    return "";
  }

  /// Judges a run that crashed, hung or printed without end. An earlier finding stays a finding.
  Judged broken_off(const ProgramRun& run, std::optional<ReadReport>& read) {
    const bool is_hung = run.child.end.how != ChildEnd::How::killed_by_signal;
    const std::string what = command_.words.front() + " " + run.failure;
    if (read && read->report.verdict != Verdict::match) {
      Judged judged = finding(std::move(*read));
      judged.is_whole = false;
      judged.report.notes.push_back(what + ", after it had reported this");
      judged.repeats = judged.repeats && !is_hung;
      return judged;
    }
    const std::string where = read ? ", after its session had matched" : position_text(run);
    return {
        empty_report(Verdict::diverged, what + where,
                     is_hung ? "--timeout gives it more time" : "run it in a debugger: gdb --args " + command_text()),
        what + where, !is_hung};
  }

  Judged without_result(const ProgramRun& run) {
    std::string reason =
        command_.words.front() + " ended with status " + std::to_string(run.child.end.exit_status) + position_text(run);
    if (run.has_session) {
      reason += ", without ticktrue_finish or ticktrue_close: nothing says that it compared the rest";
      return {empty_report(Verdict::diverged, reason, "leave the loop and close the session in every case"), reason,
              true};
    }
    if (const std::string message = last_line(run); !message.empty()) reason += ": " + message;
    return {empty_report(Verdict::incomplete, reason + ", and no session verified the trace",
                         "a session verifies with ticktrue_open_arguments and the words --verify TRACE"),
            "", false};
  }

  Judged finding(ReadReport read) {
    Judged judged{std::move(read.report), std::move(read.finding), false, true};
    const Verdict verdict = judged.report.verdict;
    judged.repeats = verdict == Verdict::diverged || verdict == Verdict::state_incomplete;
    if (verdict == Verdict::incomplete || verdict == Verdict::damaged) add_end(judged.report);
    return judged;
  }

  void add_end(Report& report) {
    ReaderSource source(reader_);
    source.rewind();
    while (!std::holds_alternative<std::monostate>(source.next())) continue;
    report.end = TraceEnd{source.tail(), ""};
    set_salvaged(*report.end, source.salvaged_from());
  }

  Judged confirm(const ProgramRun& run, ReadReport read) {
    Report& report = read.report;
    const auto refuse = [&](const std::string& reason, const std::string& hint) {
      report.verdict = Verdict::incomplete;
      report.reason = reason;
      report.hint = hint;
      return Judged{std::move(report), "", false};
    };
    if (run.child.end.exit_status != 0)
      return refuse("the session matches, and " + command_.words.front() + " ended with status " +
                        std::to_string(run.child.end.exit_status),
                    "return what ticktrue_close gives; whatever failed behind it is not part of the verdict");
    if (const std::string lie = contradiction(report); !lie.empty())
      return refuse("the report says match and is not of this trace: " + lie,
                    "sessions write the file that TICKTRUE_RESULT names, and nobody else");
    return Judged{std::move(report), std::move(read.finding), false, true};
  }

  /// How a report of a match contradicts the trace; empty: it does not.
  std::string contradiction(const Report& report) {
    if (report.simulation != reader_.setup().simulation)
      return "simulation: found " + plain_line(report.simulation) + ", expected " + reader_.setup().simulation;
    if (report.ticks_compared == 0) return "ticks compared: found 0, expected some";
    if (report.ticks_compared > UINT64_MAX - report.first_tick) return "ticks compared: found too many";
    const std::uint64_t last = report.first_tick + report.ticks_compared - 1;
    const std::optional<std::uint64_t> recorded = root_of(last);
    if (!recorded) return "tick " + std::to_string(last) + ": found it compared, and it is not recorded";
    if (*recorded == report.root_hash) return "";
    return "hash of tick " + std::to_string(last) + ": found " + hex64(report.root_hash) + ", recorded " +
           hex64(*recorded);
  }

  std::optional<std::uint64_t> root_of(std::uint64_t tick) {
    if (!reader_.seek(tick)) reader_.rewind();
    for (;;) {
      const auto& item = reader_.next();
      if (std::holds_alternative<std::monostate>(item)) return std::nullopt;
      const auto* record = std::get_if<replay::TickRecord>(&item);
      if (record != nullptr && record->tick == tick) return record->root_hash;
    }
  }

  std::string file_;
  const ProgramCommand& command_;
  std::string name_;
  replay::TraceReader reader_;
  std::vector<std::string> words_;
};

}  // namespace

ProgramVerdict verify_by_program(const std::string& file, const ProgramCommand& command, const std::string& name) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(file);
  if (!reader) return {open_error_report(file, reader.error()), false, {}, {}};
  ProgramVerification verification(file, command, name, std::move(*reader));
  ProgramVerdict verdict;
  verdict.report = verification.verify();
  verdict.is_whole = verification.is_whole;
  verdict.mapped = std::move(verification.mapped);
  verdict.escaped = std::move(verification.escaped);
  return verdict;
}

}  // namespace ticktrue::verifier
