// Formats the summary of a soak.
// SPDX-License-Identifier: MIT
#include "tool/experiment/soak/soak_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace ticktrue::soak {
namespace {

using Json = nlohmann::ordered_json;

double worlds_per_second(const SoakReport& report) {
  return report.seconds > 0 ? static_cast<double>(report.new_worlds) / report.seconds : 0;
}

/// Pairs of choices by the number of worlds that use both.
struct PairCoverage {
  std::uint64_t enough = 0;  // pairs in at least pair_count_wanted worlds
  std::vector<std::string> rare;
  std::vector<std::string> never;  // pairs of rows in different tables
};
constexpr std::uint64_t pair_count_wanted = 5;

std::string_view table_of(std::string_view choice) {
  return choice.substr(0, choice.find('/'));
}

PairCoverage pair_coverage(const SoakOptions& options, const SoakCounters& counters) {
  PairCoverage coverage;
  const std::vector<std::string>& choices = options.worlds.choices;
  for (std::size_t i = 0; i < choices.size(); ++i)
    for (std::size_t k = i + 1; k < choices.size(); ++k) {
      const auto found = counters.pairs.find(std::minmax(choices[i], choices[k]));
      const std::string names = choices[i] + " and " + choices[k];
      if (found != counters.pairs.end() && found->second >= pair_count_wanted)
        ++coverage.enough;
      else if (found != counters.pairs.end())
        coverage.rare.push_back(names + ": " + std::to_string(found->second));
      else if (table_of(choices[i]) != table_of(choices[k]))
        coverage.never.push_back(names);
    }
  return coverage;
}

std::string checks_text(const SoakCounters& counters) {
  std::string text = "  checks\n";
  for (const CheckInfo& info : check_table)
    text += fmt::format("    {:<16} {:>9} runs  {}\n", info.name,
                        counters.run_counts[static_cast<std::size_t>(info.kind)], info.summary);
  return text;
}

std::string caches_text(const SoakCounters& counters) {
  std::string text =
      fmt::format("  cached structures {:>14} {:>14} {:>20}\n", "hits", "invalidations", "compared while hit");
  for (const engine::CacheInfo& info : engine::cache_kinds) {
    const auto i = static_cast<std::size_t>(info.kind);
    text += fmt::format("    {:<15} {:>14} {:>14} {:>20}\n", info.name, counters.caches[i].hits,
                        counters.caches[i].invalidations, counters.while_hit[i]);
  }
  return text;
}

std::string choices_text(const SoakOptions& options, const SoakCounters& counters) {
  if (options.worlds.choices.empty()) return "";
  std::string text = fmt::format("  rows {:<32} {:>8} {:>12}\n", "", "worlds", "with effect");
  for (const std::string& name : options.worlds.choices) {
    const auto found = counters.choices.find(name);
    const ChoiceCoverage choice = found == counters.choices.end() ? ChoiceCoverage{} : found->second;
    const std::string effect = options.worlds.choice_changes_bits(name)
                                   ? fmt::format("{} of {}", choice.effect, choice.measured)
                                   : std::string("changes no bit");
    text += fmt::format("    {:<33} {:>8} {:>12}\n", name, choice.active, effect);
  }
  const PairCoverage pairs = pair_coverage(options, counters);
  text += fmt::format("  pairs of rows  {} in at least {} worlds, {} in fewer, {} of different tables in none\n",
                      pairs.enough, pair_count_wanted, pairs.rare.size(), pairs.never.size());
  return text;
}

std::string failures_text(const SoakCounters& counters) {
  std::string text;
  for (const FailedWorld& failure : counters.failures) {
    text += fmt::format("  world {} (seed {})  {}  tick {}\n    {}\n", failure.index, failure.world_seed,
                        failure.variant, failure.tick, failure.what);
    if (failure.folder.empty()) continue;
    text += fmt::format("    shrunk to {} bodies, {} ticks in {} runs: {}/command\n", failure.body_count,
                        failure.tick_count, failure.test_count, failure.folder);
  }
  return text;
}

Json caches_json(const SoakCounters& counters) {
  Json list = Json::array();
  for (const engine::CacheInfo& info : engine::cache_kinds) {
    const auto i = static_cast<std::size_t>(info.kind);
    list.push_back({{"name", info.name},
                    {"hits", counters.caches[i].hits},
                    {"invalidations", counters.caches[i].invalidations},
                    {"compared_while_hit", counters.while_hit[i]}});
  }
  return list;
}

Json choices_json(const SoakOptions& options, const SoakCounters& counters) {
  Json list = Json::array();
  for (const std::string& name : options.worlds.choices) {
    const auto found = counters.choices.find(name);
    const ChoiceCoverage choice = found == counters.choices.end() ? ChoiceCoverage{} : found->second;
    list.push_back({{"row", name},
                    {"worlds", choice.active},
                    {"changes_bits", options.worlds.choice_changes_bits(name)},
                    {"run_without", choice.measured},
                    {"with_effect", choice.effect}});
  }
  return list;
}

Json failures_json(const SoakCounters& counters) {
  Json list = Json::array();
  for (const FailedWorld& failure : counters.failures)
    list.push_back({{"world", failure.index},
                    {"world_seed", std::to_string(failure.world_seed)},
                    {"variant", failure.variant},
                    {"tick", failure.tick},
                    {"what", failure.what},
                    {"folder", failure.folder},
                    {"bodies", failure.body_count},
                    {"ticks", failure.tick_count},
                    {"shrink_runs", failure.test_count}});
  return list;
}

}  // namespace

