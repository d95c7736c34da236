// `ticktrue diff`: compares two traces without simulating.
// SPDX-License-Identifier: MIT
#include "verifier/compare/diff.h"

#include <CLI/CLI.hpp>

#include "tool/cli/commands.h"
#include "tool/output/progress.h"
#include "tool/session/simulations.h"

namespace ticktrue::cli {
namespace {

struct DiffCommand {
  std::string a;
  std::string b;
  bool json = false;
  bool allow_truncated = false;
};

/// A file that can be read but is no whole trace is a verdict on the file, not a wrong call.
int fail_open(const Error& error) {
  print_error(error);
  return verifier::verdict_info(verifier::verdict_of_open_error(error.code)).exit_code;
}

int run_diff(const DiffCommand& command) {
  Result<replay::TraceReader> a = replay::TraceReader::open(command.a);
  if (!a) return fail_open(a.error());
  Result<replay::TraceReader> b = replay::TraceReader::open(command.b);
  if (!b) return fail_open(b.error());
  verifier::DiffOptions options;
  options.simulation = verifier::find_simulation(a->setup().simulation);
  options.tool = options.simulation == nullptr ? "" : verifier::tool_command(options.simulation->name);
  Progress progress("diff " + command.a, a->tick_count_hint().value_or(0));
  options.progress = [&](std::uint64_t ticks_done) { progress.update(ticks_done); };
  const verifier::DiffReport report = verifier::diff(*a, *b, options);
  progress.finish();
  print(command.json ? verifier::diff_json(report) : verifier::diff_text(report));
  return report.exit_code(command.allow_truncated);
}

}  // namespace

void add_diff(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<DiffCommand>();
  CLI::App* command = app.add_subcommand("diff", "Compare two traces: setup, inputs and the first differing state")
                          ->group(group_session);
  command->add_option("A", options->a, "Trace file")->required();
  command->add_option("B", options->b, "Trace file")->required();
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.diff/1)");
  command->add_flag("--allow-truncated", options->allow_truncated,
                    "Equal as far as both go is fine where one ends early");
  set_examples(*command,
               "ticktrue record stack --ticks 300 -o here.ttr\n"
               "ticktrue record 'stack?jitter=0.01' --ticks 300 -o there.ttr\n"
               "ticktrue diff here.ttr there.ttr\n"
               "ticktrue diff here.ttr there.ttr --json");
  command->callback([options, &context] { context.exit_code = run_diff(*options); });
}

}  // namespace ticktrue::cli
