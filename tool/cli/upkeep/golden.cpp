// `ticktrue golden`: checks and updates a directory of golden traces and its manifest.
// SPDX-License-Identifier: MIT
#include "verifier/corpus/golden.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <system_error>

#include "base/hash.h"
#include "base/parallel/jobs.h"
#include "tool/cli/commands.h"
#include "tool/output/json_output.h"
#include "tool/session/session.h"
#include "tool/session/session_inputs.h"
#include "tool/session/simulations.h"
#include "verifier/compare/diff.h"
#include "verifier/programs/command_words.h"
#include "verifier/programs/verify_program.h"
#include "verifier/report/json_parts.h"
#include "verifier/report/report_ci.h"
#include "verifier/runs/data_file.h"
#include "verifier/runs/run_folder.h"
#include "verifier/verify/verify.h"

namespace ticktrue::cli {
namespace {

namespace fs = std::filesystem;
using verifier::GoldenRow;

// Close enough that a test of restoring has work, and readable by builds without zstd.
constexpr std::uint32_t golden_checkpoint_interval = 300;

struct GoldenCommand {
  std::string directory;
  std::string reason;
  std::uint64_t size_max = 65536;
  std::uint64_t jobs = 0;
  bool json = false;

  std::string path_of(const std::string& name) const { return (fs::path(directory) / name).string(); }
};

/// What was found of one golden trace.
struct GoldenOutcome {
  int code = exit_ok;
  bool changed = false;                         // update: recorded again
  std::vector<Error> errors;                    // what is wrong
  std::vector<verifier::EscapedChild> escaped;  // of the program
  std::string report;                           // of verify, where it does not match
  std::string hash;                             // as this build gives it
  std::uint64_t size = 0;                       // bytes
  std::string ticks;                            // update: those that changed
  std::string first;                            // update: the first difference as text
  bool was_there = false;                       // update: there was a trace to compare with

