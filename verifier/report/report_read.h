// Reads a report of a session back from its JSON (schema ticktrue.verify/2, or 1).
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "base/state/schema.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

struct ReadReport {
  Report report;
  /// What two runs that did the same have in common: verdict and the whole finding.
  std::string finding;
};

/// Nothing: the text is no such report, or names a verdict that there is not. Fields of another type than expected
/// count as absent. A lane of a column that the schema lacks is left out. `end` and the build of the tool are not read.
std::optional<ReadReport> read_report(const std::string& json, const StateSchema& schema);

}  // namespace ticktrue::verifier
