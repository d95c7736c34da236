// `ticktrue env`: what this build and this machine compute with, and whether it is what every platform must give.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>

#include "base/build_info.h"
#include "base/hash.h"
#include "base/hash128.h"
#include "engine/engine.h"
#include "replay/format/trace.h"
#include "tool/cli/commands.h"
#include "tool/corpus/engine_digest.h"
#include "tool/environment/arithmetic_probe.h"
#include "tool/environment/float_environment.h"
#include "tool/output/json_output.h"
#include "verifier/report/machine.h"

namespace ticktrue::cli {
namespace {

struct EnvOptions {
  bool json = false;
  bool check = false;
};

std::string features_text(const BuildInfo& build) {
  return fmt::format("zstd {}, Box2D {}, threads {}", build.has_zstd ? "yes" : "no", build.has_box2d ? "yes" : "no",
                     build.has_threads ? "yes" : "no");
}

Json env_json(const tool::FloatEnvironment& floats, const std::vector<tool::ProbePart>& parts) {
  const BuildInfo& build = build_info();
  const verifier::MachineFacts machine = verifier::machine_facts();
  Json object;
  object["schema"] = "ticktrue.env/1";
  object["version"] = build.version;
  object["commit"] = build.commit;
  object["compiler"] = build.compiler;
  object["flags"] = build.flags;
  object["target"] = build.target;
  object["zstd"] = build.has_zstd;
  object["box2d"] = build.has_box2d;
  object["threads"] = build.has_threads;
  object["trace_format"] = replay::format_version;
  object["physics_version"] = engine::physics_version;
  const std::optional<Hash128> digest = tool::engine_digest();
  object["engine_digest"] = digest ? Json(hex128(*digest)) : Json(nullptr);
  object["cpu"] = machine.cpu;
  object["instruction_set"] = machine.instruction_set;
  object["kernels"] = engine::info_of(engine::instruction_sets, engine::instruction_set_in_use()).name;
  object["control_word"] = machine.control_word;
  const FloatBehaviour& behaviour = floats.behaviour;
  object["floats"] = {{"rounding", behaviour.rounding},
                      {"flushes_to_zero", behaviour.flushes_to_zero},
                      {"subnormals_are_zero", behaviour.subnormals_are_zero},
                      {"contracts", behaviour.contracts},
                      {"evaluation_method", floats.evaluation_method},
                      {"digest", hex64(floats.digest)},
                      {"digest_expected", hex64(tool::float_digest_expected)},
                      {"right", tool::follows_rules(floats)}};
  if (!parts.empty()) object["probe"] = Json::array();
  for (const tool::ProbePart& part : parts)
    object["probe"].push_back({{"part", part.name},
                               {"what", part.what},
                               {"digest", hex64(part.digest)},
                               {"digest_expected", hex64(part.expected)},
                               {"right", part.is_right()}});
  return object;
}

std::string env_text(const tool::FloatEnvironment& floats, const std::vector<tool::ProbePart>& parts) {
  const BuildInfo& build = build_info();
  const verifier::MachineFacts machine = verifier::machine_facts();
  std::string text = build_line() + "\n";
  text +=
      fmt::format("  compiler    {}\n  flags       {}\n  target      {}\n", build.compiler, build.flags, build.target);
  text += fmt::format("  machine     {}{}computes with {}\n", machine.cpu, machine.cpu.empty() ? "" : ", ",
                      machine.instruction_set);
  text += fmt::format("  kernels     {}\n",
                      engine::info_of(engine::instruction_sets, engine::instruction_set_in_use()).name);
  text += fmt::format("  parts       {}\n", features_text(build));
  text += fmt::format("  versions    trace formats {} to {}, physics {}\n", replay::format_version_first,
                      replay::format_version, engine::physics_version);
  const FloatBehaviour& behaviour = floats.behaviour;
  text += fmt::format(
      "  floats      rounding {}, subnormal results {}, subnormal operands {}, a*b+c {}, "
      "evaluation method {}{}{}\n",
      behaviour.rounding, behaviour.flushes_to_zero ? "flushed" : "kept",
      behaviour.subnormals_are_zero ? "zero" : "kept", behaviour.contracts ? "contracted" : "rounded twice",
      floats.evaluation_method, machine.control_word.empty() ? "" : ", ", machine.control_word);
  text += fmt::format("  digest      {} ({})\n", hex64(floats.digest), tool::follows_rules(floats) ? "right" : "wrong");
  for (const tool::ProbePart& part : parts)
    text += fmt::format("  probe       {} {:<14} {}{}\n", hex64(part.digest), part.name, part.what,
                        part.is_right() ? "" : ": WRONG, expected " + hex64(part.expected));
  return text;
}

int run_env(const EnvOptions& options) {
  const tool::FloatEnvironment floats = tool::probe_float_environment();
  std::vector<tool::ProbePart> parts;
  if (options.check) parts = tool::probe_arithmetic();
  if (options.json)
    print_json(env_json(floats, parts));
  else
    print(env_text(floats, parts));

  constexpr const char* hint = "traces of other machines will not verify here";
  if (!tool::follows_rules(floats)) {
    print_error(Error{ErrorCode::unsupported,
                      "floating point: found arithmetic with digest " + hex64(floats.digest) + ", expected " +
                          hex64(tool::float_digest_expected),
                      hint});
    return exit_finding;
  }
  const auto wrong = std::find_if(parts.begin(), parts.end(), [](const auto& part) { return !part.is_right(); });
  if (wrong == parts.end()) return exit_ok;
  print_error(Error{ErrorCode::unsupported,
                    "probe: " + std::string(wrong->name) + ": found digest " + hex64(wrong->digest) + ", expected " +
                        hex64(wrong->expected),
                    hint});
  return exit_finding;
}

}  // namespace

void add_env(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<EnvOptions>();
  CLI::App* command =
      app.add_subcommand("env", "Say what this build and this machine compute with")->group(group_upkeep);
  command->add_flag(
      "--check", options->check,
      "Compare the engine's own arithmetic, part by part, with what every platform must give; exit 1 where it "
      "differs");
  command->add_flag("--json", options->json, "One JSON object");
  set_examples(*command, "ticktrue env\nticktrue env --check --json");
  command->callback([options, &context] { context.exit_code = run_env(*options); });
}

}  // namespace ticktrue::cli
