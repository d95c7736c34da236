// Which program gives the verdicts of a corpus: its bytes, its libraries, its words, and how the tool runs it.
// SPDX-License-Identifier: MIT
//
// Verified: every file counts by its bytes; that none of them changed while the program ran; and by what the session
// tells at its end, that the process had nothing mapped that does not count. Not verified: files that the program reads
// (settings, levels, modules of a script) unless they are named, variables of the environment, the machine.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/hash128.h"
#include "base/result.h"
#include "replay/file/file_calls.h"

namespace ticktrue::tool {

/// A program that verifies traces, as the command line names it.
struct ProgramChoice {
  std::vector<std::string> words;       // of split_command
  std::vector<std::string> more_files;  // files and folders that count too
  std::string version;                  // for people: "-" where nobody says
  double time_s = 600;                  // of a run
};

class ProgramSubject {
 public:
  /// Reads every file of the program. Errors: io, limit, unsupported.
  static Result<ProgramSubject> make(const ProgramChoice& choice);

  const ProgramChoice& choice() const { return choice_; }
  /// Of the names and bytes of all files.
  const Hash128& digest() const { return digest_; }
  /// The words as one line, with PROGRAM in the place of its path: where it is does not count.
  std::string words_text() const;

  /// Errors: io (a file was written to or replaced since it was read).
  Status check_unchanged() const;

  /// Those of the paths that do not count, each once.
  std::vector<std::string> find_uncounted(const std::vector<std::string>& mapped) const;

 private:
  struct File {
    std::string path;
    replay::FileFacts facts;
  };
  explicit ProgramSubject(const ProgramChoice& choice) : choice_(choice) {}

  ProgramChoice choice_;
  std::vector<File> files_;  // sorted by path
  Hash128 digest_;
};

}  // namespace ticktrue::tool
