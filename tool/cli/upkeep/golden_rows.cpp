// Sessions of rows, the comparison of a trace with its row, and the manifest as a file.
// SPDX-License-Identifier: MIT
#include "tool/cli/upkeep/golden_rows.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <filesystem>
#include <functional>
#include <memory>
#include <system_error>

#include "base/hash.h"
#include "tool/cli/commands.h"
#include "tool/corpus/verify_trace.h"
#include "tool/session/plugin_session.h"
#include "tool/session/session.h"
#include "tool/session/session_inputs.h"
#include "tool/session/simulations.h"
#include "verifier/plugins/plugin.h"
#include "verifier/programs/command_words.h"
#include "verifier/programs/verify_program.h"
#include "verifier/report/report_ci.h"
#include "verifier/runs/data_file.h"
#include "verifier/runs/plugin_isolation.h"
#include "verifier/runs/run_folder.h"
#include "verifier/verify/verify.h"

namespace ticktrue::cli::golden {
namespace {

namespace fs = std::filesystem;

// Close enough that a test of restoring has work, and readable by builds without zstd.
constexpr std::uint32_t golden_checkpoint_interval = 300;
constexpr double program_time_s = 600;  // of a run

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

/// A session of the row, ready to run: of the engine, or of the plug-in that is loaded.
struct RowSession {
  engine::Scene scene;
  std::unique_ptr<engine::Engine> engine;
  SessionInputs inputs;
  std::optional<OpenPluginSession> plugin;

  Simulation& simulation() { return plugin ? *plugin->simulation : *engine; }
  replay::InputSource& source() { return plugin ? *plugin->inputs : *inputs.source; }
  replay::TraceSetup setup(const tool::TraceChoices& choices) const {
    return plugin ? plugin_trace_setup(*plugin, choices) : tool::make_trace_setup(*engine, choices);
  }
};

Status open_plugin(const GoldenCommand& command, const GoldenRow& row, RowSession& session) {
  if (!has_plugin()) return Error{ErrorCode::usage, "found no plug-in, expected --plugin LIB.so", ""};
  PluginSession words;
  words.scene = find_file(command, std::string(*row.plugin_setup()));
  words.inputs = row.inputs.empty() ? "" : find_file(command, row.inputs);
  words.tick_count = row.tick_count;
  auto made = open_plugin_session(words);
  if (!made) return made.error();
  session.plugin.emplace(*std::move(made));
  return {};
}

Status open_engine(const GoldenCommand& command, const GoldenRow& row, RowSession& session) {
  auto scene = load_scene_argument(find_file(command, row.scene));
  if (!scene) return scene.error();
  session.scene = std::move(*scene);
  auto made = engine::make_engine(session.scene);
  if (!made) return made.error();
  session.engine = std::move(*made);
  const std::optional<HostOptions> host = host_of(row.inputs);
  const std::string path = row.inputs.empty() || host ? "" : find_file(command, row.inputs);
  auto inputs = open_session_inputs(session.scene, path, row.tick_count);
  if (!inputs) return inputs.error();
  session.inputs = std::move(*inputs);
  return use_clock(session.inputs, host.value_or(HostOptions{}), *session.engine);
}

Result<std::unique_ptr<RowSession>> open_session(const GoldenCommand& command, const GoldenRow& row) {
  auto session = std::make_unique<RowSession>();
  const Status opened = row.plugin_setup() ? open_plugin(command, row, *session) : open_engine(command, row, *session);
  if (!opened) return opened.error();
  return session;
}

/// The hash of the state behind the last tick.
Result<std::string> run_again(RowSession& session, const GoldenRow& row) {
  if (session.plugin) {
    const auto run = run_ticks(session.simulation(), session.source(), session.plugin->tick_count);
    if (!run) return run.error();
    return hex64(root_hash(session.simulation().state()));
  }
  const auto run = tool::run_session(*session.engine, session.source(), row.tick_count, {});
  if (!run) return run.error();
  return hex64(run->root_hash);
}

/// A row of a plug-in runs in a process of its own: what an earlier simulation left in the memory of the library has no
/// part in it, and a crash ends this row alone. Errors: those of the work; inconsistent (what the plug-in did wrong).
Result<std::string> in_own_process(const std::function<Result<std::string>()>& work) {
  const auto told = [&work]() -> Bytes {
    std::string text;
    try {
      const Result<std::string> result = work();
      text = result ? "+" + *result : "-" + result.error().message;
    } catch (const verifier::PluginFailure& failure) {
      text = std::string("-") + failure.what();
    }
    return Bytes(text.begin(), text.end());
  };
  const verifier::IsolatedPart done = verifier::run_part(told);
  if (!done.message.empty()) return Error{ErrorCode::inconsistent, done.message, ""};
  const std::string text(done.result.begin(), done.result.end());
  if (text.empty() || text[0] != '+') return Error{ErrorCode::usage, text.empty() ? "no result" : text.substr(1), ""};
  return text.substr(1);
}

/// What a recording left in a file. Errors: those of TraceReader::open; truncated (no end).
Result<replay::RecordResult> result_of_file(const std::string& path) {
  auto reader = replay::TraceReader::open(path);
  if (!reader) return reader.error();
  replay::RecordResult result;
  result.size = reader->size();
  for (;;) {
    const auto& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) result.root_hash = tick->root_hash;
  }
  if (!reader->tail().end) return Error{ErrorCode::truncated, path + ": " + reader->tail().message, ""};
  result.tick_count = reader->tail().end->tick_count;
  result.reason = reader->tail().end->reason;
  result.note = reader->tail().end->note;
  return result;
}

verifier::Report report_of_row(const GoldenRow& row, const std::string& path, Result<replay::TraceReader>& reader,
                               GoldenOutcome& outcome) {
  if (!reader) return verifier::open_error_report(path, reader.error());
  if (row.plugin_setup() && has_plugin()) {
    const auto work = [&](verifier::SharedCount& compared) {
      tool::TraceVerification how;
      how.compared = &compared;
      return tool::verify_trace(*reader, path, how);
    };
    return tool::verify_by_plugin(path, "replay", work).report;
  }
  if (row.command().empty()) {
    verifier::VerifyOptions options;
    options.simulation = tool::find_simulation(reader->setup().simulation);
    return verifier::verify(*reader, options);
  }
  const auto words = verifier::split_command(row.command());
  if (!words) return verifier::open_error_report(path, words.error());
  const auto folder = verifier::RunFolder::make("ticktrue-golden", "");
  if (!folder) return verifier::open_error_report(path, folder.error());
  verifier::ProgramVerdict verdict = verifier::verify_by_program(path, {*words, folder->path(), program_time_s}, "run");
  outcome.escaped = std::move(verdict.escaped);
  return std::move(verdict.report);
}

void compare_hash(const GoldenCommand& command, const GoldenRow& row, GoldenOutcome& outcome) {
  if (outcome.hash == row.hash) return;
  outcome.fail(
      exit_finding,
      command.manifest() + ": " + row.file + ": final root hash: found " + outcome.hash + ", expected " + row.hash,
      "meant? ticktrue golden update " + verifier::shell_word(command.directory) +
          " --reason TEXT; else: ticktrue verify " + verifier::shell_word(command.path_of(row.file)));
}

}  // namespace

