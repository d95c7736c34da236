// Folders for the files of runs.
// SPDX-License-Identifier: MIT
#include "verifier/runs/run_folder.h"

#include <filesystem>
#include <system_error>
#include <utility>

#ifndef _WIN32
#include <unistd.h>
#else
#include <process.h>
#endif

namespace ticktrue::verifier {

namespace fs = std::filesystem;

Result<RunFolder> RunFolder::make(const std::string& name, const std::string& asked) {
  std::error_code failed;
  if (!asked.empty()) {
    fs::create_directories(asked, failed);
    if (failed) return Error{ErrorCode::io, asked + ": cannot be made: " + failed.message(), ""};
    return RunFolder(fs::canonical(asked, failed).string(), false);
  }
  const fs::path temporary = fs::temp_directory_path(failed);
  constexpr int try_count = 1000;
  for (int i = 0; !failed && i < try_count; ++i) {
    const fs::path path = temporary / (name + "-" + std::to_string(::getpid()) + "-" + std::to_string(i));
    if (!fs::create_directory(path, failed) || failed) continue;  // another process has this folder
    fs::permissions(path, fs::perms::owner_all, failed);
    return RunFolder(path.string(), true);
  }
  return Error{ErrorCode::io, "the temporary folder: no folder can be made in it",
               "the variable TMPDIR names another folder for temporary files"};
}

RunFolder::RunFolder(std::string path, bool is_temporary) : path_(std::move(path)), is_temporary_(is_temporary) {}

RunFolder::RunFolder(RunFolder&& other) noexcept
    : path_(std::move(other.path_)), is_temporary_(std::exchange(other.is_temporary_, false)) {}

RunFolder::~RunFolder() {
  std::error_code ignored;
  if (is_temporary_) fs::remove_all(path_, ignored);
}

}  // namespace ticktrue::verifier