std::vector<std::string> never_hit(const SoakOptions& options, const SoakCounters& counters) {
  std::vector<std::string> names;
  if (options.hits_expected_after == 0 || counters.world_count < options.hits_expected_after) return names;
  for (const engine::CacheInfo& info : engine::cache_kinds)
    if (counters.while_hit[static_cast<std::size_t>(info.kind)] == 0) names.emplace_back(info.name);
  return names;
}

std::string soak_text(const SoakOptions& options, const SoakReport& report, const KnownComparison& known) {
  const SoakCounters& counters = report.counters;
  const std::vector<std::string> idle_caches = never_hit(options, counters);
  const bool is_clean = counters.failures.empty() && known.rose.empty() && idle_caches.empty();
  std::string verdict = fmt::format("{}  soak --seed {}  {} worlds, {} found\n", is_clean ? "match" : "FOUND",
                                    options.seed, counters.world_count, counters.failures.size()) +
                        failures_text(counters);
  for (const std::string& line : known.rose) verdict += "  physics, more than is known  " + line + "\n";
  for (const std::string& name : idle_caches) verdict += "  cached structure that was never hit: found " + name + "\n";
  std::string text = verdict;
  for (const std::string& line : known.fell) text += "  physics, less than is known  " + line + "\n";
  if (options.known_world_count > 0)
    text += fmt::format("  physics of the first {} worlds: {}\n", options.known_world_count,
                        counters.world_count >= options.known_world_count ? "compared with what is known"
                                                                          : "not compared, too few worlds were run") +
            fmt::format("  gaps and overlaps: {} worlds judged, {} not, of solvers or integrators that promise none\n",
                        counters.judged_count, counters.unjudged_count);
  for (const std::string& line : counters.physics_texts) text += "  physics  " + line + "\n";
  text += fmt::format("  ticks   {}, body-ticks {}\n", counters.tick_count, counters.body_ticks);
  text += fmt::format("  ended   {} worlds early: {} in which a body ran away, {} with joints that became non-finite\n",
                      counters.ran_away_count + counters.joints_failed_count, counters.ran_away_count,
                      counters.joints_failed_count);
  text += checks_text(counters) + caches_text(counters) + choices_text(options, counters);
  text += fmt::format("  time    {:.1f} s for {} worlds, {:.2f} worlds/s\n", report.seconds, report.new_worlds,
                      worlds_per_second(report));
  if (!is_clean) text += verdict;  // repeated, because many lines come between and a log may only show its end
  return text;
}

std::string soak_json(const SoakOptions& options, const SoakReport& report, const KnownComparison& known) {
  const SoakCounters& counters = report.counters;
  Json json;
  json["schema"] = "ticktrue.soak/1";
  json["seed"] = options.seed;
  json["worlds"] = counters.world_count;
  json["is_whole"] = report.is_whole;
  json["found"] = counters.failures.size();
  json["ticks"] = counters.tick_count;
  json["body_ticks"] = counters.body_ticks;
  json["ran_away"] = counters.ran_away_count;
  json["joints_failed"] = counters.joints_failed_count;
  json["checks"] = Json::object();
  for (const CheckInfo& info : check_table)
    json["checks"][std::string(info.name)] = counters.run_counts[static_cast<std::size_t>(info.kind)];
  json["caches"] = caches_json(counters);
  json["never_hit"] = never_hit(options, counters);
  json["rows"] = choices_json(options, counters);
  const PairCoverage pairs = pair_coverage(options, counters);
  json["pairs"] = {
      {"wanted", pair_count_wanted}, {"enough", pairs.enough}, {"rare", pairs.rare}, {"never", pairs.never}};
  json["physics_judged"] = counters.judged_count;
  json["physics_not_judged"] = counters.unjudged_count;
  json["physics"] = counters.physics_texts;
  json["physics_rose"] = known.rose;
  json["physics_fell"] = known.fell;
  json["failures"] = failures_json(counters);
  json["seconds"] = report.seconds;
  json["worlds_per_second"] = worlds_per_second(report);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ticktrue::soak
