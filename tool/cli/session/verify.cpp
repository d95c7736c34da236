// `ticktrue verify`: re-simulates traces and reports the first divergence of each.
// SPDX-License-Identifier: MIT
#include "verifier/verify/verify.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <system_error>

#include "base/count_text.h"
#include "base/limits.h"
#include "base/parallel/jobs.h"
#include "tool/cli/commands.h"
#include "tool/cli/session/program_runs.h"
#include "tool/corpus/verify_trace.h"
#include "tool/output/progress.h"
#include "tool/output/trace_text.h"
#include "tool/session/plugin_session.h"
#include "tool/session/scene_source.h"
#include "tool/session/session_inputs.h"
#include "tool/session/simulations.h"
#include "verifier/compare/against_build.h"
#include "verifier/compare/pair_report.h"
#include "verifier/corpus/trace_list.h"
#include "verifier/plugins/plugin.h"
#include "verifier/programs/command_words.h"
#include "verifier/programs/program_builds.h"
#include "verifier/programs/verify_program.h"
#include "verifier/report/report.h"
#include "verifier/report/report_ci.h"
#include "verifier/runs/data_file.h"
#include "verifier/runs/run_folder.h"
#include "verifier/runs/shared_count.h"

namespace ticktrue::cli {
namespace {

using verifier::Report;
using verifier::Verdict;

struct VerifyCommand {
  std::vector<std::string> files;
  std::string mode = "replay";
  std::optional<std::uint64_t> from;
  std::optional<std::uint64_t> to;
  bool to_end = false;
  bool json = false;
  bool git_bisect = false;
  bool github = false;
  bool allow_truncated = false;
  std::uint64_t jobs = 0;          // 0: every core
  std::uint64_t thread_count = 1;  // of a tick
  std::string shard;
  std::string junit;
  std::string report_page;
  std::string other_build;
  std::string other_plugin;
  std::optional<std::string> other_program;  // the words of it
  std::uint64_t timeout_s = 600;
  std::optional<std::string> program;  // the words of the one that recorded
  std::string builds;                  // a folder with builds of it
  std::string inputs;                  // of scenes
  std::optional<std::uint64_t> tick_count;
  std::optional<std::uint64_t> sync_ticks;
};

std::string mode_help() {
  std::string text = "What to prove.";
  for (const verifier::VerifyModeInfo& info : verifier::verify_modes)
    text += " " + std::string(info.name) + ": " + std::string(info.summary) + ".";
  return text;
}

verifier::VerifyOptions walk_options(const VerifyCommand& command) {
  verifier::VerifyOptions options;
  options.mode = verify_mode_of(command.mode);
  options.from = command.from.value_or(0);
  options.to = command.to;
  options.to_end = command.to_end;
  return options;
}

using ProgressCall = std::function<void(std::uint64_t ticks_done, std::uint64_t tick_count)>;

/// `compared` (may be null) counts the ticks as they are compared: what a process that ends by a crash leaves behind.
Report verify_file(const std::string& file, const VerifyCommand& command, unsigned thread_count,
                   const ProgressCall& progress, verifier::SharedCount* compared) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(file);
  if (!reader) return verifier::open_error_report(file, reader.error());
  if (command.from)
    if (const Status known = check_tick(file + ": --from", *command.from, reader->tick_count_hint()); !known)
      return verifier::open_error_report(file, known.error());
  const verifier::VerifyOptions options = walk_options(command);
  tool::TraceVerification how;
  how.mode = options.mode;
  how.from = options.from;
  how.to = options.to;
  how.to_end = options.to_end;
  how.sync_ticks = command.sync_ticks.value_or(0);
  how.in_segments = command.jobs != 1;
  how.thread_count = thread_count;
  how.engine_threads = static_cast<unsigned>(command.thread_count);
  how.compared = compared;
  how.progress = progress;
  Report report = tool::verify_trace(*reader, file, how);
  const SimulationInfo* simulation = tool::simulation_of(*reader);
  const bool is_against = !command.other_build.empty() || !command.other_plugin.empty();
  if (is_against && simulation != nullptr) {
    verifier::AgainstOptions against;
    against.binary = command.other_build;
    if (!command.other_plugin.empty()) {
      against.binary = command.other_plugin;
      against.words = {own_program(), "--plugin", command.other_plugin};
    }
    against.timeout_s = static_cast<double>(command.timeout_s);
    const SimulationInfo on_threads = tool::on_engine_threads(*simulation, how.engine_threads);
    against.simulation = &on_threads;
    report = verifier::compare_builds(*reader, std::move(report), against);
  }
  return report;
}

/// Mode twice on a scene: nothing was recorded, and nothing needs to be.
Report verify_scene(const std::string& word, const VerifyCommand& command, const ProgressCall& progress) {
  const auto refused = [&](const Error& error) {
    Report report;
    report.file = word;
    report.verdict = Verdict::error;
    report.reason = error.message;
    report.hint = error.hint;
    return report;
  };
  const Result<engine::Scene> scene = load_scene_argument(word);
  if (!scene) return refused(scene.error());
  const auto made = engine::make_engine(*scene, engine_options(command.thread_count));
  if (!made) return refused(made.error());
  auto inputs = open_session_inputs(*scene, command.inputs, command.tick_count);
  if (!inputs) return refused(inputs.error());
  if (const Status clock = use_clock(*inputs, {}, **made); !clock) return refused(clock.error());
  tool::SceneSource source(**made, *inputs->source, command.tick_count);
  verifier::VerifyOptions options = walk_options(command);
  options.simulation = tool::find_simulation(engine::simulation_name);
  if (progress) options.progress = [&](std::uint64_t done) { progress(done, inputs->ticks_expected); };
  Report report = verifier::verify_source(source, options);
  if (source.error()) return refused(*source.error());
  report.file = word;
  return report;
}

bool is_scene(const std::string& word) {
  std::error_code failure;
  const std::filesystem::path path(word);
  if (path.extension() == ".json") return true;
  return path.extension() != ".ttr" && !std::filesystem::exists(path, failure);
}

Report finish_report(Report report, const VerifyCommand& command, std::chrono::steady_clock::time_point start) {
  report.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (report.verdict == Verdict::incomplete && report.exit_code(command.allow_truncated) == verifier::exit_ok) {
    report.hint.clear();
    report.notes.push_back("accepted: every tick up to the cut matches (--allow-truncated)");
  }
  return report;
}

Report verify_word(const std::string& word, const VerifyCommand& command, unsigned thread_count,
                   const ProgressCall& progress, verifier::SharedCount* compared = nullptr) {
  const auto start = std::chrono::steady_clock::now();
  return finish_report(command.mode == "twice" && is_scene(word)
                           ? verify_scene(word, command, progress)
                           : verify_file(word, command, thread_count, progress, compared),
                       command, start);
}

/// The program that recorded the traces, another one to compare it with, and a folder for the files of their runs.
struct Program {
  verifier::ProgramCommand command;
  std::optional<verifier::ProgramBuilds> builds;
  std::optional<verifier::ProgramCommand> other;
  std::optional<verifier::RunFolder> folder;
  std::mutex lock;
  std::vector<verifier::EscapedChild> escaped;

