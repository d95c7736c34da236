// `ticktrue golden`: checks and updates a directory of golden traces and its manifest.
// SPDX-License-Identifier: MIT
#include "verifier/corpus/golden.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <system_error>

#include "base/hash.h"
#include "base/parallel/jobs.h"
#include "tool/cli/commands.h"
#include "tool/cli/upkeep/golden_rows.h"
#include "tool/output/json_output.h"
#include "tool/session/plugin_session.h"
#include "tool/session/simulations.h"
#include "verifier/compare/diff.h"
#include "verifier/report/report.h"
#include "verifier/report/report_ci.h"

namespace ticktrue::cli {
namespace golden {
namespace {

namespace fs = std::filesystem;

/// As check_trace; a trace that is not there has its own words.
void check_row(const GoldenCommand& command, const GoldenRow& row, GoldenOutcome& outcome) {
  const std::string path = command.path_of(row.file);
  const auto reader = replay::TraceReader::open(path);
  if (reader || reader.error().code != ErrorCode::io) return check_trace(command, row, path, outcome);
  outcome.fail(exit_finding,
               command.manifest() + ": " + row.file + ": found no such trace, expected it beside the manifest",
               "ticktrue golden update " + verifier::shell_word(command.directory) + " --reason TEXT");
}

/// Describes the first difference between the old trace and the new one.
void describe_change(const std::string& old_path, const std::string& new_path, GoldenOutcome& outcome) {
  auto old_reader = replay::TraceReader::open(old_path);
  auto new_reader = replay::TraceReader::open(new_path);
  if (!old_reader || !new_reader) {
    outcome.first = "the old one cannot be read: " + (old_reader ? new_reader.error() : old_reader.error()).message;
    return;
  }
  outcome.was_there = true;
  verifier::DiffOptions options;
  options.simulation = tool::find_simulation(new_reader->setup().simulation);
  const verifier::DiffReport diff = verifier::diff(*old_reader, *new_reader, options);
  if (diff.exit_code() == exit_ok) return;
  outcome.first = diff.reason;
  for (const verifier::SetupDifference& setup : diff.setup)
    outcome.first += (outcome.first.empty() ? "" : "; ") + setup.what + ": " + setup.a + " -> " + setup.b;
  if (diff.divergence) {
    verifier::Report as_report;
    as_report.divergence = diff.divergence;
    outcome.first += (outcome.first.empty() ? "" : "; ") + verifier::report_sentence(as_report);
  }
  if (outcome.first.empty()) outcome.first = "the traces differ";
  outcome.ticks = verifier::changed_ticks(*old_reader, *new_reader);
}

/// A program records its trace itself: its row takes hash and size from it, if it verifies.
void update_command_row(const GoldenCommand& command, GoldenRow& row, GoldenOutcome& outcome) {
  const std::string path = command.path_of(row.file);
  auto reader = replay::TraceReader::open(path);
  verify_row(row, path, reader, outcome);
  std::error_code failure;
  outcome.size = fs::file_size(path, failure);
  if (outcome.code != exit_ok || !reader) return;
  outcome.hash = recorded_hash(*reader);
  outcome.was_there = true;
  outcome.changed = outcome.hash != row.hash || outcome.size != row.size;
}

/// Records the row next to its trace, and keeps the old or the new file.
void update_row(const GoldenCommand& command, GoldenRow& row, GoldenOutcome& outcome) {
  if (!row.command().empty()) return update_command_row(command, row, outcome);
  const std::string path = command.path_of(row.file);
  const std::string fresh = path + ".ticktrue-new";
  const std::string place = command.manifest() + ": " + row.file;
  const auto recorded = record_row(command, row, fresh);
  if (!recorded) {
    outcome.fail(exit_usage, place + ": cannot be recorded: kept as it is: " + recorded.error().message,
                 recorded.error().hint);
    return;
  }
  outcome.hash = hex64(recorded->root_hash);
  outcome.size = recorded->size;
  check_size(command, row, recorded->size, outcome);
  std::error_code failure;
  const bool there = fs::exists(path, failure);
  if (there) describe_change(path, fresh, outcome);
  // Build facts alone are no reason to touch a trace: it is kept while its content and its row are the same.
  const std::uint64_t old_size = there ? fs::file_size(path, failure) : 0;
  outcome.changed = !outcome.was_there || !outcome.first.empty() || outcome.hash != row.hash || old_size != row.size;
  if (!outcome.changed) {
    outcome.size = row.size;
    fs::remove(fresh, failure);
    return;
  }
  fs::rename(fresh, path, failure);
  if (failure) outcome.fail(exit_usage, path + ": cannot be replaced: " + failure.message());
}

/// Traces of the directory that no row speaks of.
std::vector<std::string> traces_without_row(const GoldenCommand& command, const GoldenManifest& manifest) {
  std::vector<std::string> found;
  std::error_code failure;
  for (fs::directory_iterator entry(command.directory, failure); !failure && entry != fs::directory_iterator();
       entry.increment(failure)) {
    const std::string name = entry->path().filename().string();
    const bool has_row =
        std::any_of(manifest.rows.begin(), manifest.rows.end(), [&](const GoldenRow& row) { return row.file == name; });
    if (entry->path().extension() == ".ttr" && !has_row) found.push_back(name);
  }
  std::sort(found.begin(), found.end());
  return found;
}

int print_outcomes(const GoldenCommand& command, const std::vector<GoldenRow>& rows,
                   const std::vector<GoldenOutcome>& outcomes, bool is_update, std::vector<int> codes) {
  std::size_t passed = 0, changed = 0;
  Json list = Json::array();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const GoldenOutcome& outcome = outcomes[i];
    codes.push_back(outcome.code);
    passed += outcome.code == exit_ok;
    changed += outcome.changed;
    for (const Error& error : outcome.errors) print_error(error);
    if (command.json) {
      list.push_back(row_json(rows[i], outcome, !is_update ? "passed" : outcome.changed ? "changed" : "same"));
      continue;
    }
    print(outcome.report);
    if (!is_update || outcome.hash.empty()) continue;
    if (!outcome.changed) {
      print("  same     " + rows[i].file + "  " + outcome.hash + "\n");
      continue;
    }
    print("  changed  " + rows[i].file + "  " + rows[i].hash + " -> " + outcome.hash + ", " +
          std::to_string(rows[i].size) + " -> " + std::to_string(outcome.size) + " bytes\n");
    if (!outcome.first.empty()) print("           first: " + outcome.first + "\n");
    if (!outcome.ticks.empty()) print("           ticks: " + outcome.ticks + "\n");
  }
  if (command.json) {
    Json object = golden_json(command, is_update ? "update" : "check", rows.size(), rows.size() - passed);
    object["changed"] = changed;
    object["rows"] = std::move(list);
    print_json(object);
  } else if (is_update) {
    print(fmt::format("{} of {} traces changed{}\n", changed, rows.size(), changed == 0 ? "" : ": " + command.reason));
  } else {
    print(fmt::format("{} of {} golden traces match and are as {} says\n", passed, rows.size(), command.manifest()));
  }
  return worst_exit_code(codes);
}

unsigned threads_of(const GoldenCommand& command) {
  if (has_plugin()) return 1;  // plug-ins are not asked to be safe for threads
  return command.jobs == 0 ? core_count() : static_cast<unsigned>(command.jobs);
}

int run_golden_check(const GoldenCommand& command) {
  const auto manifest = read_manifest(command);
  if (!manifest) return fail_usage(manifest.error());
  std::vector<GoldenOutcome> outcomes(manifest->rows.size());
  const Status status = run_jobs(outcomes.size(), threads_of(command),
                                 [&](std::size_t i) { check_row(command, manifest->rows[i], outcomes[i]); });
  end_programs(outcomes);
  if (!status) return fail(status.error());
  std::vector<int> codes;
  for (const std::string& name : traces_without_row(command, *manifest)) {
    print_error(Error{ErrorCode::io, command.path_of(name) + ": found no row in " + command.manifest(),
                      "add one, or remove the file"});
    codes.push_back(exit_finding);
  }
  return print_outcomes(command, manifest->rows, outcomes, false, std::move(codes));
}

int run_golden_update(const GoldenCommand& command) {
  if (command.reason.find_first_not_of(" \t\n") == std::string::npos)
    return fail_usage(Error{ErrorCode::usage, "golden update: found no reason, expected --reason TEXT",
                            "say which change of physics, format or scene makes the old traces wrong; a failing test "
                            "is not a reason"});
  auto manifest = read_manifest(command);
  if (!manifest) return fail_usage(manifest.error());
  const std::vector<GoldenRow> old_rows = manifest->rows;
  std::vector<GoldenOutcome> outcomes(old_rows.size());
  const Status status = run_jobs(outcomes.size(), threads_of(command),
                                 [&](std::size_t i) { update_row(command, manifest->rows[i], outcomes[i]); });
  end_programs(outcomes);
  if (!status) return fail(status.error());
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (!outcomes[i].changed) continue;
    manifest->rows[i].hash = outcomes[i].hash;
    manifest->rows[i].size = outcomes[i].size;
  }
  if (const Status written = write_manifest(command, *manifest); !written) return fail_usage(written.error());
  return print_outcomes(command, old_rows, outcomes, true, {});
}

}  // namespace
}  // namespace golden

