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

/// Settings that the child applies before the program starts. They have no effect on systems other than Linux.
struct ProcessSettings {
  unsigned long personality = 0;  // flags to add
  bool on_one_cpu = false;
  bool has_unlimited_stack = false;
  bool has_few_files = false;
  bool has_no_huge_pages = false;
  bool prints_to_null = false;
  bool prints_to_terminal = false;
  int terminal = -1;  // standard output, if it is a terminal; the launcher sets it
  int umask = -1;
};

enum class EnvironmentOrder : std::uint8_t { inherited, reversed };

/// The differences from a plain run. Default: none.
struct Conditions {
  shim::Settings settings;
  bool has_shim = true;
  std::vector<std::pair<std::string, std::optional<std::string>>> environment;
  EnvironmentOrder order = EnvironmentOrder::inherited;
  std::vector<std::string> tunables;  // entries of GLIBC_TUNABLES
  std::vector<std::string> preload;   // additional libraries
  std::vector<std::string> wrapper;   // command words before the program
  bool wrapper_reverses = false;      // the wrapper reverses the order of the environment
  std::string program;                // replaces the first word; empty: the first word
  ProcessSettings process;
  bool in_other_folder = false;
};

struct LaunchOptions {
  std::vector<std::string> words;  // the program and its arguments
  std::string folder;              // for the files of runs
  std::string shim_path;           // empty: no preload library
  std::string no_shim;             // then: which file was searched for, and where
  double time_s = 60;              // limit of one run
};

/// A run, and the data that the preload library wrote.
struct Run {
  Outcome outcome;
  shim::Page page{};
  std::vector<shim::LibmCall> libm_calls;  // if logged
};

class Launcher {
 public:
  explicit Launcher(LaunchOptions options) : options_(std::move(options)) {}
  Launcher(const Launcher&) = delete;
  Launcher& operator=(const Launcher&) = delete;
  ~Launcher() { end_escaped(); }

  /// May be called from any thread. Errors: io (files of the run).
  Result<Run> run(const Conditions& conditions);

  bool has_shim() const { return !options_.shim_path.empty(); }
  void drop_shim() { options_.shim_path.clear(); }
  void set_time_limit(double time_s) { options_.time_s = time_s; }
  std::uint64_t run_count() const { return run_count_; }
  const LaunchOptions& options() const { return options_; }
  /// Kills processes that runs left behind. Requires: no run is in progress, because its processes could be killed.
  void end_escaped();
  /// The processes that any run left behind.
  std::string escaped() const { return verifier::escaped_text(escaped_); }

 private:
  LaunchOptions options_;
  std::mutex lock_;
  std::uint64_t run_count_ = 0;
  std::vector<verifier::EscapedChild> escaped_;
  std::size_t ended_count_ = 0;  // the first entries, which have ended
};

/// "ticktrue shake TRACE -- PROGRAM ARGUMENTS", quoted for a shell. `words`: the program and arguments that the user
/// gave.
std::string shake_command(const std::string& trace, const std::vector<std::string>& words);

/// The file that `word` names. A word without a slash is searched in PATH.
std::string find_program(const std::string& word);

/// Makes a folder with a link to every entry of the current folder. Errors: io, limit.
Result<std::string> make_other_folder(const std::string& folder);

}  // namespace ticktrue::shake