std::string GoldenCommand::path_of(const std::string& name) const {
  return (fs::path(directory) / name).string();
}

void GoldenOutcome::fail(int with, std::string what, std::string hint) {
  const int codes[] = {code, with};
  code = worst_exit_code(codes);
  errors.push_back(Error{ErrorCode::io, std::move(what), std::move(hint)});
}

std::string find_file(const GoldenCommand& command, const std::string& word) {
  std::error_code failure;
  if (fs::is_regular_file(word, failure)) return word;
  return find_beside(command, word).value_or(word);
}

std::optional<std::string> find_beside(const GoldenCommand& command, const std::string& word) {
  std::error_code failure;
  const fs::path folder = fs::absolute(command.directory).lexically_normal();
  const fs::path beside = folder.has_filename() ? folder.parent_path() : folder.parent_path().parent_path();
  for (const fs::path& path : {beside / word, command.directory / fs::path(word)})
    if (fs::is_regular_file(path, failure)) return path.string();
  return std::nullopt;
}

Result<replay::RecordResult> record_row(const GoldenCommand& command, const GoldenRow& row, const std::string& path) {
  std::error_code failure;
  fs::remove(path, failure);
  const auto work = [&]() -> Result<replay::RecordResult> {
    auto session = open_session(command, row);
    if (!session) return session.error();
    tool::TraceChoices choices;
    choices.checkpoint_interval = golden_checkpoint_interval;
    if (const Status detail = parse_detail(row.detail, choices); !detail) return detail.error();
    replay::RecordOptions options;
    options.tick_count = (*session)->plugin ? (*session)->plugin->tick_count : row.tick_count;
    options.writer.compress = false;
    return replay::record((*session)->simulation(), (*session)->source(), path, (*session)->setup(choices),
                          tool::make_build_facts(), options);
  };
  if (!row.plugin_setup()) return work();
  const Result<std::string> done = in_own_process([&]() -> Result<std::string> {
    const Result<replay::RecordResult> recorded = work();
    if (!recorded) return recorded.error();
    return std::string();
  });
  if (!done) return done.error();
  return result_of_file(path);
}

