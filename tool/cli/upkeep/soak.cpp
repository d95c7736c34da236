// `ticktrue soak`: random worlds, run in every way that may not change a bit.
// SPDX-License-Identifier: MIT
#include "tool/experiment/soak/soak.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <system_error>

#include "base/hash.h"
#include "base/limits.h"
#include "base/parallel/jobs.h"
#include "engine/random_worlds/world_hashes.h"
#include "tool/cli/commands.h"
#include "tool/experiment/soak/cache_counts.h"
#include "tool/experiment/soak/failure_files.h"
#include "tool/experiment/soak/soak_report.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::cli {
namespace {

namespace soak = soak;

constexpr std::uint64_t known_world_count = 100;     // of --write-known
constexpr std::uint64_t worlds_until_all_hit = 400;  // the rarest cached structure is hit in one world of thirty

struct SoakCommand {
  std::string scene;
  std::string inputs;
  std::optional<std::uint64_t> tick_count;
  std::uint64_t world_count = 1000;
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> world;
  std::uint64_t time_s = 0;
  std::uint64_t jobs = 0;
  std::uint64_t failure_count_max = 8;
  bool resume = false;
  bool json = false;
  std::string folder = "out/soak";
  std::vector<std::string> checks;
  std::string known;
  std::string write_known;
  std::string hashes;
  std::string write_hashes;
  std::string cache_counts;
  std::string write_cache_counts;
};

/// This program, for the check `process`.
std::string own_program() {
  std::error_code failed;
  const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", failed);
  return failed ? std::string() : path.string();
}

Result<soak::OracleOptions> oracle_options(const SoakCommand& command) {
  soak::OracleOptions options;
  options.make = engine::make_engine;
  options.files.tool = own_program();
  if (command.checks.empty()) return options;
  const auto checks = soak::parse_checks(command.checks);
  if (!checks) return checks.error();
  options.checks = *checks;
  return options;
}

/// A scene that was given: each check finds something, or nothing.
int run_on_scene(const SoakCommand& command, soak::OracleOptions oracle) {
  const Result<engine::Scene> scene = load_session_scene(command.scene);
  if (!scene) return fail_usage(scene.error());
  if (!command.tick_count)
    return fail_usage(Error{ErrorCode::usage, "--ticks: found nothing, expected how many ticks the scene runs", ""});
  const auto soak_case = soak::read_case(*scene, command.inputs, *command.tick_count);
  if (!soak_case) return fail_usage(soak_case.error());
  std::error_code failed;
  std::filesystem::create_directories(command.folder, failed);
  if (failed) return fail_usage(Error{ErrorCode::io, command.folder + ": cannot be made: " + failed.message(), ""});
  oracle.files.path = command.folder + "/scene.ttr";
  const soak::WorldResult result = soak::examine(*soak_case, command.seed, oracle);
  std::string text = (result.findings.empty() ? "match  " : "FOUND  ") + command.scene + "  " +
                     std::to_string(result.base.tick_count) + " ticks\n";
  for (const soak::Finding& finding : result.findings)
    text += "  " + soak::variant_text(finding.variant) + "  tick " + std::to_string(finding.tick) + "\n    " +
            finding.what + "\n";
  print(text);
  return result.findings.empty() ? exit_ok : exit_finding;
}

Status write_file(const std::string& path, const std::string& text) {
  Result<verifier::DataFile> file = verifier::DataFile::create(path, true);
  if (!file) return file.error();
  if (const Status written = file->write(text); !written) return written;
  return file->close();
}

Status write_known_file(const std::string& path, const soak::SoakOptions& options, const soak::SoakCounters& counters) {
  const soak::KnownFile known{options.seed, options.known_world_count, counters.known};
  return write_file(path, soak::print_known(known));
}

int run_worlds(const SoakCommand& command, const soak::OracleOptions& oracle) {
  soak::SoakOptions options;
  options.seed = command.seed;
  options.world_count = command.world_count;
  options.only_world = command.world;
  options.time_s = static_cast<double>(command.time_s);
  options.thread_count = command.jobs == 0 ? core_count() : static_cast<unsigned>(command.jobs);
  options.resume = command.resume;
  options.folder = command.folder;
  options.failure_count_max = static_cast<std::size_t>(command.failure_count_max);
  for (const std::string& word : command.checks) options.checks_text += (options.checks_text.empty() ? "" : ",") + word;
  options.oracle = oracle;
  options.worlds = soak::random_worlds();
  if (command.checks.empty() && !command.world) options.hits_expected_after = worlds_until_all_hit;

  std::optional<soak::KnownFile> known;
  if (!command.known.empty()) {
    const Result<std::string> text = read_text_file(command.known, std::size_t{1} << 20);
    if (!text) return fail_usage(text.error());
    const auto parsed = soak::parse_known(*text, command.known);
    if (!parsed) return fail_usage(parsed.error());
    if (parsed->seed == command.seed) known = *parsed;
  }
  if (known) options.known_world_count = known->world_count;
  if (!command.write_known.empty()) options.known_world_count = known_world_count;

  catch_stop_signals();
  Progress progress("soak", command.world ? 1 : command.world_count, "worlds");
  options.progress = [&](const soak::SoakCounters& counters, double) {
    progress.update(counters.world_count);
    return !stop_requested();
  };
  const Result<soak::SoakReport> report = soak::run_soak(options);
  progress.finish();
  if (!report) return fail_usage(report.error());
  const bool has_all_known = !command.world && report->counters.world_count >= options.known_world_count;
  soak::KnownComparison compared;
  if (known && has_all_known) compared = soak::compare_known(known->counts, report->counters.known);
  if (!command.write_known.empty()) {
    if (!has_all_known)
      return fail_usage(Error{ErrorCode::usage,
                              "--write-known: found " + std::to_string(report->counters.world_count) +
                                  " worlds, expected at least " + std::to_string(known_world_count),
                              "give --worlds " + std::to_string(known_world_count)});
    if (const Status written = write_known_file(command.write_known, options, report->counters); !written)
      return fail_usage(written.error());
  }
  print(command.json ? soak::soak_json(options, *report, compared) : soak::soak_text(options, *report, compared));
  const bool is_clean =
      report->counters.failures.empty() && compared.rose.empty() && soak::never_hit(options, report->counters).empty();
  return is_clean ? exit_ok : exit_finding;
}

/// Runs the worlds of the file, and compares their hashes with those that stand there. What their cached structures
/// count is added to `counts`.
Status compare_hashes(const std::string& path, engine::CacheReport& counts) {
  const Result<std::string> text = read_text_file(path, std::size_t{1} << 20);
  if (!text) return text.error();
  const auto worlds = engine::parse_world_hashes(*text, path);
  if (!worlds) return worlds.error();
  for (const engine::WorldHash& expected : *worlds) {
    const engine::WorldHash found = engine::hash_world(expected.seed, &counts);
    if (found == expected) continue;
    return Error{ErrorCode::inconsistent,
                 path + ": world " + std::to_string(expected.seed) + ": found hash " + hex64(found.hash) + " after " +
                     std::to_string(found.tick_count) + " ticks, expected " + hex64(expected.hash) + " after " +
                     std::to_string(expected.tick_count),
                 "the physics of this build gives other bits: `ticktrue golden check traces` names the traces"};
  }
  return {};
}

Status compare_counts(const std::string& path, const engine::CacheReport& found) {
  const Result<std::string> text = read_text_file(path, std::size_t{1} << 20);
  if (!text) return text.error();
  const auto expected = soak::parse_cache_counts(*text, path);
  if (!expected) return expected.error();
  return soak::compare_cache_counts(*expected, found, path);
}

Status write_hashes(const std::string& path, std::uint64_t world_count) {
  std::vector<engine::WorldHash> worlds;
  for (std::uint64_t seed = 1; seed <= world_count; ++seed) worlds.push_back(engine::hash_world(seed));
  return write_file(path, engine::print_world_hashes(worlds));
}

/// What stands in files about some worlds, before the soak.
Status compare_with_files(const SoakCommand& command) {
  engine::CacheReport counts;
  if (const Status same = compare_hashes(command.hashes, counts); !same) return same;
  if (command.write_cache_counts.empty() && command.cache_counts.empty()) return {};
  if (const Status counted = soak::add_counts_of_scenes(counts); !counted) return counted;
  if (!command.write_cache_counts.empty())
    return write_file(command.write_cache_counts, soak::print_cache_counts(counts));
  if (!command.cache_counts.empty()) return compare_counts(command.cache_counts, counts);
  return {};
}

int run_soak_command(const SoakCommand& command) {
  const auto oracle = oracle_options(command);
  if (!oracle) return fail_usage(oracle.error());
  if (!command.write_hashes.empty()) {
    const Status written = write_hashes(command.write_hashes, command.world_count);
    return written ? exit_ok : fail_usage(written.error());
  }
  if (command.hashes.empty() && (!command.cache_counts.empty() || !command.write_cache_counts.empty()))
    return fail_usage(
        Error{ErrorCode::usage, "--cache-counts: found no --hashes, expected the worlds to count in", ""});
  if (!command.hashes.empty())
    if (const Status same = compare_with_files(command); !same) return fail_usage(same.error());
  if (!command.write_cache_counts.empty()) return exit_ok;
  return command.scene.empty() ? run_worlds(command, *oracle) : run_on_scene(command, *oracle);
}

}  // namespace

