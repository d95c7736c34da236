// Writes the files of a failing world: the shrunk world, and the command that reproduces the failure.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "base/result.h"
#include "tool/experiment/oracle/oracle.h"
#include "tool/experiment/soak/counters.h"

namespace ticktrue::soak {

struct FailureOptions {
  std::string folder;         // created if missing
  double shrink_time_s = 60;  // 0: the world is not shrunk
  OracleOptions oracle;
};

/// Shrinks the world with the variant that has the finding, and writes scene.json, inputs.jsonl and command. If the
/// files cannot be written, `folder` of the result is empty and `what` gives the reason.
FailedWorld write_failure(const SoakCase& soak_case, std::uint64_t world_seed, const Finding& finding,
                          const FailureOptions& options);

/// Reads scene.json and inputs.jsonl. Errors: those of reading a scene and its inputs.
Result<SoakCase> read_case(const engine::Scene& scene, const std::string& inputs_path, std::uint64_t tick_count);

}  // namespace ticktrue::soak
