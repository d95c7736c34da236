// Searches executable files and their build ids.
// SPDX-License-Identifier: MIT
#include "verifier/programs/program_builds.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "replay/trace_reader.h"
#include "verifier/programs/command_words.h"
#include "verifier/programs/elf_file.h"

namespace ticktrue::verifier {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t searched_file_count_max = 100'000;
bool is_executable(const fs::directory_entry& entry) {
  std::error_code failure;
  if (!entry.is_regular_file(failure) || failure) return false;
  const fs::perms perms = entry.status(failure).permissions();
  return !failure && (perms & fs::perms::owner_exec) != fs::perms::none;
}

/// Sorted, so that the choice between copies does not depend on the file system.
Result<std::vector<std::string>> executables_in(const std::string& folder) {
  std::vector<std::string> paths;
  std::size_t count = 0;
  std::error_code failure;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied, failure);
  if (failure) return Error{ErrorCode::usage, folder + ": " + failure.message() + ", expected a folder", ""};
  for (; entry != fs::recursive_directory_iterator() && !failure; entry.increment(failure)) {
    if (++count > searched_file_count_max)
      return Error{
          ErrorCode::limit,
          folder + ": found more than " + std::to_string(searched_file_count_max) + " files, expected at most that",
          "name a folder that holds builds alone"};
    if (is_executable(*entry)) paths.push_back(entry->path().string());
  }
  if (failure) return Error{ErrorCode::usage, folder + ": " + failure.message(), ""};
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace

Result<ProgramBuilds> ProgramBuilds::find(const std::string& folder) {
  const Result<std::vector<std::string>> paths = executables_in(folder);
  if (!paths) return paths.error();
  ProgramBuilds builds(folder);
  for (const std::string& path : *paths) {
    std::ifstream in(path, std::ios::binary);
    if (std::string id = elf_build_id(in); !id.empty()) builds.paths_.emplace(std::move(id), path);
  }
  if (!builds.paths_.empty()) return builds;
  return Error{ErrorCode::usage, folder + ": found no program with a build id, expected one at least",
               "a linker writes it with -Wl,--build-id; files without the right to execute do not count"};
}

Result<std::string> ProgramBuilds::recorder_of(const std::string& trace) const {
  const Result<replay::TraceReader> reader = replay::TraceReader::open(trace);
  if (!reader) return reader.error();
  const replay::BuildFacts& facts = reader->facts();
  const auto fact =
      std::find_if(facts.begin(), facts.end(), [](const auto& one) { return one.first == build_id_fact; });
  if (fact == facts.end())
    return Error{ErrorCode::incompatible, trace + ": names no build id of the program that recorded it",
                 "link the program with -Wl,--build-id; --command verifies by a program that you name"};
  const auto found = paths_.find(fact->second);
  if (found != paths_.end()) return found->second;
  return Error{ErrorCode::incompatible,
               trace + ": recorded by build id " + fact->second + ": found none such in " + folder_ + " (" +
                   std::to_string(paths_.size()) + " builds)",
               "keep each build that records; --command verifies by a program that you name"};
}

bool replace_build(std::vector<std::string>& words, const std::string& program) {
  const CommandMark marks[] = {{"{build}", program}};
  return replace_marks(words, marks)[0];
}

}  // namespace ticktrue::verifier
