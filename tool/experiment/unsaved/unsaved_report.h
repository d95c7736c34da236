// The output of `ticktrue unsaved` as text and JSON.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "tool/experiment/unsaved/unsaved.h"

namespace ticktrue::unsaved {

/// Exit code 0, 1 or 6.
int exit_code(const UnsavedReport& report);
std::string unsaved_text(const UnsavedReport& report, const std::string& trace);
/// Schema ticktrue.unsaved/1.
std::string unsaved_json(const UnsavedReport& report, const std::string& trace);

}  // namespace ticktrue::unsaved
