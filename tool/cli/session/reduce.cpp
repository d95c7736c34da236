// `ticktrue reduce`: makes a failing session as small as it stays failing in the same way.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/reduce.h"

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <system_error>

#include "base/limits.h"
#include "replay/trace_reader.h"
#include "tool/cli/commands.h"
#include "tool/experiment/reduce/foreign_session.h"
#include "tool/experiment/reduce/program_judge.h"
#include "tool/experiment/reduce/reduce_report.h"
#include "tool/experiment/reduce/result_folder.h"
#include "tool/experiment/reduce/session_file.h"
#include "tool/output/progress.h"
#include "tool/session/session_inputs.h"
#include "tool/session/simulations.h"
#include "verifier/runs/data_file.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::cli {
namespace {

using reduce::Failure;
using reduce::Predicate;
using soak::SoakCase;

struct ReduceCommand {
  std::string session;
  std::string inputs;
  std::optional<std::uint64_t> tick_count;
  bool not_finite = false;
  bool check_caches = false;
  bool crosscheck = false;
  std::string expect;
  std::string check;
  std::string other_build;
  std::string program;
  std::uint64_t time_s = 600;
  std::uint64_t timeout_s = 60;
  bool is_loose = false;
  bool any_method = false;
  bool once = false;
  bool json = false;
  std::string output;
};

using MadePredicate = Result<std::unique_ptr<Predicate>>;

Result<SoakCase> read_subject(const ReduceCommand& command) {
  if (is_trace_argument(command.session)) {
    if (!command.inputs.empty())
      return Error{ErrorCode::usage, "--inputs: a trace has its own inputs: found --inputs " + command.inputs, ""};
    return reduce::read_trace_session(command.session, command.tick_count);
  }
  const Result<engine::Scene> scene = load_session_scene(command.session);
  if (!scene) return scene.error();
  return reduce::read_session(*scene, command.inputs, command.tick_count);
}

/// A path as it is from any folder; a name that PATH finds stays a name.
std::string from_anywhere(const std::string& program) {
  if (program.find('/') == std::string::npos) return program;
  std::error_code failed;
  const std::filesystem::path path = std::filesystem::canonical(program, failed);
  return failed ? program : path.string();
}

std::unique_ptr<Predicate> ask_build(const ReduceCommand& command, const std::string& folder) {
  const std::string tool = from_anywhere(command.other_build);
  reduce::OtherProgram other;
  other.judge = reduce::program_judge({tool, "verify", reduce::trace_mark, "--json", "-j", "1"}, folder,
                                      static_cast<double>(command.timeout_s));
  other.folder = folder;
  other.words = {"--against-build", tool};
  const std::string word = verifier::shell_word(tool);
  other.show_line = std::string("ticktrue verify ") + reduce::trace_mark + " --against-build " + word;
  other.test_line = "\"${TICKTRUE:-" + word + "}\" verify " + reduce::trace_mark;
  return differs_elsewhere(other, engine::make_engine);
}

std::unique_ptr<Predicate> ask_program(const ReduceCommand& command, const std::string& folder) {
  reduce::OtherProgram other;
  other.show_line = other.test_line = command.program;
  other.judge = reduce::program_judge({"sh", "-c", command.program}, folder, static_cast<double>(command.timeout_s));
  other.folder = folder;
  other.words = {"--command", command.program};
  return differs_elsewhere(other, engine::make_engine);
}

MadePredicate expectation(const std::string& text) {
  Result<tool::Expression> expression = tool::Expression::parse(text, "--expect");
  if (!expression) return expression.error();
  return reduce::broken_expectation(*std::move(expression), engine::make_engine);
}

MadePredicate check_of(const ReduceCommand& command, const std::string& folder) {
  soak::OracleOptions options;
  options.make = engine::make_engine;
  options.files.path = folder + "/world.ttr";
  std::error_code failed;
  options.files.tool = std::filesystem::read_symlink("/proc/self/exe", failed).string();
  return reduce::oracle_check(command.check, options);
}

/// The one that was asked for. Errors: usage.
MadePredicate predicate_of(const ReduceCommand& command, const std::string& folder) {
  const int count = int{command.not_finite} + int{command.check_caches} + int{command.crosscheck} +
                    int{!command.expect.empty()} + int{!command.check.empty()} + int{!command.other_build.empty()} +
                    int{!command.program.empty()};
  if (count != 1)
    return Error{ErrorCode::usage,
                 "reduce: found " + std::to_string(count) + " options that say what fails, expected one",
                 "--not-finite, --expect, --check-caches, --check, --against-build, --crosscheck or --command"};
  if (command.not_finite) return reduce::not_finite(engine::make_engine);
  if (command.check_caches) return reduce::stale_cache(engine::make_engine);
  if (command.crosscheck) return reduce::crosscheck_differs();
  if (!command.expect.empty()) return expectation(command.expect);
  if (!command.check.empty()) return check_of(command, folder);
  if (!command.program.empty()) {
    if (command.program.find(reduce::trace_mark) != std::string::npos) return ask_program(command, folder);
    return Error{ErrorCode::usage, "--command: found \"" + command.program + "\", expected {} where the trace belongs",
                 "as in --command './mygame --verify {}'"};
  }
  return ask_build(command, folder);
}

int run_once(const ReduceCommand& command, const SoakCase& session, Predicate& predicate) {
  const Result<std::optional<Failure>> found = predicate.examine(session);
  if (!found) return fail_usage(found.error());
  print(command.json ? reduce::once_json(command.session, *found) : reduce::once_text(command.session, *found));
  return *found ? exit_finding : exit_ok;
}

int run_search(const ReduceCommand& command, const SoakCase& session, Predicate& predicate) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  const auto passed_s = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  catch_stop_signals();
  Progress progress("reduce " + command.session, 0, "runs");
  reduce::ReduceOptions options;
  options.make = engine::make_engine;
  options.is_loose = command.is_loose;
  options.any_method = command.any_method;
  options.stops = [&] { return stop_requested() || passed_s() > static_cast<double>(command.time_s); };
  options.progress = [&](std::size_t run_count, const SoakCase&) { progress.update(run_count); };
  const Result<reduce::ReduceResult> result = reduce::reduce(session, predicate, options);
  progress.finish();
  if (!result) return fail_usage(result.error());
  const auto folder = reduce::write_result(*result, predicate, options, command.output);
  if (!folder) return fail_usage(folder.error());
  const reduce::ReduceSubject subject{command.session, &session, passed_s()};
  print(command.json ? reduce::reduce_json(*result, subject, *folder) : reduce::reduce_text(*result, subject, *folder));
  return exit_ok;
}

