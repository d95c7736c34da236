// Functions shared by the study commands: text of verdicts, tables and files.
// SPDX-License-Identifier: MIT
#include "tool/cli/study/study_output.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <system_error>

#include "replay/file/file_calls.h"
#include "tool/study/problem_file/problem_scene.h"
#include "verifier/report/report.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::cli {
namespace {

namespace fs = std::filesystem;

bool is_json_file(const std::string& word) {
  return word.size() > 5 && word.compare(word.size() - 5, 5, ".json") == 0;
}

/// Creates what is to be written, and removes it. Devices and pipes are left alone: others may see them opened.
Status check_by_creating(const std::string& path, bool overwrite) {
  std::error_code code;
  const fs::file_status status = fs::status(replay::system_path(path), code);
  if (fs::exists(status) && !fs::is_regular_file(status)) return {};
  const auto file = verifier::DataFile::create(path, overwrite);
  return file ? Status{} : Status{file.error()};
}

Status check_target(const std::string& path, bool overwrite, const std::vector<std::string>& read) {
  if (path.empty()) return {};
  if (const Status status = verifier::check_not_read(path, read); !status) return status;
  if (const Status status = verifier::check_writable_target(path, overwrite); !status) return status;
  return check_by_creating(path, overwrite);
}

bool are_same(const std::string& a, const std::string& b) {
  std::error_code code_a, code_b;
  const fs::path real_a = fs::weakly_canonical(fs::absolute(replay::system_path(a), code_a), code_a);
  const fs::path real_b = fs::weakly_canonical(fs::absolute(replay::system_path(b), code_b), code_b);
  if (!code_a && !code_b && real_a == real_b) return true;
  return fs::equivalent(replay::system_path(a), replay::system_path(b), code_a);
}

}  // namespace

using tool::StudyVerdict;

void add_study_files(CLI::App& command, StudyFiles& files) {
  command.add_flag("--json", files.json, "One JSON object");
  command.add_option("--csv", files.csv, "Every row to a CSV file too")->type_name("FILE");
  command.add_option("--plot", files.plot, "Diagrams as SVG, drawn by the program gnuplot")->type_name("FILE.svg");
  command.add_flag("--force", files.force, "Replace existing files that are to be written");
}

Status check_study_files(const StudyFiles& files, const std::vector<std::string>& read) {
  if (const Status status = check_target(files.csv, files.force, read); !status) return status;
  if (const Status status = check_target(files.plot, files.force, read); !status) return status;
  if (const Status status = check_target(files.samples, files.force, read); !status) return status;
  const std::pair<const char*, const std::string*> named[]{
      {"--csv", &files.csv}, {"--plot", &files.plot}, {"--samples", &files.samples}};
  for (const auto& [option, path] : named)
    for (const auto& [other, other_path] : named) {
      if (other == option) break;
      if (path->empty() || other_path->empty() || !are_same(*path, *other_path)) continue;
      return Error{ErrorCode::usage,
                   fmt::format("{}: found {}, the file of {}, expected another", option, *path, other),
                   "give another name"};
    }
  const std::string extension = fs::path(files.plot).extension().string();
  if (extension.empty() || extension == ".svg") return {};
  return Error{ErrorCode::usage, fmt::format("--plot: found {}, expected the name of an SVG file", files.plot),
               "name it " + fs::path(files.plot).replace_extension(".svg").string()};
}

std::vector<std::string> own_files(const std::vector<std::string>& words) {
  std::vector<std::string> files;
  for (const std::string& word : words) {
    if (!is_json_file(word)) continue;
    files.push_back(word);
    const Result<std::string> text = read_text_file(word, tool::problem_file_size_max);
    if (!text) continue;
    const Json tree = Json::parse(*text, nullptr, false);
    if (!tree.is_object()) continue;
    const std::string folder = fs::path(word).parent_path().string();
    for (const auto& [key, value] : tree.items())
      if (value.is_string()) files.push_back((fs::path(folder) / value.get<std::string>()).string());
  }
  return files;
}

std::string words_text(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += " " + verifier::shell_word(word);
  return text;
}

std::string counts_text(const tool::VerdictCounts& counts) {
  return fmt::format("{} pass, {} fail, {} fall short, {} not judged, {} not applicable", counts.of(StudyVerdict::pass),
                     counts.of(StudyVerdict::fail), counts.of(StudyVerdict::falls_short),
                     counts.of(StudyVerdict::not_judged), counts.of(StudyVerdict::not_applicable));
}

void add_counts(Json& object, const tool::VerdictCounts& counts) {
  object["passed"] = counts.of(StudyVerdict::pass);
  object["failed"] = counts.of(StudyVerdict::fail);
  object["falls_short"] = counts.of(StudyVerdict::falls_short);
  object["not_judged"] = counts.of(StudyVerdict::not_judged);
  object["not_applicable"] = counts.of(StudyVerdict::not_applicable);
}

int write_study_files(const StudyFiles& files, const std::string& csv, const std::vector<tool::Plot>& plots) {
  if (!files.csv.empty()) {
    const Status written = verifier::write_data_file(files.csv, csv, files.force);
    if (!written) return fail_usage(written.error());
  }
  if (files.plot.empty()) return exit_ok;
  const Status plotted = tool::write_plots(plots, files.plot, files.force);
  if (plotted) return exit_ok;
  if (plotted.error().code != ErrorCode::unsupported) return fail_usage(plotted.error());
  print_warning(plotted.error().message + "; " + plotted.error().hint);
  return exit_ok;
}

}  // namespace ticktrue::cli