  ~Program() { verifier::end_escaped(escaped); }

  Report verify(const std::string& file, std::size_t number) {
    if (!builds) return verify_by_both(command, other, file, number);
    const Result<std::string> recorder = builds->recorder_of(file);
    if (!recorder) return verifier::open_error_report(file, recorder.error());
    verifier::ProgramCommand here = command;
    verifier::replace_build(here.words, *recorder);
    std::optional<verifier::ProgramCommand> there = other;
    if (there) verifier::replace_build(there->words, *recorder);
    Report report = verify_by_both(here, there, file, number);
    report.notes.push_back("recorded by the build " + *recorder);
    return report;
  }

 private:
  Report verify_by_both(const verifier::ProgramCommand& here, const std::optional<verifier::ProgramCommand>& there,
                        const std::string& file, std::size_t number) {
    Report report = verify_by(here, file, "run-" + std::to_string(number));
    if (!there || report.verdict == Verdict::error) return report;
    const Report other_report = verify_by(*there, file, "other-" + std::to_string(number));
    return verifier::pair_of_programs(std::move(report), other_report, verifier::command_line_of(there->words));
  }

  Report verify_by(const verifier::ProgramCommand& program, const std::string& file, const std::string& name) {
    if (stop_requested()) return verifier::open_error_report(file, Error{ErrorCode::io, file + ": stopped", ""});
    verifier::ProgramVerdict verdict = verifier::verify_by_program(file, program, name);
    const std::lock_guard<std::mutex> guard(lock);
    escaped.insert(escaped.end(), verdict.escaped.begin(), verdict.escaped.end());
    return std::move(verdict.report);
  }
};

/// The folder of --builds, which some word of a program has to name.
Status open_builds(const VerifyCommand& command, Program& program) {
  std::vector<std::string> words = program.command.words;
  if (program.other) words.insert(words.end(), program.other->words.begin(), program.other->words.end());
  const bool has_mark = verifier::replace_build(words, "");
  if (command.builds.empty()) {
    if (!has_mark) return {};
    return Error{ErrorCode::usage, "--command: found {build} and no --builds, expected the folder of the builds", ""};
  }
  if (!has_mark)
    return Error{ErrorCode::usage, "--builds: found no {build} in --command, expected it in place of the program",
                 "as in --command '{build} --verify {}'"};
  Result<verifier::ProgramBuilds> builds = verifier::ProgramBuilds::find(command.builds);
  if (!builds) return Error{ErrorCode::usage, "--builds: " + builds.error().message, builds.error().hint};
  program.builds.emplace(*std::move(builds));
  return {};
}

Status open_program(const VerifyCommand& command, std::optional<Program>& program) {
  if (!command.program) return {};
  Result<std::vector<std::string>> words = verifier::split_command(*command.program);
  if (!words) return words.error();
  Result<verifier::RunFolder> folder = verifier::RunFolder::make("ticktrue-verify", "");
  if (!folder) return folder.error();
  program.emplace();
  program->command.words = *std::move(words);
  program->command.folder = folder->path();
  program->command.time_s = static_cast<double>(command.timeout_s);
  if (command.other_program) {
    Result<std::vector<std::string>> other = verifier::split_command(*command.other_program, "--against-command");
    if (!other) return other.error();
    program->other = program->command;
    program->other->words = *std::move(other);
  }
  if (const Status status = open_builds(command, *program); !status) return status;
  program->folder.emplace(*std::move(folder));
  catch_stop_signals();  // so that the folder is removed
  return {};
}

/// In a process of its own.
Report verify_by_plugin(const std::string& file, const VerifyCommand& command) {
  const auto work = [&](verifier::SharedCount& compared) {
    Progress bar("verify " + file, 0);
    const ProgressCall show = [&](std::uint64_t ticks, std::uint64_t total) { bar.update(ticks, total); };
    return verify_word(file, command, 1, show, &compared);
  };
  return tool::verify_by_plugin(file, command.mode, work).report;
}

void print_report(const Report& report, const VerifyCommand& command) {
  if (report.verdict == Verdict::error) {
    print_error(Error{ErrorCode::io, report.reason, report.hint});
    if (report.divergence && !command.json) print(verifier::report_text(report));
  } else if (!command.json) {
    print(verifier::report_text(report));
  }
}

/// `number`: of the file.
Report verify_one(const std::string& file, const VerifyCommand& command, Program* program, std::size_t number,
                  bool has_bar, unsigned thread_count) {
  if (program != nullptr) {
    const auto start = std::chrono::steady_clock::now();
    return finish_report(program->verify(file, number), command, start);
  }
  if (tool::needs_plugin(file)) return verify_by_plugin(file, command);
  std::optional<Progress> bar;
  if (has_bar) bar.emplace("verify " + file, 0);
  const ProgressCall show = [&](std::uint64_t done, std::uint64_t total) { bar->update(done, total); };
  Report report = verify_word(file, command, thread_count, bar ? show : ProgressCall{});
  if (bar) bar->finish();
  return report;
}

/// All files on all threads; reports are printed in the order of the files, each as soon as those before it are.
Result<std::vector<Report>> verify_all(const std::vector<std::string>& files, const VerifyCommand& command,
                                       Program* program) {
  const unsigned thread_count =
      command.jobs == 0 ? core_count() : static_cast<unsigned>(std::min<std::uint64_t>(command.jobs, 1024));
  // With plug-ins one by one: they are not asked to be safe for threads, and a process with threads should not fork.
  const bool in_threads = verifier::plugin_simulations().empty();
  const auto at_once = static_cast<unsigned>(
      std::min<std::size_t>(in_threads ? thread_count : 1, std::max<std::size_t>(1, files.size())));
  // The largest first: else the last thread works on it alone while the others have nothing left.
  std::vector<std::pair<std::uintmax_t, std::size_t>> order;
  for (std::size_t i = 0; i < files.size(); ++i) {
    std::error_code failure;
    const std::uintmax_t size = std::filesystem::file_size(files[i], failure);
    order.emplace_back(failure || at_once == 1 ? 0 : size, i);
  }
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first > b.first; });

  std::vector<std::optional<Report>> found(files.size());
  std::size_t printed = 0;
  std::mutex lock;
  const bool one_by_one = at_once == 1;
  std::optional<Progress> overall;
  if (!one_by_one) overall.emplace("verify", files.size(), "traces");
  const Status status = run_jobs(files.size(), at_once, [&](std::size_t job) {
    const std::size_t i = order[job].second;
    Report report = verify_one(files[i], command, program, i, one_by_one, std::max(1u, thread_count / at_once));
    const std::lock_guard<std::mutex> guard(lock);
    found[i] = std::move(report);
    if (overall) overall->finish();
    for (; printed < files.size() && found[printed]; ++printed) print_report(*found[printed], command);
    if (overall) overall->update(printed);
  });
  if (overall) overall->finish();
  if (!status) return status.error();
  std::vector<Report> reports;
  for (std::optional<Report>& report : found) reports.push_back(std::move(*report));
  return reports;
}

