// Changes the file name in a report.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Makes the report one about another file with the same bytes: replaces the name in the report, its texts and its
/// commands. A report that is not a match gets a note with the former name.
void rename_file(Report& report, const std::string& file);

}  // namespace ticktrue::verifier
