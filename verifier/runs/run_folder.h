// A folder for the files of runs: a temporary folder that is removed at the end, or a named folder.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/result.h"

namespace ticktrue::verifier {

class RunFolder {
 public:
  /// `asked` empty: makes NAME-PROCESS-NUMBER among the temporary files, for this user alone. Errors: io.
  static Result<RunFolder> make(const std::string& name, const std::string& asked);
  RunFolder(RunFolder&& other) noexcept;
  RunFolder& operator=(RunFolder&&) = delete;
  ~RunFolder();

  const std::string& path() const { return path_; }

 private:
  RunFolder(std::string path, bool is_temporary);

  std::string path_;
  bool is_temporary_;
};

}  // namespace ticktrue::verifier