void print_summary(const std::vector<Report>& reports) {
  std::string text = count_text(reports.size(), "trace") + ":";
  const char* separator = " ";
  for (const verifier::VerdictInfo& info : verifier::verdicts) {
    const auto count = std::count_if(reports.begin(), reports.end(),
                                     [&](const Report& report) { return report.verdict == info.verdict; });
    if (count == 0) continue;
    text += separator + std::to_string(count) + " " + std::string(info.name);
    separator = ", ";
  }
  print(text + "\n");
}

Status check_options(const VerifyCommand& command) {
  const auto refuse = [](const std::string& what, const std::string& hint = "") {
    return Error{ErrorCode::usage, what, hint};
  };
  if (command.from && command.to && *command.from > *command.to)
    return refuse("--from: found " + std::to_string(*command.from) + ", expected at most --to " +
                  std::to_string(*command.to));
  if (const Status status = check_threads(command.thread_count); !status) return status;
  if (command.thread_count > 1 && command.mode == "threads")
    return refuse("--threads: found --mode threads, expected another", "it runs with 1, 2, 4 and 8");
  if (command.to_end && command.mode != "restore")
    return refuse("--to-end: found --mode " + command.mode + ", expected restore",
                  "the other modes always run to the end");
  if (command.sync_ticks && command.mode != "replay")
    return refuse("--sync-test: found --mode " + command.mode + ", expected replay",
                  "it brings the run back after each K ticks, and runs them again");
  if (command.mode == "twice" && command.from)
    return refuse("--from: found --mode twice, expected replay or restore", "both runs begin with the setup");
  if (command.program) {
    const std::pair<const char*, bool> others[] = {{"--mode", command.mode != "replay"},
                                                   {"--from", command.from.has_value()},
                                                   {"--to", command.to.has_value()},
                                                   {"--threads", command.thread_count != 1},
                                                   {"--sync-test", command.sync_ticks.has_value()},
                                                   {"--against-plugin", !command.other_plugin.empty()},
                                                   {"--against-build", !command.other_build.empty()}};
    for (const auto& [name, is_given] : others)
      if (is_given)
        return refuse(std::string(name) + ": found it with --command, expected it among the words of the program",
                      "as in --command './mygame --verify {} --from 200'");
  }
  if (command.other_program && !command.program)
    return refuse("--against-command: found no --command, expected the program to compare with");
  if (!command.other_plugin.empty() && !has_plugin())
    return refuse("--against-plugin: found no --plugin, expected the library to compare with");
  if (!command.other_plugin.empty() && !command.other_build.empty())
    return refuse("--against-plugin: found --against-build as well, expected one of them");
  const bool is_against = !command.other_build.empty() || !command.other_plugin.empty();
  if (is_against && command.sync_ticks)
    return refuse(std::string("--sync-test: found ") +
                  (command.other_build.empty() ? "--against-plugin" : "--against-build") +
                  " as well, expected one of them");
  if (is_against && command.mode != "replay")
    return refuse((command.other_build.empty() ? "--against-plugin: found --mode " : "--against-build: found --mode ") +
                  command.mode + ", expected replay");
  if (command.mode != "twice" && (command.tick_count || !command.inputs.empty()))
    return refuse("--ticks, --inputs: found --mode " + command.mode + ", expected twice",
                  "they are for a scene; a trace has its own");
  return {};
}

