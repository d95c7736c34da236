// `ticktrue golden add`: a row more in a manifest, with its trace, if the row is green.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/hash.h"
#include "tool/cli/commands.h"
#include "tool/cli/upkeep/golden_rows.h"
#include "tool/session/plugin_session.h"
#include "verifier/programs/command_words.h"
#include "verifier/report/report.h"

namespace ticktrue::cli::golden {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view trace_extension = ".ttr";

struct GoldenAdd {
  GoldenCommand common;
  std::string name;
  std::string scene;
  std::string inputs;
  std::optional<std::uint64_t> tick_count;
  std::string detail = "root";
  std::optional<std::string> program;
  std::string trace;  // of the program
  std::string why = "-";
};

Status refuse(const std::string& what, const std::string& hint = "") {
  return Error{ErrorCode::usage, what, hint};
}

Status check_words(const GoldenAdd& add) {
  std::error_code failure;
  if (!fs::is_directory(add.common.directory, failure))
    return refuse(add.common.directory + ": found no directory, expected one", "mkdir makes it");
  if (!add.program) {
    if (!add.trace.empty()) return refuse("--trace: found it without --command", "a scene is recorded by this command");
    if (add.scene.empty() && !has_plugin())
      return refuse("golden add: found neither SCENE nor --command, expected one of them",
                    "as in golden add DIR 'stack?boxes=3' --ticks 60 --name stack");
    return {};
  }
  if (add.trace.empty())
    return refuse("--command: found no --trace, expected the trace that the program recorded",
                  "the program records it: ./mygame --record F.ttr");
  if (!add.scene.empty() || !add.inputs.empty() || add.tick_count || add.detail != "root")
    return refuse("--command: found SCENE, --inputs, --ticks or --detail as well, expected --trace alone",
                  "the trace of a program has its own");
  const auto words = verifier::split_command(*add.program);
  if (!words) return words.error();
  return {};
}

/// Copies a file that is named as from the current directory alone. Gives its name for the row. Errors: io.
class Copies {
 public:
  Result<std::string> take(const GoldenCommand& command, const std::string& word) {
    std::error_code failure;
    if (!fs::is_regular_file(word, failure) || (fs::path(word).is_relative() && find_beside(command, word)))
      return word;
    const std::string name = fs::path(word).filename().string();
    const std::string target = command.path_of(name);
    fs::copy_file(word, target, failure);
    if (failure) return Error{ErrorCode::io, target + ": cannot be made: " + failure.message(), ""};
    made_.push_back(target);
    return name;
  }
  /// They stay.
  void commit() { made_.clear(); }
  Copies() = default;
  Copies(const Copies&) = delete;
  ~Copies() {
    std::error_code ignored;
    for (const std::string& path : made_) fs::remove(path, ignored);
  }

