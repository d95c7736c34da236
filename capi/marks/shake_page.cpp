// The page of shim/page.h, mapped once, and the file of TICKTRUE_RESULT. Only Linux has the page.
// SPDX-License-Identifier: MIT
#include "capi/marks/shake_page.h"

#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "base/compiler/compiler.h"
#include "replay/format/mark_log.h"

#ifdef __linux__
#include <fcntl.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "shim/page.h"

/// In the preload library, if it is loaded. 0: the library is entered, 1: it is left, 2: it is left into a tick.
extern "C" TICKTRUE_WEAK void ticktrue_shim_library(int way);
/// In the preload library, if it is loaded: passes calls of these groups to the sink.
extern "C" TICKTRUE_WEAK void ticktrue_shim_calls(ticktrue::shim::CallSink sink, void* with, std::uint32_t groups);
#endif

namespace ticktrue::capi {

#ifdef __linux__
namespace {

constexpr int way_in = 0;
constexpr int way_out = 1;
constexpr int way_into_tick = 2;
bool leaves_into_tick = false;
void* followed_by = nullptr;  // the session that receives calls
thread_local const void* outermost = nullptr;

shim::SessionPart* map_page() {
  const char* path = std::getenv(shim::page_variable);
  if (path == nullptr) return nullptr;
  const int file = ::open(path, O_RDWR | O_CLOEXEC);
  if (file < 0) return nullptr;
  struct stat facts {};
  void* at = MAP_FAILED;
  if (::fstat(file, &facts) == 0 && static_cast<std::uint64_t>(facts.st_size) >= sizeof(shim::SessionPart))
    at = ::mmap(nullptr, sizeof(shim::SessionPart), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  ::close(file);
  if (at == MAP_FAILED) return nullptr;
  auto* page = static_cast<shim::SessionPart*>(at);
  return page->magic == shim::page_magic ? page : nullptr;
}

shim::SessionPart* page() {
  static shim::SessionPart* const found = map_page();
  return found;
}

void tell_position(std::uint64_t position) {
  if (shim::SessionPart* shared = page()) compiler::store_relaxed(shared->position, position);
}

}  // namespace

InLibrary::InLibrary() {
  shim::SessionPart* shared = page();
  if (shared == nullptr) return;
  const auto thread = static_cast<std::int32_t>(::syscall(SYS_gettid));
  if (compiler::load_relaxed(shared->library_thread) == thread) return;
  is_outermost_ = true;
  outermost = this;
  compiler::store_relaxed(shared->library_thread, thread);
  if (ticktrue_shim_library != nullptr) ticktrue_shim_library(way_in);
}

InLibrary::~InLibrary() {
  if (!is_outermost_) return;
  compiler::store_relaxed(page()->library_thread, 0);
  if (ticktrue_shim_library != nullptr) ticktrue_shim_library(leaves_into_tick ? way_into_tick : way_out);
  leaves_into_tick = false;
}

OutOfLibrary::OutOfLibrary() : frame_(outermost) {
  if (shim::SessionPart* shared = page()) compiler::store_relaxed(shared->library_thread, 0);
}

OutOfLibrary::~OutOfLibrary() {
  outermost = frame_;
  enter_library_again();
}

const void* library_frame() {
  return outermost;
}

void enter_library_again() {
  if (shim::SessionPart* shared = page())
    compiler::store_relaxed(shared->library_thread, static_cast<std::int32_t>(::syscall(SYS_gettid)));
}

void append_mapped() {
  const char* path = std::getenv(shim::mapped_variable);
  if (path == nullptr || *path == '\0') return;
  std::string text(4'096, '\0');
  const ssize_t size = ::readlink("/proc/self/exe", text.data(), text.size());
  text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  text += '\n';
  ::dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* lines) {
        const std::string name = info->dlpi_name == nullptr ? "" : info->dlpi_name;
        // The program itself has no name. Mappings of the kernel have no file.
        if (name.find('/') != std::string::npos) *static_cast<std::string*>(lines) += name + "\n";
        return 0;
      },
      &text);
  text += '\n';
  std::FILE* file = std::fopen(path, "ab");
  if (file == nullptr) return;
  std::fwrite(text.data(), 1, text.size(), file);
  std::fclose(file);
}

void tell_session() {
  if (shim::SessionPart* shared = page())
    compiler::store_relaxed(shared->session_process, static_cast<std::int32_t>(::getpid()));
}

void tell_tick_begin(std::uint64_t tick) {
  tell_position(2 * tick + 1);
  leaves_into_tick = true;
}

void tell_tick_end(std::uint64_t tick) {
  tell_position(2 * tick + 2);
}

std::string follow_calls(CallSink sink, void* with, bool& is_marking) {
  const char* asked = std::getenv(replay::calls_variable);
  if (asked == nullptr || *asked == 0) return "";
  const auto bit = [](shim::Group group) { return std::uint32_t{1} << static_cast<std::uint32_t>(group); };
  std::uint32_t groups = 0;
  std::istringstream words(asked);
  for (std::string word; std::getline(words, word, ',');) {
    if (word == "random")
      groups |= bit(shim::Group::random) | bit(shim::Group::rand);
    else if (word == "libm")
      groups |= bit(shim::Group::libm);
    else
      return std::string(replay::calls_variable) + ": found \"" + word + "\", expected random or libm";
  }
  if (ticktrue_shim_calls == nullptr)
    return std::string(replay::calls_variable) +
           ": the preload library is not loaded: LD_PRELOAD names libticktrue_shim.so";
  if (followed_by != nullptr) return "";
  followed_by = with;
  is_marking = true;
  ticktrue_shim_calls(sink, with, groups);
  return "";
}

void leave_calls(void* with) {
  if (followed_by != with) return;
  ticktrue_shim_calls(nullptr, nullptr, 0);
  followed_by = nullptr;
}

#else

InLibrary::InLibrary() = default;
InLibrary::~InLibrary() = default;
OutOfLibrary::OutOfLibrary() = default;
OutOfLibrary::~OutOfLibrary() {
  frame_ = nullptr;
}
const void* library_frame() {
  return nullptr;
}
void enter_library_again() {}
void tell_session() {}
void tell_tick_begin(std::uint64_t) {}
void tell_tick_end(std::uint64_t) {}
std::string follow_calls(CallSink, void*, bool&) {
  return "";
}
void leave_calls(void*) {}
void append_mapped() {}

#endif

void append_result(const std::string& json) {
  const char* path = std::getenv("TICKTRUE_RESULT");
  if (path == nullptr || *path == '\0' || json.empty()) return;
  std::string line;  // JSON has line breaks only between its parts
  for (std::size_t i = 0; i < json.size(); ++i) {
    if (json[i] == '\n')
      while (i + 1 < json.size() && json[i + 1] == ' ') ++i;
    else
      line += json[i];
  }
  line += '\n';
  std::FILE* file = std::fopen(path, "ab");
  if (file == nullptr) return;
  std::fwrite(line.data(), 1, line.size(), file);
  std::fclose(file);
}

}  // namespace ticktrue::capi
