// Finds escaped processes in /proc, if the system has it.
// SPDX-License-Identifier: MIT
//
// Verified: processes whose parent has ended, in any session or group. Not verified: the children of these processes,
// and processes on systems without PR_SET_CHILD_SUBREAPER.
#include "verifier/runs/escaped.h"

#include "verifier/runs/child_end.h"

#ifdef TICKTRUE_HAS_FORK
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <charconv>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>
#endif

namespace ticktrue::verifier {

std::string escaped_text(const std::vector<EscapedChild>& escaped) {
  std::string text;
  for (const EscapedChild& child : escaped)
    text += (text.empty() ? "process " : ", process ") + std::to_string(child.id) + " (" + child.name + ")";
  return text;
}

void end_escaped(const std::vector<EscapedChild>& escaped) {
#ifdef __linux__
  for (const EscapedChild& child : escaped) {
    const auto id = static_cast<pid_t>(child.id);
    // 0: a running process that this process adopted.
    if (::waitpid(id, nullptr, WNOHANG) != 0) continue;
    ::kill(id, SIGKILL);
    ::waitpid(id, nullptr, 0);
  }
#else
  static_cast<void>(escaped);
#endif
}

#ifdef TICKTRUE_HAS_FORK
namespace {

std::mutex children_lock;
std::set<pid_t> own_children;
std::set<pid_t> named_children;

#ifdef __linux__

constexpr std::size_t process_name_size_max = 64;
// Stays true in a forked child, which adopts nothing itself: its orphans go to the process that watches it.
bool adopts_orphans = false;

struct ProcessEntry {
  std::string name;
  char state = '?';
  long parent = 0;
};

/// /proc/ID/stat: "ID (NAME) STATE PARENT ...", with any bytes in NAME.
std::optional<ProcessEntry> process_entry(const std::string& id) {
  std::ifstream in("/proc/" + id + "/stat", std::ios::binary);
  std::ostringstream whole;
  whole << in.rdbuf();
  const std::string text = whole.str();
  const std::size_t open = text.find('(');
  const std::size_t close = text.rfind(')');
  if (open == std::string::npos || close == std::string::npos || close < open) return std::nullopt;
  ProcessEntry entry;
  for (const char c : text.substr(open + 1, close - open - 1).substr(0, process_name_size_max))
    entry.name += c >= ' ' && c <= '~' ? c : '?';
  std::istringstream rest(text.substr(close + 1));
  rest >> entry.state >> entry.parent;
  return rest ? std::optional<ProcessEntry>(entry) : std::nullopt;
}

std::vector<EscapedChild> adopted_children() {
  std::vector<EscapedChild> found;
  std::error_code failure;
  for (std::filesystem::directory_iterator at("/proc", failure), end; !failure && at != end; at.increment(failure)) {
    const std::string word = at->path().filename().string();
    pid_t id = 0;
    const auto [last, code] = std::from_chars(word.data(), word.data() + word.size(), id);
    if (code != std::errc{} || last != word.data() + word.size()) continue;
    const std::optional<ProcessEntry> entry = process_entry(word);
    if (!entry || entry->parent != static_cast<long>(::getpid()) || own_children.count(id) != 0) continue;
    if (entry->state == 'Z') {
      ::waitpid(id, nullptr, WNOHANG);
      named_children.erase(id);
    } else if (named_children.insert(id).second) {
      found.push_back({static_cast<long>(id), entry->name});
    }
  }
  return found;
}

#endif

}  // namespace

pid_t fork_own_child() {
  // One lock for both: no other thread sees the child before it is registered.
  const std::lock_guard guard(children_lock);
#ifdef __linux__
  if (!adopts_orphans) {
    for (const EscapedChild& child : adopted_children()) own_children.insert(static_cast<pid_t>(child.id));
    adopts_orphans = ::prctl(PR_SET_CHILD_SUBREAPER, 1) == 0;
  }
#endif
  const pid_t id = ::fork();
  if (id > 0) {
    own_children.insert(id);
    named_children.erase(id);
  }
  return id;
}

void forget_own_child(pid_t id) {
  const std::lock_guard guard(children_lock);
  own_children.erase(id);
}

bool main_thread_has_ended(pid_t id) {
#ifdef __linux__
  const std::optional<ProcessEntry> entry = process_entry(std::to_string(id));
  return entry && entry->state == 'Z';
#else
  static_cast<void>(id);
  return false;
#endif
}

std::vector<EscapedChild> escaped_children() {
#ifdef __linux__
  const std::lock_guard guard(children_lock);
  return adopted_children();
#else
  return {};
#endif
}

#endif

}  // namespace ticktrue::verifier
