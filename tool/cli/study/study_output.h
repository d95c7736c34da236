// Functions shared by the study commands: text of verdicts, tables and files.
// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/choices.h"
#include "tool/output/json_output.h"
#include "tool/study/table.h"
#include "tool/study/verdict.h"

namespace ticktrue::cli {

struct StudyFiles {
  bool json = false;
  std::string csv;      // path; empty: none
  std::string plot;     // path; empty: none
  std::string samples;  // path; empty: none; of accuracy alone
  bool force = false;
};
void add_study_files(CLI::App& command, StudyFiles& files);

/// Refuses a file that cannot be written, before the long run, and leaves nothing. `read`: the files that the command
/// reads; names of other things do no harm. Errors: io, usage.
Status check_study_files(const StudyFiles& files, const std::vector<std::string>& read);
/// The .json files among the words, and the files beside them that they name (a reference, a scene).
std::vector<std::string> own_files(const std::vector<std::string>& words);

/// The words with their options as one line for a shell, each after a blank.
std::string words_text(const std::vector<std::string>& words);

/// Writes what was asked for. Returns exit_ok, or prints the error and returns its code; a plot that cannot be made is
/// a warning: the table was printed.
int write_study_files(const StudyFiles& files, const std::string& csv, const std::vector<tool::Plot>& plots);

/// null where there is no finite number.
inline Json number_json(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}
inline Json optional_json(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

inline std::string_view precision_name(engine::Precision precision) {
  return engine::info_of(engine::precisions, precision).name;
}

/// "3 pass, 0 fail, 1 expected, 2 not applicable"
std::string counts_text(const tool::VerdictCounts& counts);
/// The keys that every checking command has.
void add_counts(Json& object, const tool::VerdictCounts& counts);

}  // namespace ticktrue::cli
