// Finds the files of a command: its words, the search in PATH, and `LINKER --list PROGRAM`.
// SPDX-License-Identifier: MIT
#include "verifier/programs/program_files.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/bytes.h"
#include "base/plain_text.h"
#include "verifier/programs/elf_file.h"
#include "verifier/programs/linked_libraries.h"
#include "verifier/runs/child.h"

#ifdef __linux__
#include <unistd.h>
#endif

namespace ticktrue::verifier {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t file_count_max = 100'000;
constexpr std::size_t list_size_max = 1u << 20;
constexpr double list_time_s = 60;

std::string canonical(const std::string& path) {
  std::error_code failure;
  const fs::path found = fs::canonical(path, failure);
  return failure ? std::string() : found.string();
}

bool is_file(const std::string& path) {
  std::error_code failure;
  return fs::is_regular_file(path, failure);
}

/// Finds a program as execvp does; empty: not found.
std::string find_program(const std::string& word) {
  if (word.find('/') != std::string::npos) return is_file(word) ? word : "";
  const char* variable = std::getenv("PATH");
  std::istringstream folders(variable == nullptr ? "/bin:/usr/bin" : variable);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string path = (folder.empty() ? "." : folder) + "/" + word;
#ifdef __linux__
    if (is_file(path) && ::access(path.c_str(), X_OK) == 0) return path;
#endif
  }
  return "";
}

class Files {
 public:
  Status add(std::string name, const std::string& path) {
    std::string whole = canonical(path);
    if (whole.empty()) return Error{ErrorCode::io, path + ": cannot be found", ""};
    if (files_.size() >= file_count_max)
      return Error{ErrorCode::limit, "files of the program: expected at most " + std::to_string(file_count_max),
                   "name fewer files or smaller folders"};
    files_.push_back({std::move(name), std::move(whole)});
    return {};
  }

  /// Adds a file, or all files in a folder and its subfolders.
  Status add_named(const std::string& path) {
    std::error_code failure;
    if (!fs::is_directory(path, failure)) {
      if (is_file(path)) return add(path, path);
      return Error{ErrorCode::io, path + ": found no such file or folder, expected one of the program", ""};
    }
    auto at = fs::recursive_directory_iterator(path, failure);
    for (; !failure && at != fs::recursive_directory_iterator(); at.increment(failure)) {
      std::error_code ignored;
      if (!at->is_regular_file(ignored)) continue;
      if (Status status = add(at->path().string(), at->path().string()); !status) return status;
    }
    if (failure) return Error{ErrorCode::io, path + ": " + failure.message(), ""};
    return {};
  }

  /// Adds the libraries of each program among the files. Only the first file is the program that runs; others may be
  /// for another system.
  Status add_libraries() {
    const std::size_t count = files_.size();
    for (std::size_t i = 0; i < count; ++i) {
      const std::string path = files_[i].path;
      std::ifstream in(path, std::ios::binary);
      const std::string linker = elf_linker_name(in);
      if (linker.empty()) continue;
      const Result<std::vector<std::string>> libraries = list(linker, path);
      if (!libraries && i == 0) return libraries.error();
      if (!libraries) continue;
      for (const std::string& library : *libraries)
        if (Status status = add(fs::path(library).filename().string(), library); !status) return status;
    }
    return {};
  }

  std::vector<ProgramFile> take() {
    const auto less = [](const ProgramFile& a, const ProgramFile& b) {
      return std::tie(a.name, a.path) < std::tie(b.name, b.path);
    };
    std::sort(files_.begin(), files_.end(), less);
    const auto same = [](const ProgramFile& a, const ProgramFile& b) { return a.name == b.name && a.path == b.path; };
    files_.erase(std::unique(files_.begin(), files_.end(), same), files_.end());
    return std::move(files_);
  }

 private:
  static Result<std::vector<std::string>> list(const std::string& linker, const std::string& program) {
    ChildCommand command;
    command.argv = {linker, "--list", program};
    command.limits.time_s = list_time_s;
    command.limits.output_size_max = list_size_max;
    const ChildResult child = run_child(command);
    const std::string failure = child_failure(child, command.limits);
    if (!failure.empty() || child.end.exit_status != 0)
      return Error{ErrorCode::io,
                   program + ": its dynamic linker does not list its libraries: " +
                       (failure.empty() ? plain_line(child.message.substr(0, child.message.find('\n'))) : failure),
                   plain_line(linker + " --list " + program) + " shows the same"};
    return listed_libraries(program, child.output);
  }

  std::vector<ProgramFile> files_;
};

/// The files that a word may name: the word itself, and the text after its first '='.
std::vector<std::string> names_in(const std::string& word) {
  std::vector<std::string> names{word};
  if (const std::size_t equals = word.find('='); equals != std::string::npos) names.push_back(word.substr(equals + 1));
  return names;
}

}  // namespace

Result<std::vector<ProgramFile>> program_files(const std::vector<std::string>& words,
                                               const std::vector<std::string>& more) {
#ifndef __linux__
  return Error{ErrorCode::unsupported, "this system does not say which libraries a program loads",
               "use the command verify, which needs no store"};
#endif
  Files files;
  const std::string program = words.empty() ? "" : find_program(words.front());
  if (program.empty())
    return Error{ErrorCode::io, (words.empty() ? "" : words.front()) + ": found no such program, expected one",
                 "no shell runs the command: its first word is a program"};
  if (const Status status = files.add("the program", program); !status) return status.error();
  for (std::size_t i = 1; i < words.size(); ++i)
    for (const std::string& name : names_in(words[i]))
      if (is_file(name))
        if (const Status status = files.add(name, name); !status) return status.error();
  for (const std::string& path : more)
    if (const Status status = files.add_named(path); !status) return status.error();
  if (const Status status = files.add_libraries(); !status) return status.error();
  return files.take();
}

}  // namespace ticktrue::verifier
