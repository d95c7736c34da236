// Functions shared by the study commands: text of verdicts, tables and files.
// SPDX-License-Identifier: MIT
#include "tool/cli/study/study_output.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

namespace ticktrue::cli {

using verifier::StudyVerdict;

void add_study_files(CLI::App& command, StudyFiles& files) {
  command.add_flag("--json", files.json, "One JSON object");
  command.add_option("--csv", files.csv, "Every row to a CSV file too")->type_name("FILE");
  command.add_option("--plot", files.plot, "Diagrams as SVG, drawn by the program gnuplot")->type_name("FILE.svg");
}

std::string counts_text(const verifier::VerdictCounts& counts) {
  return fmt::format("{} pass, {} fail, {} fall short, {} not judged, {} not applicable", counts.of(StudyVerdict::pass),
                     counts.of(StudyVerdict::fail), counts.of(StudyVerdict::falls_short),
                     counts.of(StudyVerdict::not_judged), counts.of(StudyVerdict::not_applicable));
}

void add_counts(Json& object, const verifier::VerdictCounts& counts) {
  object["passed"] = counts.of(StudyVerdict::pass);
  object["failed"] = counts.of(StudyVerdict::fail);
  object["falls_short"] = counts.of(StudyVerdict::falls_short);
  object["not_judged"] = counts.of(StudyVerdict::not_judged);
  object["not_applicable"] = counts.of(StudyVerdict::not_applicable);
}

int write_study_files(const StudyFiles& files, const std::string& csv, const std::vector<verifier::Plot>& plots) {
  if (!files.csv.empty()) {
    std::FILE* file = std::fopen(files.csv.c_str(), "wb");
    const bool written = file && std::fwrite(csv.data(), 1, csv.size(), file) == csv.size();
    const bool closed = file && std::fclose(file) == 0;
    if (!written || !closed) return fail_usage(Error{ErrorCode::io, files.csv + ": cannot be written", {}});
  }
  if (files.plot.empty()) return exit_ok;
  const Status plotted = verifier::write_plots(plots, files.plot);
  if (plotted) return exit_ok;
  if (plotted.error().code != ErrorCode::unsupported) return fail_usage(plotted.error());
  print_warning(plotted.error().message + "; " + plotted.error().hint);
  return exit_ok;
}

}  // namespace ticktrue::cli
