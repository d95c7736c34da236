// `ticktrue inject`: flips bits and requires that verify names exactly the place.
// SPDX-License-Identifier: MIT
#include "verifier/inject/inject.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "base/parallel/jobs.h"
#include "engine/engine.h"
#include "engine/scene/scene_binary.h"
#include "tool/cli/commands.h"
#include "tool/output/progress.h"
#include "tool/session/simulations.h"

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

/// Whether --after-substep can be met in some tick. How many substeps an island gets under automatic ones, only its
/// ticks say: there the most that it may get counts.
Status check_substep(std::uint64_t after, const replay::TraceSetup& setup) {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::usage, "--after-substep: " + what, "without it bits are flipped at the end of a tick"};
  };
  if (setup.simulation != engine::engine_info().name)
    return refuse("found simulation " + setup.simulation + ", expected " + std::string(engine::engine_info().name));
  const Result<engine::Scene> scene = engine::decode_scene(setup.setup);
  if (!scene) return {};  // verify says why
  const engine::Settings& settings = scene->settings;
  if (settings.solver != engine::SolverKind::tgs_soft)
    return refuse("found solver " + std::string(engine::info_of(engine::solvers, settings.solver).name) +
                  ", expected tgs_soft");
  const int count = settings.auto_substeps ? settings.auto_substeps->substeps_max : settings.substeps;
  if (after < static_cast<std::uint64_t>(count)) return {};
  return refuse("found " + std::to_string(after) + ", expected 0.." + std::to_string(count - 1) +
                ", the substeps of a tick");
}

int run_inject(const InjectCommand& command) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(command.file);
  if (!reader) {
    print_error(reader.error());
    return verifier::verdict_info(verifier::verdict_of_open_error(reader.error().code)).exit_code;
  }
  if (const Status whole = reader->check_from_start(); !whole) return fail_usage(whole.error());
  if (command.after_substep)
    if (const Status known = check_substep(*command.after_substep, reader->setup()); !known)
      return fail_usage(known.error());
  verifier::InjectOptions options;
  options.simulation = tool::find_simulation(reader->setup().simulation);
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
  if (options.simulation != nullptr && tool::runs_on_threads(*options.simulation))
    options.thread_count =
        command.jobs == 0 ? core_count() : static_cast<unsigned>(std::min<std::uint64_t>(command.jobs, 1024));
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
  CLI::Option* row = add_number(*command, "--row", options->row, "Flip in this row; without it: any");
  add_number(*command, "--lane", options->lane, "Flip in this lane; without it: any", {0, 255});
  add_number(*command, "--bit", options->bit, "Flip this bit, 0 is the lowest; without it: any", {0, 63});
  add_number(*command, "--bodies", options->bodies, "Flip a bit in each of so many bodies at once", {1, 64})
      ->excludes(row);
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
