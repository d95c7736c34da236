// The files of a reduced session: scene, inputs, trace, a command that shows the failure, and a test.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "tool/experiment/reduce/reduce.h"

namespace ticktrue::reduce {

struct ResultFolder {
  std::string path;
  std::string command;     // the command that shows the failure
  bool has_trace = false;  // false: no tick could be recorded
  std::uint64_t size = 0;  // bytes of all files
};

/// Makes the folder and writes scene.json, inputs.jsonl, trace.ttr, command and test.sh. Replaces existing files.
/// Errors: io; inconsistent (the written session does not fail in the same way when read again).
Result<ResultFolder> write_result(const ReduceResult& result, Predicate& predicate, const ReduceOptions& options,
                                  const std::string& path);

/// A line of JSON for each input.
std::string inputs_text(const SoakCase& session);

}  // namespace ticktrue::reduce
