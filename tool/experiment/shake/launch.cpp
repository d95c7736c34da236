// The files of a run are a page (shim/page.h), the result of the session and the log of libm.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/launch.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "tool/experiment/shake/terminal.h"
#include "tool/output/cli.h"
#include "verifier/programs/command_words.h"
#include "verifier/report/report.h"
#include "verifier/runs/completion.h"

#ifdef __linux__
#include <fcntl.h>
#include <sched.h>
#include <sys/personality.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

extern "C" char** environ;
#endif

namespace ticktrue::shake {
namespace {

namespace fs = std::filesystem;

// Every run has an equal number of variables and bytes in its environment. The size of the environment would otherwise
// move the stack.
constexpr std::size_t added_variable_count = 16;
constexpr std::size_t added_size = std::size_t{8} << 10;
constexpr std::size_t output_size_max = std::size_t{16} << 20;
constexpr std::size_t other_folder_entries_max = 4096;

#ifdef __linux__

/// Runs between fork and exec.
void set_process(const void* with) {
  const auto& settings = *static_cast<const ProcessSettings*>(with);
  constexpr unsigned long query = 0xffffffff;
  if (settings.personality != 0) ::personality(static_cast<unsigned long>(::personality(query)) | settings.personality);
  if (settings.on_one_cpu) {
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    if (::sched_getaffinity(0, sizeof allowed, &allowed) == 0)
      for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
        if (!CPU_ISSET(cpu, &allowed)) continue;
        CPU_ZERO(&allowed);
        CPU_SET(cpu, &allowed);
        ::sched_setaffinity(0, sizeof allowed, &allowed);
        break;
      }
  }
  if (settings.has_unlimited_stack) {
    rlimit limit{};
    if (::getrlimit(RLIMIT_STACK, &limit) == 0) {
      limit.rlim_cur = limit.rlim_max;
      ::setrlimit(RLIMIT_STACK, &limit);
    }
  }
  if (settings.has_few_files) {
    constexpr rlim_t few = 128;
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur > few) {
      limit.rlim_cur = few;
      ::setrlimit(RLIMIT_NOFILE, &limit);
    }
  }
  if (settings.has_no_huge_pages) ::prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0);
  if (settings.umask >= 0) ::umask(static_cast<mode_t>(settings.umask));
  if (settings.terminal >= 0) ::dup2(settings.terminal, 1);
  if (settings.prints_to_null) {
    const int nothing = ::open("/dev/null", O_WRONLY);
    if (nothing >= 0) {
      ::dup2(nothing, 1);
      ::close(nothing);
    }
  }
}

std::vector<std::string> inherited_environment() {
  std::vector<std::string> variables;
  for (char** at = environ; at != nullptr && *at != nullptr; ++at) variables.emplace_back(*at);
  return variables;
}

#else

void set_process(const void*) {}
std::vector<std::string> inherited_environment() {
  return {};
}

#endif

std::string value_in(const std::vector<std::string>& variables, const std::string& name) {
  for (const std::string& variable : variables)
    if (variable.compare(0, name.size() + 1, name + "=") == 0) return variable.substr(name.size() + 1);
  return "";
}

/// An existing variable keeps its position. A new value would otherwise change the order of the following variables.
void set_in(std::vector<std::string>& variables, const std::string& name, const std::optional<std::string>& value) {
  const auto is_it = [&](const std::string& variable) { return variable.compare(0, name.size() + 1, name + "=") == 0; };
  const auto first = std::find_if(variables.begin(), variables.end(), is_it);
  if (!value) {
    std::erase_if(variables, is_it);
  } else if (first == variables.end()) {
    variables.push_back(name + "=" + *value);
  } else {
    *first = name + "=" + *value;
    variables.erase(std::remove_if(first + 1, variables.end(), is_it), variables.end());
  }
}

