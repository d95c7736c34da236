// `ticktrue env`: what this build and this machine compute with.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/build_info.h"
#include "base/hash.h"
#include "engine/engine.h"
#include "replay/trace.h"
#include "verifier/cli/commands.h"
#include "verifier/cli/json_output.h"
#include "verifier/float_environment.h"

namespace ticktrue::cli {
namespace {

struct EnvOptions {
  bool json = false;
};

int run_env(const EnvOptions& options) {
  const BuildInfo& build = build_info();
  const verifier::FloatEnvironment floats = verifier::probe_float_environment();
  const bool is_right = verifier::follows_rules(floats);
  if (options.json) {
    Json object;
    object["schema"] = "ticktrue.env/1";
    object["version"] = build.version;
    object["commit"] = build.commit;
    object["compiler"] = build.compiler;
    object["flags"] = build.flags;
    object["target"] = build.target;
    object["zstd"] = build.has_zstd;
    object["box2d"] = build.has_box2d;
    object["trace_format"] = replay::format_version;
    object["physics_version"] = engine::physics_version;
    object["floats"] = {{"rounding", floats.rounding},
                        {"flushes_to_zero", floats.flushes_to_zero},
                        {"subnormals_are_zero", floats.subnormals_are_zero},
                        {"contracts", floats.contracts},
                        {"evaluation_method", floats.evaluation_method},
                        {"digest", hex64(floats.digest)},
                        {"digest_expected", hex64(verifier::float_digest_expected)},
                        {"right", is_right}};
    print_json(object);
  } else {
    print(build_line() + "\n");
    print(fmt::format("  compiler    {}\n  flags       {}\n  target      {}\n", build.compiler, build.flags,
                      build.target));
    print(fmt::format("  libraries   zstd {}, Box2D {}\n", build.has_zstd ? "yes" : "no",
                      build.has_box2d ? "yes" : "no"));
    print(fmt::format("  versions    trace format {}, physics {}\n", replay::format_version, engine::physics_version));
    print(fmt::format(
        "  floats      rounding {}, subnormal results {}, subnormal operands {}, a*b+c {}, "
        "evaluation method {}\n",
        floats.rounding, floats.flushes_to_zero ? "flushed" : "kept", floats.subnormals_are_zero ? "zero" : "kept",
        floats.contracts ? "contracted" : "rounded twice", floats.evaluation_method));
    print(fmt::format("  digest      {} ({})\n", hex64(floats.digest), is_right ? "right" : "wrong"));
  }
  if (!is_right)
    print_error(Error{ErrorCode::unsupported,
                      "floating point: found arithmetic with digest " + hex64(floats.digest) + ", expected " +
                          hex64(verifier::float_digest_expected),
                      "traces of other machines will not verify here"});
  return is_right ? exit_ok : exit_finding;
}

}  // namespace

void add_env(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<EnvOptions>();
  CLI::App* command =
      app.add_subcommand("env", "Say what this build and this machine compute with")->group(group_upkeep);
  command->add_flag("--json", options->json, "One JSON object");
  set_examples(*command, "ticktrue env");
  command->callback([options, &context] { context.exit_code = run_env(*options); });
}

}  // namespace ticktrue::cli