void verify_row(const GoldenRow& row, const std::string& path, Result<replay::TraceReader>& reader,
                GoldenOutcome& outcome) {
  const verifier::Report report = report_of_row(row, path, reader, outcome);
  if (report.verdict == verifier::Verdict::match) return;
  outcome.report = verifier::report_text(report);
  outcome.fail(report.exit_code(), path + ": " + std::string(verifier::verdict_info(report.verdict).name) + ": " +
                                       verifier::report_sentence(report));
}

std::string recorded_hash(replay::TraceReader& reader) {
  std::string hash;
  reader.rewind();
  for (;;) {
    const auto& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) return hash;
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) hash = hex64(tick->root_hash);
  }
}

void check_size(const GoldenCommand& command, const GoldenRow& row, std::uint64_t size, GoldenOutcome& outcome) {
  if (size <= command.size_max) return;
  outcome.fail(
      exit_finding,
      command.manifest() + ": " + row.file + ": size: found " + std::to_string(size) + " bytes, expected at most " +
          std::to_string(command.size_max),
      "record fewer ticks or less detail; --size-max " + std::to_string(size) + " allows it, here and in each check");
}

void check_trace(const GoldenCommand& command, const GoldenRow& row, const std::string& path, GoldenOutcome& outcome) {
  const std::string place = command.manifest() + ": " + row.file;
  auto reader = replay::TraceReader::open(path);
  std::error_code failure;
  outcome.size = fs::file_size(path, failure);
  if (outcome.size != row.size)
    outcome.fail(exit_finding, place + ": size: found " + std::to_string(outcome.size) + " bytes, expected " +
                                   std::to_string(row.size));
  check_size(command, row, outcome.size, outcome);
  verify_row(row, path, reader, outcome);
  if (!row.command().empty()) {
    if (!reader) return;
    outcome.hash = recorded_hash(*reader);
    return compare_hash(command, row, outcome);
  }
  const auto work = [&]() -> Result<std::string> {
    auto session = open_session(command, row);
    if (!session) return session.error();
    return run_again(**session, row);
  };
  const Result<std::string> hash = row.plugin_setup() ? in_own_process(work) : work();
  if (!hash) {
    outcome.fail(exit_usage, place + ": cannot be recorded anew: " + hash.error().message);
    return;
  }
  outcome.hash = *hash;
  compare_hash(command, row, outcome);
}

Result<GoldenManifest> read_manifest(const GoldenCommand& command, bool may_be_empty) {
  const std::string path = command.manifest();
  const Result<std::string> text = read_text_file(path, std::size_t{16} << 20);
  if (!text) return text.error();
  auto manifest = verifier::parse_manifest(*text, path);
  if (manifest && manifest->rows.empty() && !may_be_empty)
    return Error{ErrorCode::invalid_input, path + ": found no trace, expected at least one row", ""};
  return manifest;
}

Status write_manifest(const GoldenCommand& command, const GoldenManifest& manifest) {
  return verifier::write_data_file(command.manifest(), verifier::manifest_text(manifest));
}

void end_programs(const std::vector<GoldenOutcome>& outcomes) {
  for (const GoldenOutcome& outcome : outcomes) verifier::end_escaped(outcome.escaped);
}

Json row_json(const GoldenRow& row, const GoldenOutcome& outcome, const char* result) {
  Json object = {{"file", row.file}};
  object["outcome"] = outcome.code != exit_ok ? "failed" : result;
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

Json golden_json(const GoldenCommand& command, const char* subcommand, std::size_t row_count, std::size_t failed) {
  Json object = {{"schema", "ticktrue.golden/1"},
                 {"command", subcommand},
                 {"directory", command.directory},
                 {"reason", command.reason}};
  object["passed"] = row_count - failed;
  object["failed"] = failed;
  object["expected"] = 0;
  object["not_applicable"] = 0;
  return object;
}

void add_common(CLI::App& command, GoldenCommand& options, bool has_jobs) {
  command.add_option("DIR", options.directory, "Directory with the traces and MANIFEST.tsv")->required();
  add_number(command, "--size-max", options.size_max, "Bytes a golden trace may have (default 65536)");
  if (has_jobs) add_number(command, "-j,--jobs", options.jobs, "Threads (default: every core)", {1, 1024});
  command.add_flag("--json", options.json, "One JSON object (schema ticktrue.golden/1)");
}

}  // namespace ticktrue::cli::golden