/// Output for continuous integration, in addition to the reports.
Status write_for_ci(const std::vector<Report>& reports, const VerifyCommand& command) {
  if (!command.junit.empty()) {
    auto file = verifier::DataFile::create(command.junit, true);
    if (!file) return file.error();
    if (const Status status = file->write(verifier::report_junit(reports, command.allow_truncated)); !status)
      return status;
    if (const Status status = file->close(); !status) return status;
  }
  if (!command.report_page.empty())
    if (const Status status = write_failure_page(reports, command.report_page, command.allow_truncated); !status)
      return status;
  if (!command.github) return {};
  // Annotations are messages: the runner reads them on either stream, and standard output may hold JSON.
  const std::string lines = verifier::report_github(reports, command.allow_truncated);
  std::fwrite(lines.data(), 1, lines.size(), stderr);
  const char* summary = std::getenv("GITHUB_STEP_SUMMARY");
  if (summary == nullptr || *summary == '\0') return {};
  std::ofstream out(summary, std::ios::binary | std::ios::app);
  out << verifier::report_markdown(reports, command.allow_truncated) << std::flush;
  if (!out) return Error{ErrorCode::io, std::string(summary) + ": cannot write the summary of the step", ""};
  return {};
}

int run_verify(VerifyCommand command) {
  if (!command.builds.empty() && !command.program) command.program = "{build}";
  const auto exit_with = [&](int code) { return command.git_bisect ? verifier::git_bisect_exit_code(code) : code; };
  if (const Status status = check_options(command); !status) return exit_with(fail_usage(status.error()));
  Result<std::vector<std::string>> files = verifier::list_traces(command.files);
  if (!files) return exit_with(fail_usage(files.error()));
  for (const std::string& output : {command.junit, command.report_page})
    if (const Status status = verifier::check_not_read(output, *files); !status)
      return exit_with(fail_usage(status.error()));
  if (!command.shard.empty()) {
    const Result<verifier::Shard> shard = verifier::parse_shard(command.shard);
    if (!shard) return exit_with(fail_usage(shard.error()));
    const std::size_t whole = files->size();
    *files = verifier::take_shard(*files, *shard);
    print_note("shard " + command.shard + ": " + std::to_string(files->size()) + " of " + count_text(whole, "trace"));
  }

  std::optional<Program> program;
  if (const Status status = open_program(command, program); !status) return exit_with(fail_usage(status.error()));
  const Result<std::vector<Report>> reports = verify_all(*files, command, program ? &*program : nullptr);
  if (!reports) return exit_with(fail_usage(reports.error()));
  std::vector<int> codes;
  for (const Report& report : *reports) codes.push_back(report.exit_code(command.allow_truncated));
  if (command.json)
    print(verifier::report_json(*reports, command.allow_truncated));
  else if (reports->size() > 1)
    print_summary(*reports);
  if (const Status status = write_for_ci(*reports, command); !status) {
    print_error(status.error());
    codes.push_back(exit_usage);
  }
  return exit_with(worst_exit_code(codes));
}

}  // namespace