void add_soak(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<SoakCommand>();
  CLI::App* command =
      app.add_subcommand("soak", "Run random worlds in every way that may not change a bit")->group(group_upkeep);
  command->add_option("SCENE", options->scene, "Examine this scene instead of random worlds; needs --ticks");
  command->add_option("--inputs", options->inputs, "Inputs of SCENE as JSON Lines")->type_name("FILE");
  add_number(*command, "--ticks", options->tick_count, "Ticks of SCENE", {1, limits::tick_count_max});
  add_number(*command, "--worlds", options->world_count, "How many worlds (default 1000)", {1, 100'000'000});
  add_number(*command, "--seed", options->seed, "Of the worlds, and of what is drawn in them (default 1)");
  add_number(*command, "--world", options->world, "Only the world with this index");
  add_number(*command, "--time", options->time_s, "Begin no world after so many seconds", {1, 1'000'000});
  command->add_flag("--resume", options->resume, "Go on from the progress in the folder of --out");
  command->add_option("--checks", options->checks, "These checks alone; restore=57: only that variant of a check")
      ->delimiter(',')
      ->type_name("LIST");
  add_number(*command, "--failures", options->failure_count_max, "End after so many failures (default 8)",
             {1, 1'000'000});
  command->add_option("--out", options->folder, "Folder for progress and failures (default out/soak)")
      ->type_name("DIR");
  command->add_option("--known", options->known, "Fail if a count of physics in this file rises")->type_name("FILE");
  command->add_option("--write-known", options->write_known, "Write these counts of the first 100 worlds")
      ->type_name("FILE");
  command->add_option("--hashes", options->hashes, "First compare the worlds of this file with their hashes there")
      ->type_name("FILE");
  command
      ->add_option("--write-hashes", options->write_hashes,
                   "Write the hashes of the worlds of seeds 1 to --worlds, no more")
      ->type_name("FILE");
  command
      ->add_option("--cache-counts", options->cache_counts,
                   "With --hashes: also compare how often cached structures were used again")
      ->type_name("FILE");
  command
      ->add_option("--write-cache-counts", options->write_cache_counts,
                   "With --hashes: write how often cached structures were used again, no more")
      ->type_name("FILE");
  add_number(*command, "-j,--jobs", options->jobs, "Worlds at once; default: one a core", {1, 1024});
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.soak/1)");
  set_examples(*command,
               "ticktrue soak --worlds 4 --seed 7 --checks cold,forget,restore\n"
               "ticktrue soak --seed 7 --world 2 --checks broad_phase,trace\n"
               "ticktrue soak 'stack?boxes=5' --ticks 60 --checks broad_phase,restore=30");
  command->callback([options, &context] { context.exit_code = run_soak_command(*options); });
}

}  // namespace ticktrue::cli
