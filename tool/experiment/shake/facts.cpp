// Collects facts about files, system programs and permissions.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/facts.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#if defined(__linux__) && defined(__x86_64__)
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <x86intrin.h>
#endif

#include "tool/experiment/shake/launch.h"
#include "verifier/runs/child.h"

namespace ticktrue::shake {
namespace {

namespace fs = std::filesystem;

constexpr double probe_time_s = 30;

verifier::ChildResult probe(std::vector<std::string> words) {
  verifier::ChildCommand command;
  command.argv = std::move(words);
  command.limits.time_s = probe_time_s;
  command.limits.output_size_max = std::size_t{1} << 20;
  return verifier::run_child(command);
}

bool succeeded(const verifier::ChildResult& result) {
  return result.end.how == verifier::ChildEnd::How::exited && result.end.exit_status == 0;
}

std::string beginning_of(const std::string& path, std::size_t size_max) {
  std::ifstream in(path, std::ios::binary);
  std::string text(size_max, '\0');
  in.read(text.data(), static_cast<std::streamsize>(size_max));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

std::string first_existing(const std::vector<std::string>& names) {
  for (const char* folder :
       {"/usr/lib/x86_64-linux-gnu/", "/usr/lib/aarch64-linux-gnu/", "/usr/lib64/", "/usr/lib/", "/usr/local/lib/"})
    for (const std::string& name : names) {
      std::error_code failure;
      if (fs::exists(folder + name, failure)) return folder + name;
    }
  return "";
}

void find_allocators(Facts& facts) {
  for (const std::vector<std::string>& names : {std::vector<std::string>{"libjemalloc.so.2"},
                                                {"libtcmalloc_minimal.so.4", "libtcmalloc_minimal.so"},
                                                {"libmimalloc.so.2.0", "libmimalloc.so.2", "libmimalloc.so"}})
    if (const std::string path = first_existing(names); !path.empty()) facts.allocators.push_back(path);
}

/// A POSIX locale with a decimal comma. Compiling a complete locale takes localedef seconds.
constexpr const char* comma_locale = R"(comment_char %
escape_char /
LC_IDENTIFICATION
title "decimal comma"
END LC_IDENTIFICATION
LC_CTYPE
copy "POSIX"
END LC_CTYPE
LC_COLLATE
copy "POSIX"
END LC_COLLATE
LC_NUMERIC
decimal_point ","
thousands_sep "."
grouping 3;3
END LC_NUMERIC
LC_MONETARY
copy "POSIX"
END LC_MONETARY
LC_TIME
copy "POSIX"
END LC_TIME
LC_MESSAGES
copy "POSIX"
END LC_MESSAGES
)";

/// Finds installed locales, or compiles one with localedef.
void find_locales(Facts& facts) {
  const std::string installed = probe({"locale", "-a"}).output;
  for (const char* name : {"de_DE", "tr_TR"})
    if (installed.find(std::string(name) + ".utf8") != std::string::npos)
      facts.locales.push_back(std::string(name) + ".UTF-8");
  if (!facts.locales.empty()) return;
  const std::string folder = facts.folder + "/locales";
  std::error_code failure;
  fs::create_directories(folder, failure);
  std::ofstream(folder + "/comma.source") << comma_locale;
  probe(
      {"localedef", "--no-archive", "--force", "-i", folder + "/comma.source", "-f", "UTF-8", folder + "/comma.UTF-8"});
  if (!fs::exists(folder + "/comma.UTF-8/LC_NUMERIC", failure)) return;
  facts.locales.emplace_back("comma.UTF-8");
  facts.locale_folder = folder;
}

/// The reason why `wrapper` cannot run a program; empty: it can.
std::string missing_namespace(std::vector<std::string> wrapper, const char* what) {
  wrapper.emplace_back("true");
  const verifier::ChildResult space = probe(std::move(wrapper));
  if (succeeded(space)) return "";
  return space.end.how == verifier::ChildEnd::How::not_started ? "unshare is not installed: apt-get install util-linux"
                                                               : std::string("this system does not permit ") + what;
}

/// Why a process's rdtsc does not end in a signal here. Some virtual machines accept the setting and do not trap.
std::string missing_cycle_trap() {
#if defined(__linux__) && defined(__x86_64__) && defined(PR_SET_TSC)
  const pid_t child = ::fork();
  if (child < 0) return "no process could be started to try whether rdtsc is trapped";
  if (child == 0) {
    ::signal(SIGSEGV, SIG_DFL);
    ::prctl(PR_SET_DUMPABLE, 0, 0, 0, 0);
    ::prctl(PR_SET_TSC, PR_TSC_SIGSEGV, 0, 0, 0);
    __rdtsc();
    ::_exit(0);
  }
  int status = 0;
  if (::waitpid(child, &status, 0) == child && WIFSIGNALED(status)) return "";
  return "this machine does not trap rdtsc";
#else
  return "x86-64 Linux only";
#endif
}

}  // namespace

std::vector<std::string> time_wrapper() {
  return {"unshare", "-rT", "--fork", "--kill-child", "--monotonic", "86400", "--boottime", "86400", "--"};
}

std::vector<std::string> user_wrapper() {
  return {"unshare", "--user", "--map-user=4711", "--map-group=4711", "--"};
}

std::vector<std::string> process_wrapper() {
  // Signals act differently on the first process of a namespace, so the program is the second process. A shell between
  // both would sort and extend the environment.
  return {"unshare", "-r", "--pid", "--fork", "--kill-child", "--", "unshare", "--fork", "--"};
}

bool processor_has(const std::string& feature) {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.compare(0, 5, "flags") == 0) return (line + " ").find(" " + feature + " ") != std::string::npos;
  return false;
}