std::vector<std::string> verify_mode_names() {
  std::vector<std::string> names;
  for (const verifier::VerifyModeInfo& info : verifier::verify_modes) names.emplace_back(info.name);
  return names;
}

verifier::VerifyMode verify_mode_of(std::string_view name) {
  for (const verifier::VerifyModeInfo& info : verifier::verify_modes)
    if (info.name == name) return info.mode;
  return verifier::VerifyMode::replay;
}

void add_verify(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<VerifyCommand>();
  CLI::App* command =
      app.add_subcommand("verify", "Re-simulate a trace and report the first divergence")->group(group_session);
  command
      ->add_option("FILE", options->files,
                   "Traces, or directories: then every *.ttr in them; with --mode twice scenes too")
      ->required();
  command->add_option("--mode", options->mode, mode_help())
      ->check(CLI::IsMember(verify_mode_names()))
      ->capture_default_str();
  add_number(*command, "--from", options->from,
             "First tick to compare; the run begins at the last checkpoint before it");
  add_number(*command, "--to", options->to, "Last tick to compare; the trace is not read beyond it");
  command->add_flag("--to-end", options->to_end,
                    "With --mode restore: run from each checkpoint to the end, not only to the next checkpoint");
  add_number(*command, "--sync-test", options->sync_ticks,
             "After each N ticks go back to the state before them, by load, and run them again: both runs must end in "
             "one state, as after a rollback. In order, on one thread",
             {1, limits::tick_count_max});
  add_number(*command, "-j,--jobs", options->jobs,
             "Threads: for the files, and within one for the segments between its checkpoints (default: every core; "
             "1: in order from the start, without loading a checkpoint)",
             {1, 1024});
  add_threads_option(*command, options->thread_count);
  command
      ->add_option("--shard", options->shard,
                   "Part I of N of the sorted list of files: the parts of different machines make up the whole")
      ->type_name("I/N");
  command
      ->add_option("--against-build", options->other_build,
                   "Another build of ticktrue: run it on the same trace too; where the two part, both again with every "
                   "state of that tick")
      ->type_name("BINARY");
  command
      ->add_option("--against-plugin", options->other_plugin,
                   "Another library of the simulation that --plugin brings: as --against-build")
      ->type_name("LIB.so");
  command
      ->add_option(
          "--command", options->program,
          "The program that recorded the traces: it is run, and its session compares. {} stands for the trace; "
          "without it, --verify TRACE is added. A finding is run twice")
      ->type_name("WORDS");
  command
      ->add_option("--builds", options->builds,
                   "Folder with builds of the program. {build} in the words stands for the one that recorded the "
                   "trace, found by its build id. Without --command: {build} --verify TRACE")
      ->type_name("DIR");
  command
      ->add_option("--against-command", options->other_program,
                   "Another program that verifies the trace, too: the report says where the two differ. Each is "
                   "compared up to the tick at which it leaves the recording")
      ->type_name("WORDS");
  add_number(*command, "--timeout", options->timeout_s,
             "Seconds the other build or the program may take for a run (default 600)", {1, 1'000'000});
  add_number(*command, "--ticks", options->tick_count, "Of a scene: how many ticks", {1, limits::tick_count_max});
  command->add_option("--inputs", options->inputs, "Of a scene: inputs as JSON Lines, - for standard input")
      ->type_name("FILE");
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.verify/2)");
  command->add_option("--junit", options->junit, "Write the results as JUnit XML too, over an older file")
      ->type_name("OUT.xml");
  command
      ->add_option("--report", options->report_page,
                   "If a trace fails: write a page that shows the worst one (as `ticktrue report`), over an older file")
      ->type_name("OUT.html");
  command->add_flag("--github", options->github,
                    "Annotations for GitHub Actions on standard error, and a table for the page of the run");
  command->add_flag(
      "--git-bisect", options->git_bisect,
      "Exit with 125 (skip this commit) instead of 2, 4, 5 and 6: for `git bisect run`. 3 stays 3, which counts as "
      "bad, unless --allow-truncated makes it 0");
  command->add_flag("--allow-truncated", options->allow_truncated,
                    "A trace that ends early is fine if every tick it has matches");
  set_examples(*command,
               "ticktrue record 'stack?boxes=10' --ticks 600 -o stack.ttr\n"
               "ticktrue verify stack.ttr\n"
               "ticktrue verify stack.ttr --mode restore\n"
               "ticktrue verify stack.ttr --from 200 --to 300\n"
               "ticktrue verify stack.ttr --sync-test 7\n"
               "ticktrue verify 'stack?boxes=10' --mode twice --ticks 300\n"
               "ticktrue verify . -j 2 --json\n"
               "ticktrue verify . --shard 1/2 --junit results.xml --github\n"
               "ticktrue verify stack.ttr --against-build ticktrue\n"
               "ticktrue verify stack.ttr --report failure.html\n"
               "head -c 9000 stack.ttr > cut.ttr; ticktrue verify cut.ttr --allow-truncated\n"
               "git bisect run sh -c './dev build && build/release/ticktrue verify traces --git-bisect'",
               "For a program with a session:\n"
               "  ticktrue verify session_1.ttr session_2.ttr --command './mygame --verify {}'\n"
               "  ticktrue verify session_1.ttr session_2.ttr --builds old_builds");
  command->callback([options, &context] { context.exit_code = run_verify(*options); });
}

}  // namespace ticktrue::cli