void add_golden(CLI::App& app, CliContext& context) {
  using golden::GoldenCommand;
  CLI::App* command = app.add_subcommand("golden", "Check a directory of golden traces, record them anew, or add one")
                          ->group(group_upkeep);
  command->require_subcommand(1);

  auto check_options = std::make_shared<GoldenCommand>();
  CLI::App* check =
      command->add_subcommand("check", "Verify every golden trace, and that the manifest tells the truth about it");
  golden::add_common(*check, *check_options, true);
  set_examples(*check,
               "printf 'stack.ttr\\tstack?boxes=3\\t-\\t60\\troot\\t-\\t0\\twhy it is kept\\n' > MANIFEST.tsv\n"
               "ticktrue golden update . --reason 'the first recording'\n"
               "ticktrue golden check .",
               "MANIFEST.tsv has a row for each trace, columns separated by tabs: file, scene, inputs (- for none),\n"
               "ticks (- for up to the `end` input), detail, hash after the last tick (- for a new one), bytes, why.\n"
               "scene command:WORDS: the program that recorded the trace verifies it, as with --command of verify.\n"
               "scene plugin:SETUP: the plug-in that --plugin loads is made from this file or word.");
  check->callback([check_options, &context] { context.exit_code = golden::run_golden_check(*check_options); });

  auto update_options = std::make_shared<GoldenCommand>();
  CLI::App* update = command->add_subcommand(
      "update", "Record the golden traces anew, say what changed at which ticks, rewrite the manifest");
  golden::add_common(*update, *update_options, true);
  update
      ->add_option("--reason", update_options->reason,
                   "Why the old traces are wrong now; without it nothing is touched")
      ->type_name("TEXT");
  set_examples(*update,
               "printf 'stack.ttr\\tstack?boxes=3\\t-\\t60\\troot\\t-\\t0\\twhy it is kept\\n' > MANIFEST.tsv\n"
               "ticktrue golden update . --reason 'the first recording'");
  update->callback([update_options, &context] { context.exit_code = golden::run_golden_update(*update_options); });

  golden::add_golden_add(*command, context);
}

}  // namespace ticktrue::cli
