// Counters as JSON.
// SPDX-License-Identifier: MIT
#include "tool/experiment/soak/counters.h"

#include <nlohmann/json.hpp>

namespace ticktrue::soak {
namespace {

using Json = nlohmann::ordered_json;
using PairCounts = std::map<std::pair<std::string, std::string>, std::uint64_t>;

Json pairs_json(const PairCounts& counts) {
  Json list = Json::array();
  for (const auto& [names, count] : counts) list.push_back({names.first, names.second, count});
  return list;
}

PairCounts parse_pairs(const Json& list) {
  PairCounts counts;
  for (const Json& entry : list)
    counts[{entry.at(0).get<std::string>(), entry.at(1).get<std::string>()}] = entry.at(2).get<std::uint64_t>();
  return counts;
}

Json failure_json(const FailedWorld& failure) {
  return {{"world", failure.index},       {"world_seed", failure.world_seed},
          {"variant", failure.variant},   {"tick", failure.tick},
          {"what", failure.what},         {"folder", failure.folder},
          {"bodies", failure.body_count}, {"ticks", failure.tick_count},
          {"tests", failure.test_count}};
}

FailedWorld parse_failure(const Json& json) {
  FailedWorld failure;
  json.at("world").get_to(failure.index);
  json.at("world_seed").get_to(failure.world_seed);
  json.at("variant").get_to(failure.variant);
  json.at("tick").get_to(failure.tick);
  json.at("what").get_to(failure.what);
  json.at("folder").get_to(failure.folder);
  json.at("bodies").get_to(failure.body_count);
  json.at("ticks").get_to(failure.tick_count);
  json.at("tests").get_to(failure.test_count);
  return failure;
}

SoakCounters parse_counters(const Json& json) {
  SoakCounters counters;
  json.at("worlds").get_to(counters.world_count);
  json.at("ticks").get_to(counters.tick_count);
  json.at("body_ticks").get_to(counters.body_ticks);
  json.at("physics_judged").get_to(counters.judged_count);
  json.at("physics_not_judged").get_to(counters.unjudged_count);
  json.at("physics").get_to(counters.physics_texts);
  json.at("ran_away").get_to(counters.ran_away_count);
  json.at("joints_failed").get_to(counters.joints_failed_count);
  json.at("runs").get_to(counters.run_counts);
  json.at("while_hit").get_to(counters.while_hit);
  for (std::size_t i = 0; i < counters.caches.size(); ++i) {
    json.at("hits").at(i).get_to(counters.caches[i].hits);
    json.at("invalidations").at(i).get_to(counters.caches[i].invalidations);
  }
  for (const auto& [name, row] : json.at("rows").items())
    counters.choices[name] = {row.at(0).get<std::uint64_t>(), row.at(1).get<std::uint64_t>(),
                              row.at(2).get<std::uint64_t>()};
  counters.pairs = parse_pairs(json.at("pairs"));
  counters.known = parse_pairs(json.at("known"));
  for (const Json& failure : json.at("failures")) counters.failures.push_back(parse_failure(failure));
  return counters;
}

}  // namespace

std::string print_progress(const SoakIdentity& identity, const SoakCounters& counters) {
  Json json;
  json["schema"] = "ticktrue.soak_progress/1";
  json["seed"] = identity.seed;
  json["checks"] = identity.checks;
  json["commit"] = identity.commit;
  json["worlds"] = counters.world_count;
  json["ticks"] = counters.tick_count;
  json["body_ticks"] = counters.body_ticks;
  json["physics_judged"] = counters.judged_count;
  json["physics_not_judged"] = counters.unjudged_count;
  json["physics"] = counters.physics_texts;
  json["ran_away"] = counters.ran_away_count;
  json["joints_failed"] = counters.joints_failed_count;
  json["runs"] = counters.run_counts;
  json["while_hit"] = counters.while_hit;
  json["hits"] = Json::array();
  json["invalidations"] = Json::array();
  for (const engine::CacheCounts& counts : counters.caches) {
    json["hits"].push_back(counts.hits);
    json["invalidations"].push_back(counts.invalidations);
  }
  json["rows"] = Json::object();
  for (const auto& [name, row] : counters.choices) json["rows"][name] = {row.active, row.measured, row.effect};
  json["pairs"] = pairs_json(counters.pairs);
  json["known"] = pairs_json(counters.known);
  json["failures"] = Json::array();
  for (const FailedWorld& failure : counters.failures) json["failures"].push_back(failure_json(failure));
  return json.dump() + "\n";
}

Result<SoakCounters> parse_progress(const std::string& text, const SoakIdentity& identity, const std::string& place) {
  const Json json = Json::parse(text, nullptr, false);
  const Error broken{ErrorCode::corrupt, place + ": found something else than the progress of a soak",
                     "remove the file, or soak without --resume"};
  if (json.is_discarded() || !json.is_object()) return broken;
  try {
    const auto differs = [&](const std::string& what, const std::string& found, const std::string& expected) {
      return Error{ErrorCode::incompatible, place + ": " + what + ": found " + found + ", expected " + expected,
                   "it is the progress of another soak: give another --out, or soak without --resume"};
    };
    const auto seed = json.at("seed").get<std::uint64_t>();
    const auto checks = json.at("checks").get<std::string>();
    const auto commit = json.at("commit").get<std::string>();
    if (seed != identity.seed) return differs("seed", std::to_string(seed), std::to_string(identity.seed));
    if (checks != identity.checks) return differs("checks", checks, identity.checks);
    if (commit != identity.commit) return differs("commit of the build", commit, identity.commit);
    return parse_counters(json);
  } catch (const Json::exception&) {
    return broken;
  }
}

}  // namespace ticktrue::soak
