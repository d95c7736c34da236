// The files of a reduced session: scene, inputs, trace, the command that shows the failure, a test.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "tool/experiment/reduce/reduce.h"

namespace ticktrue::reduce {

struct ResultFolder {
  std::string path;
  std::string command;     // shows the failure
  bool has_trace = false;  // no tick could be recorded: there is none
  std::uint64_t size = 0;  // bytes of all files
};

/// Writes scene.json, inputs.jsonl, trace.ttr, command and test.sh, over older ones. The folder is made.
/// Errors: io; inconsistent (what was written does not fail in the same way when it is read again).
Result<ResultFolder> write_result(const ReduceResult& result, Predicate& predicate, const ReduceOptions& options,
                                  const std::string& path);

/// A line of JSON for each input.
std::string inputs_text(const SoakCase& session);

}  // namespace ticktrue::reduce
