// The list of simulations.
// SPDX-License-Identifier: MIT
#include "verifier/simulations.h"

#include <vector>

#include "engine/engine.h"
#include "verifier/plugin.h"
#include "verifier/report.h"

namespace ticktrue::verifier {

std::vector<const SimulationInfo*> simulations() {
  std::vector<const SimulationInfo*> list{&engine::engine_info()};
  for (const SimulationInfo* info : plugin_simulations()) list.push_back(info);
  return list;
}

const SimulationInfo* find_simulation(std::string_view name) {
  for (const SimulationInfo* info : simulations())
    if (info->name == name) return info;
  return nullptr;
}

bool runs_on_threads(const SimulationInfo& info) {
  return &info == &engine::engine_info();
}

std::string tool_words(std::string_view simulation) {
  const std::string library = plugin_path(simulation);
  return library.empty() ? "ticktrue" : "ticktrue --plugin " + shell_word(library);
}

std::string simulation_names() {
  const auto list = simulations();
  std::string text;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (i > 0) text += i + 1 == list.size() ? " or " : ", ";
    text += list[i]->name;
  }
  return text;
}

}  // namespace ticktrue::verifier
