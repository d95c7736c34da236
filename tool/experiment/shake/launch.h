// Runs a program once under given conditions: environment, process settings, preload library.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "shim/page.h"
#include "tool/experiment/shake/outcome.h"

namespace ticktrue::shake {

/// Set in the child before the program begins. Elsewhere than on Linux: nothing.
struct ProcessSettings {
  unsigned long personality = 0;  // flags that are added
  bool on_one_cpu = false;
  bool has_unlimited_stack = false;
  bool has_few_files = false;
  bool has_no_huge_pages = false;
  bool prints_to_null = false;
  bool prints_to_terminal = false;
  int terminal = -1;  // standard output, where it is a terminal: set by the launcher
  int umask = -1;
};

enum class EnvironmentOrder : std::uint8_t { inherited, reversed };

/// What differs from a plain run. Default: nothing.
struct Conditions {
  shim::Settings settings;
  bool has_shim = true;
  std::vector<std::pair<std::string, std::optional<std::string>>> environment;
  EnvironmentOrder order = EnvironmentOrder::inherited;
  std::vector<std::string> tunables;  // of GLIBC_TUNABLES
  std::vector<std::string> preload;   // further libraries
  std::vector<std::string> wrapper;   // words before the program
  bool wrapper_reverses = false;      // it hands the environment on in the reverse order
  std::string program;                // in place of the first word; empty: that word
  ProcessSettings process;
  bool in_other_folder = false;
};

struct LaunchOptions {
  std::vector<std::string> words;  // the program and its arguments
  std::string folder;              // for the files of runs
  std::string shim_path;           // empty: there is none
  double time_s = 60;              // of a run
};

/// A run, with what the preload library left behind.
struct Run {
  Outcome outcome;
  shim::Page page{};
  std::vector<shim::LibmCall> libm_calls;  // where they were logged
};

class Launcher {
 public:
  explicit Launcher(LaunchOptions options) : options_(std::move(options)) {}
  Launcher(const Launcher&) = delete;
  Launcher& operator=(const Launcher&) = delete;
  ~Launcher() { end_escaped(); }

  /// From any thread. Errors: io (files of the run).
  Result<Run> run(const Conditions& conditions);

  bool has_shim() const { return !options_.shim_path.empty(); }
  void drop_shim() { options_.shim_path.clear(); }
  void set_time_limit(double time_s) { options_.time_s = time_s; }
  std::uint64_t run_count() const { return run_count_; }
  const LaunchOptions& options() const { return options_; }
  /// Kills what runs left behind. Requires: no run is under way, whose processes could be among them.
  void end_escaped();
  /// What was left behind, of all runs.
  std::string escaped() const { return verifier::escaped_text(escaped_); }

 private:
  LaunchOptions options_;
  std::mutex lock_;
  std::uint64_t run_count_ = 0;
  std::vector<verifier::EscapedChild> escaped_;
  std::size_t ended_count_ = 0;  // of them, the first
};

/// "ticktrue shake TRACE -- PROGRAM ARGUMENTS", for a shell. `words`: of the program, as a user gave them.
std::string shake_command(const std::string& trace, const std::vector<std::string>& words);

/// The file that the first word names, by PATH where it has no slash.
std::string find_program(const std::string& word);

/// A folder in which every entry of the present one is linked. Errors: io, limit.
Result<std::string> make_other_folder(const std::string& folder);

}  // namespace ticktrue::shake