Facts collect_facts(const std::vector<std::string>& words, const std::string& folder,
                    const std::function<bool(std::string_view name)>& is_asked) {
  Facts facts;
  facts.folder = folder;
  facts.program = words.empty() ? "" : find_program(words.front());
  std::error_code ignored;
  facts.is_this_tool = !facts.program.empty() && fs::equivalent(facts.program, "/proc/self/exe", ignored);
#ifdef __x86_64__
  facts.is_x86_64 = true;
#endif
  constexpr std::size_t size_max = std::size_t{32} << 20;
  const std::string file = beginning_of(facts.program, size_max);
  const auto names = [&](const char* text) { return file.find(text) != std::string::npos; };
  const bool is_script = file.compare(0, 2, "#!") == 0;
  const std::string head = file.substr(0, file.find('\n'));
  // The name is checked as well, because a program in PATH may be a script that starts the interpreter.
  const std::string word = words.empty() ? "" : fs::path(words.front()).filename().string();
  const auto is_interpreter = [](const std::string& text) {
    return text.find("python") != std::string::npos || text.find("perl") != std::string::npos;
  };
  facts.has_interpreter = names("PYTHONHASHSEED") || names("PERL_HASH_SEED") || names("libpython") ||
                          is_interpreter(word) || (is_script && is_interpreter(head));
  facts.has_math_library = facts.has_interpreter || names("openblas") || names("libmkl");
  find_allocators(facts);
  if (is_asked("locale")) find_locales(facts);
  if (is_asked("time_namespace")) facts.no_time_namespace = missing_namespace(time_wrapper(), "a time namespace");
  if (is_asked("user")) facts.no_user_namespace = missing_namespace(user_wrapper(), "a user namespace");
  if (is_asked("process_id")) facts.no_process_namespace = missing_namespace(process_wrapper(), "a process namespace");
  if (is_asked("cycle_counter")) facts.no_cycle_trap = missing_cycle_trap();
  if (facts.is_x86_64) facts.emulator = find_program("qemu-x86_64");
  return facts;
}

}  // namespace ticktrue::shake
