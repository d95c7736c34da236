// The words of a recorded program that runs again, and the preload library beside this program.
// SPDX-License-Identifier: MIT
#include "tool/cli/session/program_runs.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/plain_text.h"
#include "tool/output/cli.h"
#include "verifier/plugins/plugin.h"
#include "verifier/runs/child.h"

namespace ticktrue::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* trace_mark = "{trace}";

std::string own_folder() {
  return fs::path(own_program()).parent_path().string();
}

/// This tool, with the plug-ins that are loaded.
std::vector<std::string> own_words() {
  std::vector<std::string> words{own_program()};
  for (const SimulationInfo* info : verifier::plugin_simulations())
    words.insert(words.end(), {"--plugin", verifier::plugin_path(info->name)});
  return words;
}

/// Without the words before it that each message begins with.
std::string message_of(const verifier::ChildResult& child) {
  constexpr std::string_view beginning = "ticktrue: error: ";
  const std::size_t at = child.message.rfind(beginning);
  if (at == std::string::npos) return "ended with status " + std::to_string(child.end.exit_status);
  const std::string line = child.message.substr(at + beginning.size());
  return plain_line(line.substr(0, line.find('\n')));
}

}  // namespace

std::string own_program() {
  std::error_code failed;
  const fs::path path = fs::read_symlink("/proc/self/exe", failed);
  return failed ? std::string() : path.string();
}

void set_shim(shake::LaunchOptions& launch) {
  const std::string name = "libticktrue_shim.so";
  std::string searched;
  for (const char* folder : {"", "/../lib", "/../lib/x86_64-linux-gnu", "/../lib/aarch64-linux-gnu", "/../lib64"}) {
    std::error_code failed;
    const fs::path place = fs::path(own_folder() + folder).lexically_normal();
    const fs::path path = fs::canonical(place / name, failed);
    if (!failed) {
      launch.shim_path = path.string();
      return;
    }
    searched += (searched.empty() ? "" : ", ") + place.string();
  }
  launch.no_shim = "preload library: found none, expected " + name + " in " + searched;
}

void add_program_words(CLI::App& command, ProgramOptions& options) {
  command.add_option("TRACE", options.trace, "A trace that the program recorded")->required();
  command.add_option("PROGRAM", options.words,
                     "Behind --: the program and its arguments. {trace} stands for the trace; without it, "
                     "--verify TRACE is added");
}

void add_program_options(CLI::App& command, ProgramOptions& options, const std::string& schema) {
  add_number(command, "--timeout", options.timeout_s, "Seconds that a run may take (default 600)", {1, 1'000'000});
  command.add_flag("--json", options.json, "One JSON object (schema " + schema + ")");
  command.add_option("--out", options.folder, "Folder for the files of runs; it is kept (default: a temporary one)")
      ->type_name("DIR");
}

Result<ProgramRun> prepare_run(const std::string& command, const ProgramOptions& options) {
  if (options.words.empty())
    return Error{ErrorCode::usage, command + ": found no program, expected TRACE -- PROGRAM ARGUMENTS",
                 "behind -- stands the program: see `ticktrue " + command + " --help`"};
  std::error_code failed;
  const std::string trace = fs::canonical(options.trace, failed).string();
  if (failed) return Error{ErrorCode::io, options.trace + ": " + failed.message(), ""};
  Result<verifier::RunFolder> folder = verifier::RunFolder::make("ticktrue-" + command, options.folder);
  if (!folder) return folder.error();
  ProgramRun run{trace, words_with_trace(options.words, trace), std::move(*folder), {}};
  run.launch.folder = run.folder.path();
  set_shim(run.launch);
  run.launch.time_s = static_cast<double>(options.timeout_s);
  catch_stop_signals();
  return run;
}

std::vector<std::string> words_with_trace(const std::vector<std::string>& words, const std::string& trace) {
  std::vector<std::string> with = words;
  bool has_mark = false;
  for (std::string& word : with)
    for (std::size_t at = word.find(trace_mark); at != std::string::npos; at = word.find(trace_mark)) {
      word.replace(at, std::string(trace_mark).size(), trace);
      has_mark = true;
    }
  if (!has_mark) with.insert(with.end(), {"--verify", trace});
  return with;
}

std::vector<std::string> verify_words() {
  std::vector<std::string> words = own_words();
  words.insert(words.end(), {"verify", trace_mark, "-j", "1", "--json"});
  return words;
}

Result<std::string> record_scene(const std::string& scene, std::uint64_t tick_count, const std::string& folder) {
  const std::string trace = folder + "/scene.ttr";
  verifier::ChildCommand command;
  command.argv = own_words();
  command.argv.insert(command.argv.end(),
                      {"record", scene, "--ticks", std::to_string(tick_count), "--force", "-o", trace});
  const verifier::ChildResult child = verifier::run_child(command);
  const std::string failure = verifier::child_failure(child, command.limits);
  if (!failure.empty()) return Error{ErrorCode::usage, scene + ": recording it " + failure, ""};
  if (child.end.exit_status != exit_ok)
    return Error{ErrorCode::usage, message_of(child),
                 "without a program, shake takes a trace or a scene: `ticktrue scenes` lists those that are built in"};
  return trace;
}

}  // namespace ticktrue::cli
