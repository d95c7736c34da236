// Digest of the files of a program, and comparison of the files with what they were.
// SPDX-License-Identifier: MIT
#include "tool/corpus/program_subject.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "base/bytes.h"
#include "verifier/programs/command_words.h"
#include "verifier/programs/program_files.h"
#include "verifier/store/mapped_libraries.h"
#include "verifier/store/stat_index.h"

namespace ticktrue::tool {

Result<ProgramSubject> ProgramSubject::make(const ProgramChoice& choice) {
  const Result<std::vector<verifier::ProgramFile>> files = verifier::program_files(choice.words, choice.more_files);
  if (!files) return files.error();
  ProgramSubject subject(choice);
  ByteWriter out;
  for (const verifier::ProgramFile& file : *files) {
    const std::optional<replay::FileFacts> facts = replay::file_facts(file.path);
    const Result<Hash128> content = verifier::file_hash(file.path);
    if (!content) return content.error();
    if (!facts) return Error{ErrorCode::io, file.path + ": cannot be read", ""};
    out.text(file.name);
    out.u64(content->high);
    out.u64(content->low);
    subject.files_.push_back({file.path, *facts});
  }
  subject.digest_ = hash128(out.view());
  std::sort(subject.files_.begin(), subject.files_.end(), [](const File& a, const File& b) { return a.path < b.path; });
  if (const Status status = subject.check_unchanged(); !status) return status.error();
  return subject;
}

std::string ProgramSubject::words_text() const {
  std::vector<std::string> words = choice_.words;
  words.front() = "PROGRAM";
  return verifier::command_line_of(words);
}

Status ProgramSubject::check_unchanged() const {
  for (const File& file : files_) {
    const std::optional<replay::FileFacts> now = replay::file_facts(file.path);
    if (!now || !verifier::is_unchanged(file.facts, *now))
      return Error{ErrorCode::io, file.path + ": a file of the program changed while the command ran",
                   "start the command again when nothing writes to it"};
  }
  return {};
}

std::vector<std::string> ProgramSubject::find_uncounted(const std::vector<std::string>& mapped) const {
  std::vector<std::string> uncounted;
  for (const std::string& path : mapped) {
    std::error_code failure;
    const std::string whole = std::filesystem::canonical(path, failure).string();
    const auto at = std::lower_bound(files_.begin(), files_.end(), whole,
                                     [](const File& file, const std::string& wanted) { return file.path < wanted; });
    const bool is_counted = !failure && at != files_.end() && at->path == whole;
    if (!is_counted && std::find(uncounted.begin(), uncounted.end(), path) == uncounted.end())
      uncounted.push_back(path);
  }
  return uncounted;
}

}  // namespace ticktrue::tool
