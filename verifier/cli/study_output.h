// What the study commands share: where tables go besides the screen.
// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "verifier/cli/json_output.h"
#include "verifier/study/table.h"

namespace ticktrue::cli {

struct StudyFiles {
  bool json = false;
  std::string csv;   // path; empty: none
  std::string plot;  // path; empty: none
};
void add_study_files(CLI::App& command, StudyFiles& files);

/// Writes what was asked for. Returns exit_ok, or prints the error and returns its code; a plot that cannot be made is
/// a warning: the table was printed.
int write_study_files(const StudyFiles& files, const std::string& csv, const std::vector<verifier::Plot>& plots);

/// null where there is no finite number.
inline Json number_json(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

}  // namespace ticktrue::cli
