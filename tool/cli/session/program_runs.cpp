// The words of a recorded program that runs again, and the preload library beside this program.
// SPDX-License-Identifier: MIT
#include "tool/cli/session/program_runs.h"

#include <filesystem>
#include <system_error>

namespace ticktrue::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* trace_mark = "{trace}";

std::string own_folder() {
  std::error_code failed;
  const fs::path path = fs::read_symlink("/proc/self/exe", failed);
  return failed ? std::string() : path.parent_path().string();
}

}  // namespace

std::string shim_path() {
  for (const char* folder : {"", "/../lib", "/../lib/x86_64-linux-gnu", "/../lib/aarch64-linux-gnu", "/../lib64"}) {
    std::error_code failed;
    const fs::path path = fs::canonical(own_folder() + folder + "/libticktrue_shim.so", failed);
    if (!failed) return path.string();
  }
  return "";
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

}  // namespace ticktrue::cli
