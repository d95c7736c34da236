// A folder with builds of a program, each found by its build id.
// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/result.h"

namespace ticktrue::verifier {

class ProgramBuilds {
 public:
  /// Reads the executable files of the folder and its subfolders. Errors: usage (no folder, no program with a build
  /// id), limit (more than 100,000 files).
  static Result<ProgramBuilds> find(const std::string& folder);

  /// The program that recorded the trace; of several copies, the first by name. Errors: incompatible (the folder lacks
  /// it, or the trace does not name it); the errors of TraceReader::open.
  Result<std::string> recorder_of(const std::string& trace) const;

 private:
  explicit ProgramBuilds(std::string folder) : folder_(std::move(folder)) {}

  std::string folder_;
  std::map<std::string, std::string> paths_;  // by build id
};

/// Replaces each {build} in the words by the program. False: there is none.
bool replace_build(std::vector<std::string>& words, const std::string& program);

}  // namespace ticktrue::verifier