  void fail(int with, std::string what, std::string hint = "") {
    const int codes[] = {code, with};
    code = worst_exit_code(codes);
    errors.push_back(Error{ErrorCode::io, std::move(what), std::move(hint)});
  }
};

/// Path of a file of the manifest: as named, or next to or in the directory of the traces.
std::string find_file(const GoldenCommand& command, const std::string& word) {
  const fs::path folder(command.directory);
  std::error_code failure;
  for (const fs::path& path :
       {fs::path(word), fs::absolute(folder).lexically_normal().parent_path() / word, folder / word})
    if (fs::is_regular_file(path, failure)) return path.string();
  return word;
}

/// Inputs of a row that are a host's frames: host:NAME or host:NAME:SEED.
std::optional<HostOptions> host_of(const std::string& inputs) {
  constexpr std::string_view prefix = "host:";
  if (inputs.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
  HostOptions host;
  const std::size_t colon = inputs.find(':', prefix.size());
  host.host = inputs.substr(prefix.size(), colon - prefix.size());
  if (colon == std::string::npos) return host;
  const std::string seed = inputs.substr(colon + 1);
  if (std::from_chars(seed.data(), seed.data() + seed.size(), host.seed).ptr != seed.data() + seed.size())
    return std::nullopt;
  return host;
}

/// A session of the row, ready to run.
struct GoldenSession {
  engine::Scene scene;
  std::unique_ptr<engine::Engine> engine;
  SessionInputs inputs;
};
Result<std::unique_ptr<GoldenSession>> open_session(const GoldenCommand& command, const GoldenRow& row) {
  auto scene = load_scene_argument(find_file(command, row.scene));
  if (!scene) return scene.error();
  auto session = std::make_unique<GoldenSession>();
  session->scene = std::move(*scene);
  auto made = engine::make_engine(session->scene);
  if (!made) return made.error();
  session->engine = std::move(*made);
  const std::optional<HostOptions> host = host_of(row.inputs);
  const std::string path = row.inputs.empty() || host ? "" : find_file(command, row.inputs);
  auto inputs = open_session_inputs(session->scene, path, row.tick_count);
  if (!inputs) return inputs.error();
  session->inputs = std::move(*inputs);
  if (const Status clock = use_clock(session->inputs, host.value_or(HostOptions{}), *session->engine); !clock)
    return clock.error();
  return session;
}

verifier::Report verify_row(const GoldenRow& row, const std::string& path, Result<replay::TraceReader>& reader,
                            GoldenOutcome& outcome) {
  if (!reader) return verifier::open_error_report(path, reader.error());
  if (row.command().empty()) {
    verifier::VerifyOptions options;
    options.simulation = verifier::find_simulation(reader->setup().simulation);
    return verifier::verify(*reader, options);
  }
  const auto words = verifier::split_command(row.command());
  if (!words) return verifier::open_error_report(path, words.error());
  const auto folder = verifier::RunFolder::make("ticktrue-golden", "");
  if (!folder) return verifier::open_error_report(path, folder.error());
  verifier::ProgramVerdict verdict = verifier::verify_by_program(path, {*words, folder->path(), 600}, "run");
  outcome.escaped = std::move(verdict.escaped);
  return std::move(verdict.report);
}

/// A report that is no match fails the row.
void take_report(const verifier::Report& report, const std::string& path, GoldenOutcome& outcome) {
  if (report.verdict == verifier::Verdict::match) return;
  outcome.report = verifier::report_text(report);
  outcome.fail(report.exit_code(), path + ": " + std::string(verifier::verdict_info(report.verdict).name) + ": " +
                                       verifier::report_sentence(report));
}

/// The hash that the trace records for its last tick.
std::string recorded_hash(replay::TraceReader& reader) {
  std::string hash;
  reader.rewind();
  for (;;) {
    const auto& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) return hash;
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) hash = hex64(tick->root_hash);
  }
}

void compare_hash(const GoldenCommand& command, const GoldenRow& row, GoldenOutcome& outcome) {
  if (outcome.hash == row.hash) return;
  outcome.fail(exit_finding,
               command.path_of(verifier::manifest_name) + ": " + row.file + ": final root hash: found " + outcome.hash +
                   ", expected " + row.hash,
               "meant? ticktrue golden update " + verifier::shell_word(command.directory) +
                   " --reason TEXT; else: ticktrue verify " + verifier::shell_word(command.path_of(row.file)));
}

/// The trace is intact and matches, and recorded again as its row says it ends in the state the row says. A trace of a
/// program is not recorded again: its own last hash counts.
void check_row(const GoldenCommand& command, const GoldenRow& row, GoldenOutcome& outcome) {
  const std::string manifest = command.path_of(verifier::manifest_name);
  const std::string path = command.path_of(row.file);
  auto reader = replay::TraceReader::open(path);
  if (!reader && reader.error().code == ErrorCode::io) {
    outcome.fail(exit_finding, manifest + ": " + row.file + ": found no such trace, expected it beside the manifest",
                 "ticktrue golden update " + verifier::shell_word(command.directory) + " --reason TEXT");
    return;
  }
  std::error_code failure;
  outcome.size = fs::file_size(path, failure);
  if (outcome.size != row.size || outcome.size > command.size_max)
    outcome.fail(exit_finding, manifest + ": " + row.file + ": size: found " + std::to_string(outcome.size) +
                                   " bytes, expected " + std::to_string(row.size) + " and at most " +
                                   std::to_string(command.size_max));
  take_report(verify_row(row, path, reader, outcome), path, outcome);
  if (!row.command().empty()) {
    if (!reader) return;
    outcome.hash = recorded_hash(*reader);
    return compare_hash(command, row, outcome);
  }

  auto session = open_session(command, row);
  if (!session) {
    outcome.fail(exit_usage, manifest + ": " + row.file + ": cannot be recorded anew: " + session.error().message);
    return;
  }
  const auto run = verifier::run_session(*(*session)->engine, *(*session)->inputs.source, row.tick_count, {});
  if (!run) {
    outcome.fail(exit_usage, manifest + ": " + row.file + ": cannot be recorded anew: " + run.error().message);
    return;
  }
  outcome.hash = hex64(run->root_hash);
  compare_hash(command, row, outcome);
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
  options.simulation = verifier::find_simulation(new_reader->setup().simulation);
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
  take_report(verify_row(row, path, reader, outcome), path, outcome);
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
  const std::string place = command.path_of(verifier::manifest_name) + ": " + row.file;
  std::error_code failure;
  fs::remove(fresh, failure);
  const auto give_up = [&](const Error& error) {
    outcome.fail(exit_usage, place + ": cannot be recorded: kept as it is: " + error.message, error.hint);
  };
  auto session = open_session(command, row);
  if (!session) return give_up(session.error());
  verifier::TraceChoices choices;
  choices.checkpoint_interval = golden_checkpoint_interval;
  if (const Status detail = parse_detail(row.detail, choices); !detail) return give_up(detail.error());
  replay::RecordOptions options;
  options.tick_count = row.tick_count;
  options.writer.compress = false;
  const auto recorded =
      replay::record(*(*session)->engine, *(*session)->inputs.source, fresh,
                     verifier::make_trace_setup(*(*session)->engine, choices), verifier::make_build_facts(), options);
  if (!recorded) return give_up(recorded.error());
  outcome.hash = hex64(recorded->root_hash);
  outcome.size = recorded->size;
  if (recorded->size > command.size_max)
    outcome.fail(exit_finding, place + ": size: found " + std::to_string(recorded->size) + " bytes, expected at most " +
                                   std::to_string(command.size_max));
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

Json row_json(const GoldenRow& row, const GoldenOutcome& outcome, bool is_update) {
  Json object = {{"file", row.file}};
  object["outcome"] = outcome.code != exit_ok ? "failed" : !is_update ? "passed" : outcome.changed ? "changed" : "same";
  object["hash"] = row.hash;
  object["hash_here"] = outcome.hash.empty() ? Json(nullptr) : Json(outcome.hash);
  object["bytes"] = row.size;
  object["bytes_here"] = outcome.size;
  object["ticks_changed"] = outcome.ticks;
  object["first_difference"] = outcome.first;
  object["errors"] = Json::array();
  for (const Error& error : outcome.errors) object["errors"].push_back(error.message);
  return object;
}

/// Traces of the directory that no row speaks of.
std::vector<std::string> traces_without_row(const GoldenCommand& command, const verifier::GoldenManifest& manifest) {
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

void end_programs(const std::vector<GoldenOutcome>& outcomes) {
  for (const GoldenOutcome& outcome : outcomes) verifier::end_escaped(outcome.escaped);
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
      list.push_back(row_json(rows[i], outcome, is_update));
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
    Json object = {{"schema", "ticktrue.golden/1"},
                   {"command", is_update ? "update" : "check"},
                   {"directory", command.directory},
                   {"reason", command.reason}};
    object["passed"] = passed;
    object["failed"] = rows.size() - passed;
    object["expected"] = 0;
    object["not_applicable"] = 0;
    object["changed"] = changed;
    object["rows"] = std::move(list);
    print_json(object);
  } else if (is_update) {
    print(fmt::format("{} of {} traces changed{}\n", changed, rows.size(), changed == 0 ? "" : ": " + command.reason));
  } else {
    print(fmt::format("{} of {} golden traces match and are as {} says\n", passed, rows.size(),
                      command.path_of(verifier::manifest_name)));
  }
  return worst_exit_code(codes);
}

Result<verifier::GoldenManifest> read_manifest(const GoldenCommand& command) {
  const std::string path = command.path_of(verifier::manifest_name);
  const Result<std::string> text = read_text_file(path, std::size_t{16} << 20);
  if (!text) return text.error();
  auto manifest = verifier::parse_manifest(*text, path);
  if (manifest && manifest->rows.empty())
    return Error{ErrorCode::invalid_input, path + ": found no trace, expected at least one row", ""};
  return manifest;
}

unsigned threads_of(const GoldenCommand& command) {
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
    print_error(Error{ErrorCode::io,
                      command.path_of(name) + ": found no row in " + command.path_of(verifier::manifest_name),
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
  auto file = verifier::DataFile::create(command.path_of(verifier::manifest_name), true);
  if (!file) return fail_usage(file.error());
  if (const Status written = file->write(verifier::manifest_text(*manifest)); !written)
    return fail_usage(written.error());
  if (const Status closed = file->close(); !closed) return fail_usage(closed.error());
  return print_outcomes(command, old_rows, outcomes, true, {});
}

void add_common(CLI::App& command, GoldenCommand& options) {
  command.add_option("DIR", options.directory, "Directory with the traces and MANIFEST.tsv")->required();
  add_number(command, "--size-max", options.size_max, "Bytes a golden trace may have (default 65536)");
  add_number(command, "-j,--jobs", options.jobs, "Threads (default: every core)", {1, 1024});
  command.add_flag("--json", options.json, "One JSON object (schema ticktrue.golden/1)");
}

}  // namespace

void add_golden(CLI::App& app, CliContext& context) {
  CLI::App* command =
      app.add_subcommand("golden", "Check a directory of golden traces, or record them anew")->group(group_upkeep);
  command->require_subcommand(1);

  auto check_options = std::make_shared<GoldenCommand>();
  CLI::App* check =
      command->add_subcommand("check", "Verify every golden trace, and that the manifest tells the truth about it");
  add_common(*check, *check_options);
  set_examples(*check,
               "printf 'stack.ttr\\tstack?boxes=3\\t-\\t60\\troot\\t-\\t0\\twhy it is kept\\n' > MANIFEST.tsv\n"
               "ticktrue golden update . --reason 'the first recording'\n"
               "ticktrue golden check .",
               "MANIFEST.tsv has a row for each trace, columns separated by tabs: file, scene, inputs (- for none),\n"
               "ticks (- for up to the `end` input), detail, hash after the last tick (- for a new one), bytes, why.\n"
               "scene command:WORDS: the program that recorded the trace verifies it, as with --command of verify.");
  check->callback([check_options, &context] { context.exit_code = run_golden_check(*check_options); });

  auto update_options = std::make_shared<GoldenCommand>();
  CLI::App* update = command->add_subcommand(
      "update", "Record the golden traces anew, say what changed at which ticks, rewrite the manifest");
  add_common(*update, *update_options);
  update
      ->add_option("--reason", update_options->reason,
                   "Why the old traces are wrong now; without it nothing is touched")
      ->type_name("TEXT");
  set_examples(*update,
               "printf 'stack.ttr\\tstack?boxes=3\\t-\\t60\\troot\\t-\\t0\\twhy it is kept\\n' > MANIFEST.tsv\n"
               "ticktrue golden update . --reason 'the first recording'");
  update->callback([update_options, &context] { context.exit_code = run_golden_update(*update_options); });
}

}  // namespace ticktrue::cli
