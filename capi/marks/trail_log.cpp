// Writes the log. Each tick is appended with one call: a program that dies leaves the earlier ticks. Call stacks are
// stored as modules and offsets, because addresses differ in every run.
// SPDX-License-Identifier: MIT
#include "capi/marks/trail_log.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <utility>

#ifdef __GLIBC__
#include <dlfcn.h>
#include <execinfo.h>
#include <unistd.h>
#endif

namespace ticktrue::capi {
namespace {

#ifdef __GLIBC__

constexpr int depth_max = replay::listed_stack_depth_max;

std::vector<const void*> stack_behind(const void* caller) {
  void* frames[depth_max];
  void** const end = frames + ::backtrace(frames, depth_max);
  // Earlier frames belong to this library and to the preload library.
  void** const first = std::find(frames, end, caller);
  return std::vector<const void*>(first == end ? frames : first, end);
}

std::string path_of(const Dl_info& info) {
  if (info.dli_fname != nullptr && info.dli_fname[0] == '/') return info.dli_fname;
  char path[4'096];
  const ssize_t size = ::readlink("/proc/self/exe", path, sizeof path);
  return size > 0 ? std::string(path, static_cast<std::size_t>(size)) : std::string();
}

replay::LogFrame frame_of(const void* address, std::vector<replay::LogModule>& modules) {
  Dl_info info{};
  if (::dladdr(address, &info) == 0) info.dli_fbase = nullptr;
  const auto base = reinterpret_cast<std::uintptr_t>(info.dli_fbase);
  auto found = std::find_if(modules.begin(), modules.end(),
                            [&](const replay::LogModule& module) { return module.base == base; });
  if (found == modules.end())
    found = modules.insert(found, {info.dli_fbase == nullptr ? std::string() : path_of(info), base});
  return {static_cast<std::uint32_t>(found - modules.begin()), reinterpret_cast<std::uintptr_t>(address) - base};
}

#else

std::vector<const void*> stack_behind(const void*) {
  return {};
}
replay::LogFrame frame_of(const void*, std::vector<replay::LogModule>&) {
  return {};
}

#endif

/// The number in a variable; nothing: no number.
std::optional<std::uint64_t> number_in(const char* variable) {
  const char* text = std::getenv(variable);
  if (text == nullptr || *text < '0' || *text > '9') return std::nullopt;
  return std::strtoull(text, nullptr, 10);
}

}  // namespace

void StackCollector::add(const void* caller) {
  std::vector<const void*> stack = stack_behind(caller);
  if (numbers_.size() >= replay::listed_stack_count_max - 1 && numbers_.count(stack) == 0) stack.clear();
  of_marks_.push_back(numbers_.emplace(std::move(stack), static_cast<std::uint32_t>(numbers_.size())).first->second);
}

replay::MarkStacks StackCollector::take() {
  replay::MarkStacks stacks;
  stacks.stacks.resize(numbers_.size());
  bool is_known = false;
  for (const auto& [addresses, number] : numbers_)
    for (const void* address : addresses) {
      stacks.stacks[number].push_back(frame_of(address, stacks.modules));
      is_known = true;
    }
  stacks.of_marks = std::exchange(of_marks_, {});
  numbers_.clear();
  return is_known ? stacks : replay::MarkStacks();
}

std::unique_ptr<TrailLog> TrailLog::from_environment() {
  static bool is_taken = false;
  const char* path = std::getenv(replay::trail_variable);
  if (path == nullptr || *path == 0 || std::exchange(is_taken, true)) return nullptr;
  return std::unique_ptr<TrailLog>(new TrailLog(path, number_in(replay::trail_tick_variable)));
}

void TrailLog::write(std::uint64_t tick, const BoundContents& contents) {
  ByteWriter out;
  replay::encode_logged_tick({tick, contents.marks}, out);
  if (wants_list(tick) && contents.mark_list)
    replay::encode_logged_list({tick, *contents.mark_list, contents.stacks}, out);
  std::FILE* file = std::fopen(path_.c_str(), "ab");
  if (file == nullptr) return;
  std::fwrite(out.view().data(), 1, out.size(), file);
  std::fclose(file);
}

}  // namespace ticktrue::capi
