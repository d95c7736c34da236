// What the commands need that run a recorded program again: its words, the preload library.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "tool/experiment/shake/launch.h"
#include "verifier/runs/run_folder.h"

namespace CLI {
class App;
}

namespace ticktrue::cli {

/// The path of this tool; empty where the system does not say.
std::string own_program();

/// Sets the preload library of this build or installation, or the text that says where it was searched.
void set_shim(shake::LaunchOptions& launch);

/// What `trail` and `unsaved` take alike.
struct ProgramOptions {
  std::string trace;
  std::vector<std::string> words;  // of the program
  std::uint64_t timeout_s = 600;
  bool json = false;
  std::string folder;  // empty: a temporary one
};
/// TRACE and PROGRAM.
void add_program_words(CLI::App& command, ProgramOptions& options);
/// --timeout, --json, --out.
void add_program_options(CLI::App& command, ProgramOptions& options, const std::string& schema);

/// A program that may run.
struct ProgramRun {
  std::string trace;               // absolute
  std::vector<std::string> words;  // with the trace in them
  verifier::RunFolder folder;
  shake::LaunchOptions launch;  // without the words
};
/// Catches stop signals, so that the folder is removed. Errors: usage, io.
Result<ProgramRun> prepare_run(const std::string& command, const ProgramOptions& options);

/// The program's words with the trace in them: in place of {trace}, else behind --verify at their end.
std::vector<std::string> words_with_trace(const std::vector<std::string>& words, const std::string& trace);

/// This tool with the plug-ins that are loaded, as `verify` of {trace} that prints its report as JSON.
std::vector<std::string> verify_words();

/// Records a scene, or a setup of the plug-in that is loaded, by this tool itself. Gives the path of the trace in the
/// folder. Errors: usage (what this tool says of it).
Result<std::string> record_scene(const std::string& scene, std::uint64_t tick_count, const std::string& folder);

}  // namespace ticktrue::cli
