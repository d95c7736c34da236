// `ticktrue inject`: flips bits and requires that verify names exactly the place.
// SPDX-License-Identifier: MIT
#include "verifier/inject.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "verifier/cli/commands.h"
#include "verifier/cli/progress.h"
#include "verifier/parallel.h"
#include "verifier/simulations.h"

namespace ticktrue::cli {
namespace {

constexpr std::uint64_t flip_count_max = 100'000;  // what was found is kept for each, about 1 KB

struct InjectCommand {
  std::string file;
  std::uint64_t count = 1;
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> tick;
  std::string table;
  std::string column;
  std::optional<std::uint64_t> row;
  std::optional<std::uint64_t> lane;
  std::optional<std::uint64_t> bit;
  std::uint64_t bodies = 0;
  std::optional<std::uint64_t> after_substep;
  std::uint64_t jobs = 0;  // 0: every core
  bool json = false;
};

int run_inject(const InjectCommand& command) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(command.file);
  if (!reader) {
    print_error(reader.error());
    return verifier::verdict_info(verifier::verdict_of_open_error(reader.error().code)).exit_code;
  }
  verifier::InjectOptions options;
  options.simulation = verifier::find_simulation(reader->setup().simulation);
  options.count = command.count;
  options.seed = command.seed;
  options.tick = command.tick;
  options.table = command.table;
  options.column = command.column;
  options.row = command.row;
  if (command.lane) options.lane = static_cast<std::uint32_t>(*command.lane);
  if (command.bit) options.bit = static_cast<std::uint32_t>(*command.bit);
  options.body_count = static_cast<std::uint32_t>(command.bodies);
  if (command.after_substep) options.after_substep = static_cast<std::uint32_t>(*command.after_substep);
  if (options.simulation != nullptr && verifier::runs_on_threads(*options.simulation))
    options.thread_count =
        command.jobs == 0 ? verifier::core_count() : static_cast<unsigned>(std::min<std::uint64_t>(command.jobs, 1024));
  options.reopen = [&command]() -> std::unique_ptr<verifier::TraceSource> {
    auto again = replay::TraceReader::open(command.file);
    if (!again) return nullptr;
    return std::make_unique<verifier::OwnedReaderSource>(std::move(*again));
  };
  Progress progress("inject " + command.file, command.count, "flips");
  options.progress = [&](std::uint64_t flips_done) { progress.update(flips_done); };
  const Result<verifier::InjectReport> report = verifier::inject(*reader, options);
  progress.finish();
  if (!report) return fail_usage(report.error());
  print(command.json ? verifier::inject_json(*report) : verifier::inject_text(*report));
  return report->exit_code();
}

}  // namespace

void add_inject(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<InjectCommand>();
  CLI::App* command =
      app.add_subcommand("inject", "Flip bits of the state and require that verify finds each")->group(group_upkeep);
  command->add_option("FILE", options->file, "Trace, recorded with --detail cells or full")->required();
  add_number(*command, "--count", options->count, "How many flips, one at a time", {1, flip_count_max});
  add_number(*command, "--seed", options->seed, "Of the places that are drawn");
  add_number(*command, "--tick", options->tick, "Flip at the end of this tick; without it: any");
  command->add_option("--table", options->table, "Flip in this table; without it: any that has rows");
  command->add_option("--column", options->column, "Flip in this column; without it: any");
  add_number(*command, "--row", options->row, "Flip in this row; without it: any");
  add_number(*command, "--lane", options->lane, "Flip in this lane; without it: any", {0, 255});
  add_number(*command, "--bit", options->bit, "Flip this bit, 0 is the lowest; without it: any", {0, 63});
  add_number(*command, "--bodies", options->bodies, "Flip a bit in each of so many bodies at once", {1, 64});
  add_number(*command, "--after-substep", options->after_substep,
             "Flip a bit of a body inside the solver, after this substep, the first is 0", {0, 255});
  add_number(*command, "-j,--jobs", options->jobs, "Threads (default: every core); they change nothing of the report",
             {1, 1024});
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.inject/1)");
  set_examples(*command,
               "ticktrue record 'stack?boxes=10' --ticks 300 --detail full -o stack.ttr\n"
               "ticktrue inject stack.ttr --count 2000 --seed 1 --json\n"
               "ticktrue inject stack.ttr --tick 137 --table bodies --column velocity --row 4 --lane 1 --bit 0");
  command->callback([options, &context] { context.exit_code = run_inject(*options); });
}

}  // namespace ticktrue::cli
