// The list of simulations.
// SPDX-License-Identifier: MIT
#include "tool/session/simulations.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/engine.h"
#include "engine/scene/scene_binary.h"
#include "tool/session/session.h"
#include "verifier/plugins/plugin.h"
#include "verifier/report/report.h"

namespace ticktrue::tool {
namespace {

Result<std::unique_ptr<Simulation>> make_checked(ByteView setup, unsigned thread_count) {
  const Result<engine::Scene> scene = engine::decode_scene(setup);
  if (!scene) return scene.error();
  engine::EngineOptions options = engine_options_of_environment();
  options.thread_count = thread_count;
  Result<std::unique_ptr<engine::Engine>> made = engine::make_engine(*scene, options);
  if (!made) return made.error();
  return std::unique_ptr<Simulation>(*std::move(made));
}

/// The engine of this build, with the options from the environment.
const SimulationInfo& engine_here() {
  static const SimulationInfo info = [] {
    SimulationInfo checked = engine::engine_info();
    if (!engine_options_of_environment().check_caches) return checked;
    checked.make = [](ByteView setup) { return make_checked(setup, 1); };
    checked.make_on_threads = make_checked;
    return checked;
  }();
  return info;
}

}  // namespace

engine::EngineOptions engine_options_of_environment() {
  static const bool checks = [] {
    const char* value = std::getenv(check_caches_variable);
    return value != nullptr && std::string_view(value) == "1";
  }();
  engine::EngineOptions options;
  options.check_caches = checks;
  return options;
}

std::vector<const SimulationInfo*> simulations() {
  std::vector<const SimulationInfo*> list{&engine_here()};
  for (const SimulationInfo* info : verifier::plugin_simulations()) list.push_back(info);
  return list;
}

const SimulationInfo* find_simulation(std::string_view name) {
  for (const SimulationInfo* info : simulations())
    if (info->name == name) return info;
  return nullptr;
}

bool runs_on_threads(const SimulationInfo& info) {
  return &info == &engine_here() || &info == &engine::engine_info();
}

replay::BuildFacts make_build_facts(std::string_view simulation) {
  replay::BuildFacts facts = make_build_facts();
  for (auto& fact : verifier::plugin_facts(simulation)) facts.push_back(std::move(fact));
  return facts;
}

std::string tool_command(std::string_view simulation) {
  const std::string library = verifier::plugin_path(simulation);
  return library.empty() ? "ticktrue" : "ticktrue --plugin " + verifier::shell_word(library);
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

std::string other_simulation_hint(const std::string& file, const replay::BuildFacts& facts) {
  const auto has = [&](std::string_view prefix) {
    return std::any_of(facts.begin(), facts.end(),
                       [&](const auto& fact) { return fact.first.substr(0, prefix.size()) == prefix; });
  };
  const std::string verify = "verify " + verifier::shell_word(file);
  const std::string by_program = "ticktrue " + verify + " --command './PROGRAM --verify {}'";
  const std::string by_plugin = "ticktrue --plugin LIB.so " + verify;
  if (has("plugin.")) return "a plug-in recorded it: " + by_plugin;
  if (has("program.") || has("caller.")) return "the program that recorded it verifies it: " + by_program;
  return "this build has " + simulation_names() + ". Of a plug-in: " + by_plugin +
         ". Of a program that owns its loop: " + by_program;
}

}  // namespace ticktrue::tool
