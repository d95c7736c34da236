// Counts choices, and worlds that differ without them.
// SPDX-License-Identifier: MIT
#include "tool/experiment/soak/choice_effects.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace ticktrue::soak {
namespace {

constexpr std::size_t measured_per_world = 10;

/// Tables with a row for each body or one row for the world. Their presence shows no effect.
constexpr std::array<std::string_view, 5> tables_of_all{"world", "sleep", "substeps", "accelerations", "integrator"};

bool only_base_has_rows(const BaseRun& base, const StateSchema& other) {
  return std::any_of(base.tables_with_rows.begin(), base.tables_with_rows.end(), [&](const std::string& table) {
    const bool is_of_all = std::find(tables_of_all.begin(), tables_of_all.end(), table) != tables_of_all.end();
    return !is_of_all && !other.find_table(table);
  });
}

}  // namespace

std::vector<std::string> choices_to_measure(const WorldSource& source,
                                            const std::map<std::string, ChoiceCoverage>& choices) {
  const auto effect_of = [&](const std::string& choice) {
    const auto found = choices.find(choice);
    return found == choices.end() ? 0 : found->second.effect;
  };
  std::vector<std::string> wanted;
  for (const std::string& choice : source.choices)
    if (effect_of(choice) < effect_count_wanted && source.choice_changes_bits(choice)) wanted.push_back(choice);
  std::stable_sort(wanted.begin(), wanted.end(),
                   [&](const std::string& a, const std::string& b) { return effect_of(a) < effect_of(b); });
  return wanted;
}

void count_choices(const WorldSource& source, const WorldSource::World& world, std::uint64_t world_seed,
                   const BaseRun& base, const std::vector<std::string>& wanted, const EngineMaker& make,
                   SoakCounters& counts) {
  const auto& choices = world.choices;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    counts.choices[choices[i]].active = 1;
    for (std::size_t k = i + 1; k < choices.size(); ++k) ++counts.pairs[std::minmax(choices[i], choices[k])];
  }
  if (base.tick_count == 0) return;
  std::size_t measured = 0;
  for (const std::string& choice : wanted) {
    if (measured == measured_per_world) return;
    if (std::find(choices.begin(), choices.end(), choice) == choices.end()) continue;
    const auto without = source.without(world_seed, choice);
    if (!without) continue;
    ++measured;
    counts.choices[choice].measured = 1;
    counts.choices[choice].effect = has_effect(base, *without, make) ? 1 : 0;
  }
}

bool has_effect(const BaseRun& base, const SoakCase& without, const EngineMaker& make) {
  const auto made = make(without.scene, {});
  if (!made) return false;
  engine::Engine& engine = **made;
  const StateSchema& schema = *engine.state().schema;
  const bool is_same_schema = schema == base.schema;
  if (!is_same_schema && only_base_has_rows(base, schema)) return true;
  const CaseInputs inputs(without);
  const std::uint64_t tick_count = std::min(base.tick_count, without.tick_count);
  std::uint64_t work = 0;
  for (std::uint64_t tick = 0; tick < tick_count && work <= 2 * base.work; ++tick) {
    if (step_tick(engine, inputs.at(tick), tick, {})) return true;
    if (hash_of_bodies(engine.state()) != base.body_hashes[tick]) return true;
    if (is_same_schema && root_hash(engine.state()) != base.hashes[tick]) return true;
    work += work_of_tick(without.scene, engine.state());
  }
  return false;
}

}  // namespace ticktrue::soak