std::size_t size_of(const std::vector<std::string>& variables) {
  std::size_t size = 0;
  for (const std::string& variable : variables) size += variable.size() + 1;
  return size;
}

std::string joined(const std::vector<std::string>& words, char separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : std::string(1, separator)) + word;
  return text;
}

std::vector<std::string> environment_of(const Conditions& conditions, const LaunchOptions& options,
                                        const std::string& page, const std::string& result) {
  const std::vector<std::string> inherited = inherited_environment();
  std::vector<std::string> variables = inherited;
  if (conditions.order == EnvironmentOrder::reversed) variables.assign(inherited.rbegin(), inherited.rend());
  for (const auto& [name, value] : conditions.environment) set_in(variables, name, value);
  std::vector<std::string> preload = conditions.preload;
  if (conditions.has_shim && !options.shim_path.empty()) preload.push_back(options.shim_path);
  if (const std::string own = value_in(inherited, "LD_PRELOAD"); !own.empty()) preload.push_back(own);
  if (!preload.empty()) set_in(variables, "LD_PRELOAD", joined(preload, ':'));
  std::vector<std::string> tunables = conditions.tunables;
  if (const std::string own = value_in(inherited, "GLIBC_TUNABLES"); !own.empty()) tunables.push_back(own);
  if (!tunables.empty()) set_in(variables, "GLIBC_TUNABLES", joined(tunables, ':'));
  set_in(variables, shim::page_variable, page);
  set_in(variables, "TICKTRUE_RESULT", result);
  set_in(variables, verifier::completion_variable, "0");  // run_child sets the number at this position
  const std::size_t count = inherited.size() + added_variable_count;
  for (int i = 0; variables.size() + 1 < count; ++i) variables.push_back("TICKTRUE_SPACE_" + std::to_string(i) + "=");
  std::string last = "TICKTRUE_SPACE=";
  const std::size_t size = size_of(inherited) + added_size;
  if (const std::size_t now = size_of(variables) + last.size() + 1; now < size) last.append(size - now, 'x');
  variables.push_back(last);
  if (conditions.wrapper_reverses) std::reverse(variables.begin(), variables.end());
  return variables;
}

std::string text_of_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

bool write_page(const std::string& path, const shim::Settings& settings) {
  auto page = std::make_unique<shim::Page>();
  page->session.magic = shim::page_magic;
  page->size = sizeof(shim::Page);
  page->settings = settings;
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(page.get()), sizeof *page);
  return static_cast<bool>(out.flush());
}

bool read_page(const std::string& path, shim::Page& page) {
  std::ifstream in(path, std::ios::binary);
  return static_cast<bool>(in.read(reinterpret_cast<char*>(&page), sizeof page));
}

std::vector<shim::LibmCall> read_libm_log(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::uint64_t count = 0;
  if (!in.read(reinterpret_cast<char*>(&count), sizeof count)) return {};
  std::vector<shim::LibmCall> calls(static_cast<std::size_t>(std::min(count, shim::libm_log_count_max)));
  in.read(reinterpret_cast<char*>(calls.data()), static_cast<std::streamsize>(calls.size() * sizeof(shim::LibmCall)));
  return calls;
}

std::vector<std::string> words_of(const Conditions& conditions, const LaunchOptions& options) {
  std::vector<std::string> words = conditions.wrapper;
  words.insert(words.end(), options.words.begin(), options.words.end());
  std::string& first = words[conditions.wrapper.size()];
  // An emulator does not search PATH.
  if (const std::string program = find_program(first); !conditions.wrapper.empty() && !program.empty()) first = program;
  if (!conditions.program.empty()) first = conditions.program;
  return words;
}

}  // namespace

std::string shake_command(const std::string& trace, const std::vector<std::string>& words) {
  return "ticktrue shake " + verifier::shell_word(trace) + " -- " + verifier::command_line_of(words);
}

