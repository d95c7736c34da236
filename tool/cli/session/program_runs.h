// What the commands need that run a recorded program again: its words, a folder for files, the preload library.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"

namespace ticktrue::cli {

/// The preload library of this build or installation; empty: there is none.
std::string shim_path();

/// The program's words with the trace in them: in place of {trace}, else behind --verify at their end.
std::vector<std::string> words_with_trace(const std::vector<std::string>& words, const std::string& trace);

/// The folder for the files of runs: removed at the end unless it was named.
class RunFolder {
 public:
  /// `asked`: its name; empty: a temporary one. Errors: io.
  static Result<std::unique_ptr<RunFolder>> make(const std::string& asked);

  RunFolder(std::string path, bool is_temporary) : path_(std::move(path)), is_temporary_(is_temporary) {}
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  ~RunFolder();
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  bool is_temporary_;
};

}  // namespace ticktrue::cli
