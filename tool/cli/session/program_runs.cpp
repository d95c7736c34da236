// Runs leave their files in a folder with a name of its own.
// SPDX-License-Identifier: MIT
#include "tool/cli/session/program_runs.h"

#include <unistd.h>

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

Result<std::unique_ptr<RunFolder>> RunFolder::make(const std::string& asked) {
  std::error_code failed;
  if (!asked.empty()) {
    fs::create_directories(asked, failed);
    if (failed) return Error{ErrorCode::io, asked + ": cannot be made: " + failed.message(), ""};
    return std::make_unique<RunFolder>(fs::canonical(asked, failed).string(), false);
  }
  const fs::path temporary = fs::temp_directory_path(failed);
  constexpr int try_count = 1000;
  for (int i = 0; !failed && i < try_count; ++i) {
    const fs::path path = temporary / ("ticktrue-runs-" + std::to_string(::getpid()) + "-" + std::to_string(i));
    if (!fs::create_directory(path, failed) || failed) continue;  // there already, of another process
    fs::permissions(path, fs::perms::owner_all, failed);
    return std::make_unique<RunFolder>(path.string(), true);
  }
  return Error{ErrorCode::io, "the temporary folder: no folder can be made in it",
               "--out names a folder for the files of runs"};
}

RunFolder::~RunFolder() {
  std::error_code ignored;
  if (is_temporary_) fs::remove_all(path_, ignored);
}

}  // namespace ticktrue::cli
