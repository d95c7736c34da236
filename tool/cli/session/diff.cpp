// `ticktrue diff`: compares traces without simulating.
// SPDX-License-Identifier: MIT
#include "verifier/compare/diff.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>

#include "tool/cli/commands.h"
#include "tool/output/progress.h"
#include "tool/output/scene_differences.h"
#include "tool/session/simulations.h"
#include "verifier/compare/many/diff_many.h"

namespace ticktrue::cli {
namespace {

struct DiffCommand {
  std::string a;
  std::string b;
  std::vector<std::string> more;
  bool json = false;
  bool allow_truncated = false;
};

/// A file that can be read but is no whole trace is a verdict on the file, not a wrong call.
int fail_open(const Error& error) {
  print_error(error);
  return verifier::verdict_info(verifier::verdict_of_open_error(error.code)).exit_code;
}

verifier::DiffOptions options_for(const replay::TraceReader& reader, Progress& progress) {
  verifier::DiffOptions options;
  options.simulation = tool::find_simulation(reader.setup().simulation);
  options.tool = options.simulation == nullptr ? "" : tool::tool_command(options.simulation->name);
  options.setup_keys = tool::scene_differences;
  options.progress = [&](std::uint64_t ticks_done) { progress.update(ticks_done); };
  return options;
}

int run_diff_of_two(const DiffCommand& command) {
  Result<replay::TraceReader> a = replay::TraceReader::open(command.a);
  if (!a) return fail_open(a.error());
  Result<replay::TraceReader> b = replay::TraceReader::open(command.b);
  if (!b) return fail_open(b.error());
  Progress progress("diff " + command.a, a->tick_count_hint().value_or(0));
  const verifier::DiffReport report = verifier::diff(*a, *b, options_for(*a, progress));
  progress.finish();
  print(command.json ? verifier::diff_json(report) : verifier::diff_text(report));
  return report.exit_code(command.allow_truncated);
}

/// A file that cannot be opened is told, and the others are compared.
int run_diff_of_many(const DiffCommand& command) {
  std::vector<std::string> files{command.a, command.b};
  files.insert(files.end(), command.more.begin(), command.more.end());
  std::vector<std::optional<replay::TraceReader>> readers(files.size());
  std::vector<verifier::OpenedTrace> traces;
  std::vector<int> codes;
  const replay::TraceReader* first = nullptr;
  std::uint64_t tick_count = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    traces.push_back({files[i]});
    Result<replay::TraceReader> opened = replay::TraceReader::open(files[i]);
    if (!opened) {
      traces.back().error = opened.error().message;
      codes.push_back(fail_open(opened.error()));
      continue;
    }
    traces.back().reader = &readers[i].emplace(std::move(*opened));
    if (first == nullptr) first = traces.back().reader;
    tick_count = std::max(tick_count, readers[i]->tick_count_hint().value_or(0));
  }
  if (files.size() - codes.size() < 2) return verifier::worst_exit_code(codes);
  Progress progress("diff " + command.a, tick_count);
  const verifier::DiffManyReport report = verifier::diff_many(traces, options_for(*first, progress));
  progress.finish();
  print(command.json ? verifier::diff_many_json(report) : verifier::diff_many_text(report));
  codes.push_back(report.exit_code(command.allow_truncated));
  return verifier::worst_exit_code(codes);
}

int run_diff(const DiffCommand& command) {
  return command.more.empty() ? run_diff_of_two(command) : run_diff_of_many(command);
}

}  // namespace

void add_diff(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<DiffCommand>();
  CLI::App* command =
      app.add_subcommand("diff", "Compare traces of one match: setup, inputs and the first differing state")
          ->group(group_session);
  command->add_option("A", options->a, "Trace file")->required();
  command->add_option("B", options->b, "Trace file")->required();
  command->add_option("MORE", options->more, "Further traces: who differs from the majority is named");
  command->add_flag("--json", options->json,
                    "One JSON object (schema ticktrue.diff/2; of three or more traces ticktrue.diff_many/2)");
  command->add_flag("--allow-truncated", options->allow_truncated,
                    "Equal as far as all go is fine where one ends early");
  set_examples(*command,
               "ticktrue record stack --ticks 300 -o here.ttr\n"
               "ticktrue record 'stack?jitter=0.01' --ticks 300 -o there.ttr\n"
               "ticktrue diff here.ttr there.ttr\n"
               "ticktrue diff here.ttr there.ttr --json\n"
               "ticktrue record stack --ticks 300 -o third.ttr\n"
               "ticktrue diff here.ttr there.ttr third.ttr");
  command->callback([options, &context] { context.exit_code = run_diff(*options); });
}

}  // namespace ticktrue::cli