std::string find_program(const std::string& word) {
  std::error_code failure;
  if (word.find('/') != std::string::npos) return fs::exists(word, failure) ? word : "";
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string candidate = (folder.empty() ? "." : folder) + "/" + word;
    if (fs::exists(candidate, failure) && !fs::is_directory(candidate, failure)) return candidate;
  }
  return "";
}

Result<Run> Launcher::run(const Conditions& conditions) {
  if (cli::stop_requested()) return Error{ErrorCode::io, "stopped", ""};
  std::string name;
  {
    const std::lock_guard guard(lock_);
    name = std::to_string(run_count_++);
  }
  // Paths have the same length in all runs.
  constexpr std::size_t digits = 6;
  name.insert(0, digits - std::min(digits, name.size()), '0');
  const std::string page = options_.folder + "/run-" + name;
  const std::string result = page + ".json";
  const std::string libm_log = page + ".libm";
  const auto failed = [&](const std::string& path) {
    return Error{ErrorCode::io, path + ": cannot be written", "--out names a folder for the files of runs"};
  };
  if (!write_page(page, conditions.settings)) return failed(page);
  if (conditions.settings.libm_log != 0) {
    std::ofstream(libm_log, std::ios::binary).flush();
    std::error_code failure;
    fs::resize_file(libm_log, sizeof(shim::LibmLog), failure);
    if (failure) return failed(libm_log);
  }
  verifier::ChildCommand command;
  command.argv = words_of(conditions, options_);
  command.inherited = environment_of(conditions, options_, page, result);
  std::optional<Terminal> terminal;
  ProcessSettings process = conditions.process;
  if (process.prints_to_terminal) process.terminal = terminal.emplace().descriptor();
  command.prepare = set_process;
  command.prepare_with = &process;
  command.limits.time_s = options_.time_s;
  command.limits.output_size_max = output_size_max;
  if (conditions.in_other_folder) {
    const auto folder = make_other_folder(options_.folder);
    if (!folder) return folder.error();
    command.cwd = *folder;
  }
  const verifier::ChildResult child = verifier::run_child(command);
  Run run;
  const bool has_page = read_page(page, run.page) && run.page.session.magic == shim::page_magic;
  const std::string written = text_of_file(result);
  // `ticktrue verify --json` and similar programs print their report.
  run.outcome = judge(child, command.limits, written.empty() ? child.output : written, has_page ? &run.page : nullptr);
  if (conditions.settings.libm_log != 0) run.libm_calls = read_libm_log(libm_log);
  std::error_code ignored;
  for (const std::string& path : {page, result, libm_log}) fs::remove(path, ignored);
  const std::lock_guard guard(lock_);
  escaped_.insert(escaped_.end(), run.outcome.escaped.begin(), run.outcome.escaped.end());
  return run;
}

void Launcher::end_escaped() {
  const std::lock_guard guard(lock_);
  const auto first = escaped_.begin() + static_cast<std::ptrdiff_t>(std::exchange(ended_count_, escaped_.size()));
  verifier::end_escaped({first, escaped_.end()});
}

Result<std::string> make_other_folder(const std::string& folder) {
  static std::mutex lock;
  const std::lock_guard guard(lock);
  const std::string path = folder + "/another folder with a longer name";
  std::error_code failure;
  if (fs::exists(path, failure)) return path;
  const auto refused = [&](const std::string& what) { return Error{ErrorCode::io, path + ": " + what, ""}; };
  fs::create_directory(path, failure);
  if (failure) return refused("cannot be made: " + failure.message());
  std::size_t count = 0;
  for (fs::directory_iterator at(".", failure), end; !failure && at != end; at.increment(failure)) {
    if (++count > other_folder_entries_max) return refused("the folder of the program has too many entries");
    std::error_code ignored;
    fs::create_symlink(fs::absolute(at->path(), ignored), path + "/" + at->path().filename().string(), ignored);
  }
  return path;
}

}  // namespace ticktrue::shake
