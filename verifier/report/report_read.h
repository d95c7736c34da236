// Reads the report of a session from its JSON (schema ticktrue.verify/2, or 1).
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "base/state/schema.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

struct ReadReport {
  Report report;
  /// The verdict and the whole finding. It is equal for two runs with the same result.
  std::string finding;
};

/// Nothing: the text is not such a report, or has an unknown verdict. A field of another type than expected counts as
/// absent. A lane of a column that the schema lacks is left out. `end` and the build of the tool are not read.
std::optional<ReadReport> read_report(const std::string& json, const StateSchema& schema);

}  // namespace ticktrue::verifier
