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
  /// Reads the executable files of the folder and of those below it. Errors: usage (no folder, no program with a build
  /// id), limit (more files than 100,000).
  static Result<ProgramBuilds> find(const std::string& folder);

  /// The program that recorded the trace: of several copies, the first by name. Errors: incompatible (none of them, or
  /// the trace does not name it); what TraceReader::open refuses.
  Result<std::string> recorder_of(const std::string& trace) const;

 private:
  explicit ProgramBuilds(std::string folder) : folder_(std::move(folder)) {}

  std::string folder_;
  std::map<std::string, std::string> paths_;  // by build id
};

/// Puts the program in place of each {build} in the words; false: there is none.
bool replace_build(std::vector<std::string>& words, const std::string& program);

}  // namespace ticktrue::verifier
