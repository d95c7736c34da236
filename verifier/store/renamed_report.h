// A report under another name of its file.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Makes a report about another file with the same bytes: the name changes in the report, its texts and its commands.
/// A report that is no match gets a note with the former name.
void rename_file(Report& report, const std::string& file);

}  // namespace ticktrue::verifier