/// Whether the session is a trace of another simulation than the engine.
Result<bool> is_foreign(const ReduceCommand& command) {
  if (!is_trace_argument(command.session)) return false;
  const Result<replay::TraceReader> reader = replay::TraceReader::open(command.session);
  if (!reader) return reader.error();
  return reader->setup().simulation != engine::simulation_name;
}

/// What a plug-in's session needs. Errors: usage.
Result<const SimulationInfo*> recorder_of(const ReduceCommand& command, const reduce::ForeignSession& session) {
  const SimulationInfo* recorder = tool::find_simulation(session.setup.simulation);
  if (recorder == nullptr)
    return Error{
        ErrorCode::usage,
        command.session + ": simulation: found " + session.setup.simulation + ", expected " + tool::simulation_names(),
        "--plugin LIB.so loads the simulation that records the session anew"};
  if (!command.program.empty() && !command.once) return recorder;
  return Error{ErrorCode::usage, "reduce: found no --command and -o, expected them for a session of a plug-in",
               "as in --command 'ticktrue --plugin other.so verify {} --json'"};
}

Status write_foreign(const ReduceCommand& command, const reduce::ForeignResult& result, const SimulationInfo& recorder,
                     const std::string& shown) {
  std::error_code failed;
  std::filesystem::create_directories(command.output, failed);
  if (failed) return Error{ErrorCode::io, command.output + ": cannot be made: " + failed.message(), ""};
  if (const Status status = record_foreign(result.smallest, recorder, command.output + "/trace.ttr"); !status)
    return status;
  if (const Status status =
          verifier::write_data_file(command.output + "/inputs.jsonl", foreign_inputs_text(result.smallest));
      !status)
    return status;
  return verifier::write_data_file(command.output + "/command", shown + "\n");
}

int run_foreign(const ReduceCommand& command, const std::string& folder) {
  const Result<reduce::ForeignSession> session = reduce::read_foreign_session(command.session, command.tick_count);
  if (!session) return fail_usage(session.error());
  const auto recorder = recorder_of(command, *session);
  if (!recorder) return fail_usage(recorder.error());
  catch_stop_signals();
  reduce::ReduceOptions options;
  options.is_loose = command.is_loose;
  options.stops = stop_requested;
  const std::vector<std::string> words{"sh", "-c", command.program};
  const auto judge = reduce::program_judge(words, folder, static_cast<double>(command.timeout_s));
  const auto result = reduce_foreign(*session, **recorder, judge, folder, options);
  if (!result) return fail_usage(result.error());
  const std::string shown =
      reduce::words_with_trace({command.program}, verifier::shell_word(command.output + "/trace.ttr")).front();
  if (const Status written = write_foreign(command, *result, **recorder, shown); !written)
    return fail_usage(written.error());
  print(reduce::once_text(command.session, result->last) + "  inputs   " + std::to_string(session->input_count()) +
        " -> " + std::to_string(result->smallest.input_count()) + "\n  ticks    " +
        std::to_string(session->ticks.size()) + " -> " + std::to_string(result->smallest.ticks.size()) +
        "\n  search   " + std::to_string(result->run_count) + " runs\n  again    " + shown + "\n");
  return exit_ok;
}