 private:
  std::vector<std::string> made_;
};

Result<GoldenRow> row_of(const GoldenAdd& add, Copies& copies) {
  GoldenRow row;
  row.file = fs::path(add.name).extension() == trace_extension ? add.name : add.name + std::string(trace_extension);
  row.detail = add.detail;
  row.hash = "-";
  row.why = add.why;
  if (add.program) {
    row.scene = std::string(verifier::golden_command) + *add.program;
    return row;
  }
  const Result<std::string> scene = copies.take(add.common, add.scene);
  if (!scene) return scene.error();
  const Result<std::string> inputs = copies.take(add.common, add.inputs);
  if (!inputs) return inputs.error();
  row.scene = (has_plugin() ? std::string(verifier::golden_plugin) : std::string()) + *scene;
  row.inputs = *inputs;
  row.tick_count = add.tick_count;
  return row;
}

/// The manifest as it is now; none yet: its first lines.
Result<GoldenManifest> manifest_now(const GoldenCommand& command) {
  std::error_code failure;
  if (fs::exists(command.manifest(), failure)) return read_manifest(command, true);
  GoldenManifest manifest;
  manifest.after = "file\tscene\tinputs\tticks\tdetail\thash\tbytes\twhy\n";
  return manifest;
}

/// The name is free, in the manifest and in the directory.
Status check_name(const GoldenAdd& add, const GoldenRow& row) {
  Result<GoldenManifest> manifest = manifest_now(add.common);
  if (!manifest) return manifest.error();
  if (const Status added = verifier::add_row(*manifest, row, add.common.manifest()); !added) return added;
  const std::string path = add.common.path_of(row.file);
  std::error_code failure;
  if (fs::exists(path, failure) && !fs::equivalent(path, add.trace, failure))
    return Error{ErrorCode::io, path + ": found an existing file, expected none", "give another --name, or remove it"};
  return {};
}

/// Fills in hash and size of the row, and examines it. `fresh`: where a trace is recorded.
Status examine(const GoldenAdd& add, const std::string& fresh, GoldenRow& row, GoldenOutcome& outcome) {
  std::error_code failure;
  const std::string& path = add.program ? add.trace : fresh;
  if (add.program) {
    auto reader = replay::TraceReader::open(path);
    if (!reader) return reader.error();
    row.hash = recorded_hash(*reader);
    if (row.hash.empty()) row.hash = "-";
  } else {
    const auto recorded = record_row(add.common, row, path);
    if (!recorded) return recorded.error();
    row.hash = hex64(recorded->root_hash);
    if (recorded->reason != replay::EndReason::complete)
      outcome.fail(exit_finding, row.file + ": the recording ended early: " + recorded->note);
  }
  row.size = fs::file_size(path, failure);
  check_size(add.common, row, row.size, outcome);
  if (row.size > add.common.size_max) return {};
  check_trace(add.common, row, path, outcome);
  for (Error& error : outcome.errors) error.hint.clear();  // they speak of a row that is there
  return {};
}

/// Puts the trace in its place and the row into the manifest, which others may have changed meanwhile.
Status put(const GoldenAdd& add, const std::string& fresh, const GoldenRow& row) {
  const std::string path = add.common.path_of(row.file);
  std::error_code failure;
  const bool is_in_place = add.program && fs::equivalent(add.trace, path, failure);
  Result<GoldenManifest> manifest = manifest_now(add.common);
  if (!manifest) return manifest.error();
  if (const Status added = verifier::add_row(*manifest, row, add.common.manifest()); !added) return added;
  failure.clear();
  if (add.program && !is_in_place) fs::copy_file(add.trace, fresh, fs::copy_options::overwrite_existing, failure);
  if (!failure && !is_in_place) fs::rename(fresh, path, failure);
  if (failure) return Error{ErrorCode::io, path + ": cannot be made: " + failure.message(), ""};
  const Status written = write_manifest(add.common, *manifest);
  if (!written && !is_in_place) fs::remove(path, failure);
  return written;
}

void print_added(const GoldenAdd& add, const GoldenRow& row, const GoldenOutcome& outcome) {
  if (add.common.json) {
    Json object = golden_json(add.common, "add", 1, outcome.code != exit_ok ? 1 : 0);
    object["rows"] = Json::array({row_json(row, outcome, "added")});
    return print_json(object);
  }
  if (outcome.code != exit_ok) return print(outcome.report);
  print(fmt::format("added  {}  {} bytes\n  hash    {}\n", add.common.path_of(row.file), row.size, row.hash));
}

int run_add(const GoldenAdd& add) {
  if (const Status words = check_words(add); !words) return fail_usage(words.error());
  catch_stop_signals();  // so that what was made is removed
  Copies copies;
  Result<GoldenRow> row = row_of(add, copies);
  if (!row) return fail_usage(row.error());
  if (const Status name = check_name(add, *row); !name) return fail_usage(name.error());
  const std::string fresh = add.common.path_of(row->file) + ".ticktrue-new";
  std::vector<GoldenOutcome> outcomes(1);
  GoldenOutcome& outcome = outcomes[0];
  Status done = examine(add, fresh, *row, outcome);
  end_programs(outcomes);
  if (done && outcome.code == exit_ok && stop_requested()) done = refuse("golden add: stopped: no row was added");
  if (done && outcome.code == exit_ok) done = put(add, fresh, *row);
  std::error_code ignored;
  fs::remove(fresh, ignored);
  if (!done) return add.program ? fail(done.error()) : fail_usage(done.error());
  if (outcome.code == exit_ok)
    copies.commit();
  else
    outcome.fail(outcome.code, add.common.manifest() + ": " + row->file + ": no row was added");
  for (const Error& error : outcome.errors) print_error(error);
  print_added(add, *row, outcome);
  return outcome.code;
}

}  // namespace

void add_golden_add(CLI::App& golden, CliContext& context) {
  auto options = std::make_shared<GoldenAdd>();
  CLI::App* add = golden.add_subcommand("add", "Add a trace and its row to the manifest, if the trace matches");
  add_common(*add, options->common, false);
  add->add_option("SCENE", options->scene,
                  "What is recorded: a scene as for `record`; with --plugin a setup, a file or a word");
  add->add_option("--name", options->name, "Of the trace in the directory, with or without .ttr")
      ->required()
      ->type_name("NAME");
  add->add_option("--inputs", options->inputs,
                  "Inputs as JSON Lines, or host:NAME or host:NAME:SEED for the frames of a host")
      ->type_name("FILE");
  add_number(*add, "--ticks", options->tick_count, "How many ticks (default: up to the `end` input)", {1});
  add->add_option("--detail", options->detail, "What is stored of each tick: root, cells, full or full:A..B")
      ->type_name("LEVEL")
      ->capture_default_str();
  add->add_option("--command", options->program,
                  "Instead of SCENE: the program that recorded --trace and verifies it, as for `verify`")
      ->type_name("WORDS");
  add->add_option("--trace", options->trace, "A trace that the program recorded; it is copied")->type_name("F.ttr");
  add->add_option("--why", options->why, "Why it is kept: the last column of the row")->type_name("TEXT");
  set_examples(*add,
               "mkdir golden\n"
               "ticktrue golden add golden 'stack?boxes=3' --ticks 60 --name stack --why 'contacts at rest'\n"
               "ticktrue golden check golden",
               "A file that is named as from the current directory alone is copied into DIR.\n"
               "For a program with a session:\n"
               "  ticktrue golden add golden --name duel --command './mygame --verify {}' --trace duel.ttr");
  add->callback([options, &context] { context.exit_code = run_add(*options); });
}

}  // namespace ticktrue::cli::golden
