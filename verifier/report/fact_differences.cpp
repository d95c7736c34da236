// Finds the facts in which two programs differ, in the order of how likely they change bits.
// SPDX-License-Identifier: MIT
#include "verifier/report/fact_differences.h"

#include <algorithm>
#include <array>

#include "verifier/report/build_id_note.h"

namespace ticktrue::verifier {
namespace {

constexpr std::string_view caller_prefix = "caller.";
constexpr std::string_view program_prefix = "program.";
constexpr std::string_view plugin_prefix = "plugin.";

constexpr std::size_t build_id_shown_max = 16;  // digits; JSON and `show` print all

/// Facts of TICKTRUE_CALLER_FACTS that change results of the same source, the most frequent cause first.
constexpr std::array<std::string_view, 5> facts_of_bits{"fused", "fast_math", "unsafe_math", "finite_math",
                                                        "flt_eval_method"};

bool begins_with(std::string_view text, std::string_view prefix) {
  return text.substr(0, prefix.size()) == prefix;
}

const std::string* find_fact(const replay::BuildFacts& facts, std::string_view name) {
  for (const auto& [found, value] : facts)
    if (found == name) return &value;
  return nullptr;
}

/// The unit in caller.UNIT.NAME; nothing for caller.NAME.
std::string_view unit_of(std::string_view name) {
  name.remove_prefix(caller_prefix.size());
  const std::size_t dot = name.rfind('.');
  return dot == std::string_view::npos ? std::string_view() : name.substr(0, dot);
}

bool has_unit(const replay::BuildFacts& facts, std::string_view unit) {
  return std::any_of(facts.begin(), facts.end(), [&](const auto& fact) {
    return begins_with(fact.first, caller_prefix) && unit_of(fact.first) == unit;
  });
}

/// Index in facts_of_bits; for another fact, the size of facts_of_bits.
std::size_t rank_of(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  const std::string_view last = dot == std::string_view::npos ? name : name.substr(dot + 1);
  return static_cast<std::size_t>(std::find(facts_of_bits.begin(), facts_of_bits.end(), last) - facts_of_bits.begin());
}

}  // namespace

bool is_program_fact(std::string_view name) {
  return begins_with(name, caller_prefix) || begins_with(name, program_prefix) || begins_with(name, plugin_prefix);
}

std::string fact_unit(std::string_view name) {
  return begins_with(name, caller_prefix) ? std::string(unit_of(name)) : "";
}

std::string program_line(const replay::BuildFacts& facts) {
  std::string text;
  const auto add = [&](std::string_view name, const char* label, std::size_t size_max = std::string::npos) {
    const std::string* value = find_fact(facts, name);
    if (value == nullptr || value->empty()) return;
    text += (text.empty() ? "" : ", ") + std::string(label) + value->substr(0, size_max);
  };
  add("plugin.path", "plug-in ");
  add("plugin.build", "build ");
  add("caller.compiler", "");
  add("caller.language", "");
  add("caller.flags", "flags ");
  add("caller.optimize", "optimize ");
  add("caller.target", "");
  add(build_id_fact, "build id ", build_id_shown_max);
  return text;
}

std::vector<FactDifference> fact_differences(const replay::BuildFacts& a, const replay::BuildFacts& b) {
  constexpr const char* not_known = "not known";
  std::vector<FactDifference> found;
  const auto tells = [](const replay::BuildFacts& facts) {
    return std::any_of(facts.begin(), facts.end(), [](const auto& f) { return begins_with(f.first, caller_prefix); });
  };
  if (!tells(a) || !tells(b)) return found;
  const auto add = [&](std::string_view name, const std::string& value_a, const std::string& value_b) {
    name.remove_prefix(caller_prefix.size());
    const bool is_known = value_a != not_known && value_b != not_known;
    found.push_back({std::string(name), value_a, value_b, is_known && rank_of(name) < facts_of_bits.size()});
  };
  // A unit that only one side names is one difference, not one for each of its facts.
  const auto add_unit = [&](std::string_view name, bool is_of_a) {
    const std::string unit(unit_of(name));
    const auto same = [&](const FactDifference& difference) { return difference.name == unit; };
    if (std::none_of(found.begin(), found.end(), same))
      found.push_back({unit, is_of_a ? "with facts" : not_known, is_of_a ? not_known : "with facts", false});
  };
  for (const auto& [name, value] : a) {
    if (!begins_with(name, caller_prefix)) continue;
    const std::string* other = find_fact(b, name);
    if (other != nullptr && *other == value) continue;
    if (other == nullptr && !has_unit(b, unit_of(name)))
      add_unit(name, true);
    else
      add(name, value, other != nullptr ? *other : not_known);
  }
  for (const auto& [name, value] : b) {
    if (!begins_with(name, caller_prefix) || find_fact(a, name) != nullptr) continue;
    if (!has_unit(a, unit_of(name)))
      add_unit(name, false);
    else
      add(name, not_known, value);
  }
  std::stable_sort(found.begin(), found.end(), [](const FactDifference& one, const FactDifference& two) {
    const std::size_t rank_one = one.changes_bits ? rank_of(one.name) : facts_of_bits.size();
    const std::size_t rank_two = two.changes_bits ? rank_of(two.name) : facts_of_bits.size();
    return rank_one < rank_two;
  });
  return found;
}

std::string difference_line(const FactDifference& difference, const std::string& a_name, const std::string& b_name) {
  return difference.name + ": " + a_name + " " + difference.a + ", " + b_name + " " + difference.b +
         (difference.changes_bits ? " (changes bits)" : "");
}

}  // namespace ticktrue::verifier