int run_reduce(const ReduceCommand& command) {
  if (command.once == !command.output.empty())
    return fail_usage(Error{
        ErrorCode::usage,
        std::string("reduce: found ") + (command.once ? "both" : "neither") + " -o and --once, expected one of them",
        "-o DIR names the folder of the result; --once reduces nothing"});
  const auto folder = verifier::RunFolder::make("ticktrue-reduce", "");
  if (!folder) return fail_usage(folder.error());
  const Result<bool> foreign = is_foreign(command);
  if (!foreign) return fail_usage(foreign.error());
  if (*foreign) return run_foreign(command, folder->path());
  const MadePredicate predicate = predicate_of(command, folder->path());
  if (!predicate) return fail_usage(predicate.error());
  const Result<SoakCase> session = read_subject(command);
  if (!session) return fail_usage(session.error());
  return command.once ? run_once(command, *session, **predicate) : run_search(command, *session, **predicate);
}

std::string expect_help() {
  std::string text =
      "An expression that holds before the first tick and is broken later. Names, each also with _start "
      "for the value before the first tick:";
  for (const tool::WorldValueInfo& info : tool::world_values) text += " " + std::string(info.name);
  return text;
}

void add_predicates(CLI::App& command, ReduceCommand& options) {
  command.add_flag("--not-finite", options.not_finite, "Fails: a value is NaN or infinite");
  command.add_option("--expect", options.expect, expect_help())->type_name("EXPR");
  command.add_flag("--check-caches", options.check_caches,
                   "Fails: a tick with cached structures differs from the same tick without");
  command.add_option("--check", options.check, "Fails: this check of `ticktrue soak`, or variant as restore=57")
      ->type_name("NAME");
  command.add_option("--against-build", options.other_build, "Fails: this other ticktrue gives other bits")
      ->type_name("TOOL");
  command.add_flag("--crosscheck", options.crosscheck, "Fails: a criterion of `ticktrue crosscheck` differs");
  command
      .add_option("--command", options.program,
                  "Fails: this program says so of the trace that stands for {}; it verifies traces of the engine")
      ->type_name("COMMAND");
}

}  // namespace

void add_reduce(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<ReduceCommand>();
  CLI::App* command = app.add_subcommand("reduce", "Make a failing session as small as it still fails in the same way")
                          ->group(group_session);
  command->add_option("SESSION", options->session, "A scene, or a trace of the engine or of a plug-in")->required();
  command->add_option("--inputs", options->inputs, "Inputs of a scene as JSON Lines")->type_name("FILE");
  add_number(*command, "--ticks", options->tick_count, "Ticks of the session; default: to its end",
             {1, limits::tick_count_max});
  add_predicates(*command, *options);
  command->add_option("-o,--output", options->output, "Folder for the result; made if needed")->type_name("DIR");
  command->add_flag("--once", options->once, "Reduce nothing: tell whether the session fails");
  command->add_flag("--loose", options->is_loose,
                    "A failure in another stage, table, column or criterion counts as the same");
  command->add_flag("--any-method", options->any_method,
                    "Solver, substeps, precision and other settings of the method may become the defaults");
  add_number(*command, "--time", options->time_s, "End the search after so many seconds (default 600)", {1, 1'000'000});
  add_number(*command, "--timeout", options->timeout_s, "Seconds that another program may take (default 60)",
             {1, 1'000'000});
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.reduce/1)");
  set_examples(
      *command,
      "ticktrue reduce 'mixed_pile?bodies=60' --ticks 100 --expect 'overlap < overlap_start + 0.03' -o reduced\n"
      "ticktrue record 'stack?boxes=3' --ticks 30 -o stack.ttr\n"
      "ticktrue reduce stack.ttr --not-finite --once\n"
      "ticktrue reduce stack.ttr --against-build ticktrue --once\n"
      "ticktrue reduce stack.ttr --command 'ticktrue verify {}' --once",
      "Exit codes: 0 reduced. 2 the session does not fail, or usage. With --once: 1 it fails, 0 it does not.");
  command->callback([options, &context] { context.exit_code = run_reduce(*options); });
}

}  // namespace ticktrue::cli
