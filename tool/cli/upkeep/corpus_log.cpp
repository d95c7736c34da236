// `ticktrue corpus log`: which commit changed the bits of a trace first.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "base/count_text.h"
#include "base/hash128.h"
#include "tool/cli/commands.h"
#include "tool/cli/upkeep/corpus_commands.h"
#include "tool/corpus/trace_log.h"
#include "tool/output/json_output.h"

namespace ticktrue::cli {
namespace {

using tool::TraceLog;
using verifier::HistoryRow;
using verifier::StoreFolder;

constexpr std::size_t short_digest_size = 8;  // hexadecimal digits

struct LogCommand {
  std::string trace;
  std::string store;
  std::string mode = "replay";
  bool json = false;
};

std::string ticks_text(const HistoryRow& row) {
  if (row.diverged) return "other bits at tick " + std::to_string(*row.diverged);
  return std::to_string(row.ticks_compared) + " of " + std::to_string(row.ticks_recorded);
}

std::string build_words(const HistoryRow& row) {
  return "commit " + row.commit + " (engine " + hex128(row.engine).substr(0, short_digest_size) + ")";
}

void print_log(const TraceLog& log, const LogCommand& command) {
  print(fmt::format("{}: {} in {}\n", command.trace, count_text(log.rows.size(), "verdict"), command.store));
  print(fmt::format("  {:19}  {:12}  {:8}  {:16}  {}\n", "verified (UTC)", "commit", "engine", "verdict", "ticks"));
  for (const HistoryRow& row : log.rows)
    print(fmt::format("  {:19}  {:12}  {:8}  {:16}  {}\n", tool::time_text(row.when_s), row.commit,
                      hex128(row.engine).substr(0, short_digest_size), row.verdict, ticks_text(row)));
  if (!log.changed) {
    print("no build changed its bits\n");
    return;
  }
  const HistoryRow& changed = log.rows[*log.changed];
  print("first changed by " + build_words(changed) +
        (changed.diverged ? ", at tick " + std::to_string(*changed.diverged) : std::string()) + "\n");
  print(log.last_match ? "last match before it: " + build_words(log.rows[*log.last_match]) + "\n"
                       : "no match is known before it\n");
}

Json row_json(const HistoryRow& row) {
  Json object;
  object["verified"] = tool::time_text(row.when_s);
  object["commit"] = row.commit;
  object["build"] = row.build;
  object["engine"] = hex128(row.engine);
  object["libraries"] = hex128(row.libraries);
  object["options"] = row.options;
  object["verdict"] = row.verdict;
  object["ticks_recorded"] = row.ticks_recorded;
  object["ticks_compared"] = row.ticks_compared;
  object["diverged_at"] = row.diverged ? Json(*row.diverged) : Json(nullptr);
  object["seconds"] = row.seconds;
  object["key"] = row.key;
  return object;
}

void print_log_json(const TraceLog& log, const LogCommand& command) {
  Json object = {{"schema", "ticktrue.corpus_log/1"}};
  object["file"] = command.trace;
  object["store"] = command.store;
  object["mode"] = command.mode;
  object["changed_by"] = log.changed ? Json(log.rows[*log.changed].commit) : Json(nullptr);
  object["last_match"] = log.last_match ? Json(log.rows[*log.last_match].commit) : Json(nullptr);
  Json rows = Json::array();
  for (const HistoryRow& row : log.rows) rows.push_back(row_json(row));
  object["rows"] = std::move(rows);
  print_json(object);
}

int run_log(const LogCommand& command) {
  const Result<StoreFolder> folder = StoreFolder::open(command.store, StoreFolder::Use::reading, false);
  if (!folder) return fail_usage(folder.error());
  const Result<TraceLog> log = tool::read_trace_log(command.trace, *folder, command.mode);
  if (!log) return fail_usage(log.error());
  for (const std::string& warning : log->warnings) print_warning(warning);
  if (log->rows.empty())
    return fail_usage(Error{ErrorCode::io,
                            command.trace + ": found no verdict of any build in " + command.store + ", expected one",
                            "ticktrue corpus verify " + verifier::shell_word(command.trace) + " --cache " +
                                verifier::shell_word(command.store)});
  if (command.json)
    print_log_json(*log, command);
  else
    print_log(*log, command);
  return exit_ok;
}

}  // namespace

void add_corpus_log(CLI::App& corpus, CliContext& context) {
  auto options = std::make_shared<LogCommand>();
  CLI::App* command = corpus.add_subcommand("log", "Say which commit changed the bits of a trace first");
  command->add_option("TRACE", options->trace, "The trace; its bytes count, not its name")->required();
  command->add_option("--cache", options->store, "The store of verdicts")->type_name("STORE")->required();
  command->add_option("--mode", options->mode, "The verdicts of this mode")
      ->check(CLI::IsMember(verify_mode_names()))
      ->capture_default_str();
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.corpus_log/1)");
  set_examples(*command,
               "ticktrue record 'stack?boxes=10' --ticks 60 -o stack.ttr\n"
               "ticktrue corpus verify stack.ttr --cache verdicts\n"
               "ticktrue corpus log stack.ttr --cache verdicts\n"
               "ticktrue corpus log stack.ttr --cache verdicts --json",
               "Rows are in the order of verification. A build with the engine of an earlier one verifies nothing,\n"
               "and has no row. The exit code is 0 whatever the verdicts are, 2 where there is none.");
  command->callback([options, &context] { context.exit_code = run_log(*options); });
}

}  // namespace ticktrue::cli
