// Records, verifies and compares traces, and probes the arithmetic: the parts of the tool that ./dev platforms needs.
// SPDX-License-Identifier: MIT
//
// The program uses the engine, the verifier and the probe of the tool, but not the command line. It therefore builds in
// a fraction of the time (`./dev platforms --full` uses the tool instead).
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/build_info.h"
#include "base/hash.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "engine/random_worlds/world_hashes.h"
#include "engine/scene/scene_json.h"
#include "replay/recorder.h"
#include "replay/trace_reader.h"
#include "tool/environment/arithmetic_probe.h"
#include "tool/environment/float_environment.h"
#include "tool/output/progress.h"
#include "tool/session/input_source.h"
#include "tool/session/session.h"
#include "verifier/compare/diff.h"
#include "verifier/report/exit_codes.h"
#include "verifier/verify/verify.h"

namespace ticktrue {
namespace {

using Words = std::vector<std::string>;

int complain(const Error& error) {
  std::fprintf(stderr, "platform_check: error: %s\n", error.message.c_str());
  return verifier::exit_usage;
}

Result<std::string> read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return Error{ErrorCode::io, path + ": cannot read", ""};
  return std::string{std::istreambuf_iterator<char>(in), {}};
}

Result<engine::Scene> load_scene(const std::string& name) {
  if (name.find(".json") == std::string::npos) return engine::make_builtin_scene(name);
  const Result<std::string> text = read_text(name);
  if (!text) return text.error();
  return engine::parse_scene(*text, name);
}

/// Equals `ticktrue record --detail full:90..110 --checkpoint-interval 30 --no-compress --force --json`.
int record(const Words& words) {
  const std::string& inputs = words[1];
  const std::string& output = words[3];
  const Result<engine::Scene> scene = load_scene(words[0]);
  if (!scene) return complain(scene.error());
  const auto made = engine::make_engine(*scene);
  if (!made) return complain(made.error());
  std::unique_ptr<replay::InputSource> source = std::make_unique<replay::NoInputs>(scene->settings.dt);
  if (inputs != "-") {
    if (const auto summary = tool::check_inputs(*scene, inputs, {}); !summary) return complain(summary.error());
    auto lines = tool::JsonLinesInputs::open(*scene, inputs, {});
    if (!lines) return complain(lines.error());
    source = std::move(*lines);
  }
  replay::RecordOptions options;
  options.tick_count = std::strtoull(words[2].c_str(), nullptr, 10);
  options.writer.overwrite = true;
  options.writer.compress = false;
  const replay::TraceSetup setup = tool::make_trace_setup(**made, {replay::Detail::full, 90, 110, 30});
  const auto result = replay::record(**made, *source, output, setup, tool::make_build_facts(), options);
  if (!result) return complain(result.error());
  std::printf("{\n  \"ticks\": %llu,\n  \"note\": \"%s\",\n  \"hash\": \"%s\"\n}\n",
              static_cast<unsigned long long>(result->tick_count), result->note.c_str(),
              hex64(result->root_hash).c_str());
  return result->reason == replay::EndReason::non_finite ? verifier::exit_finding : verifier::exit_ok;
}

int verify(const Words& words) {
  auto reader = replay::TraceReader::open(words[0]);
  if (!reader) return complain(reader.error());
  verifier::VerifyOptions options;
  options.simulation = &engine::engine_info();
  verifier::Report report = verifier::verify(*reader, options);
  report.file = words[0];
  std::fputs(verifier::report_text(report).c_str(), stdout);
  return report.exit_code();
}

int diff(const Words& words) {
  auto a = replay::TraceReader::open(words[0]);
  if (!a) return complain(a.error());
  auto b = replay::TraceReader::open(words[1]);
  if (!b) return complain(b.error());
  verifier::DiffOptions options;
  options.simulation = &engine::engine_info();
  verifier::DiffReport report = verifier::diff(*a, *b, options);
  report.a.file = words[0];
  report.b.file = words[1];
  std::fputs(verifier::diff_text(report).c_str(), stdout);
  return report.exit_code();
}

/// Equals `ticktrue env --check --json`, for the fields that ./dev platforms reads.
int env(const Words&) {
  const BuildInfo& build = build_info();
  const tool::FloatEnvironment floats = tool::probe_float_environment();
  std::printf("{\n  \"compiler\": \"%s\",\n  \"target\": \"%s\",\n  \"probe\": [\n", build.compiler.c_str(),
              build.target.c_str());
  bool right = tool::follows_rules(floats);
  const char* comma = "";
  for (const tool::ProbePart& part : tool::probe_arithmetic()) {
    std::printf("%s    {\n      \"part\": \"%s\",\n      \"digest\": \"%s\",\n      \"digest_expected\": \"%s\"\n    }",
                comma, std::string(part.name).c_str(), hex64(part.digest).c_str(), hex64(part.expected).c_str());
    comma = ",\n";
    right = right && part.is_right();
  }
  std::printf("\n  ]\n}\n");
  return right ? verifier::exit_ok : verifier::exit_finding;
}

/// Root hashes of random worlds, in the format of tests/worlds/hashes.tsv.
int worlds(const Words& words) {
  const Result<std::string> text = read_text(words[0]);
  if (!text) return complain(text.error());
  const auto expected = engine::parse_world_hashes(*text, words[0]);
  if (!expected) return complain(expected.error());
  std::uint64_t ticks = 0;
  int differing = 0;
  for (const engine::WorldHash& world : *expected) {
    const engine::WorldHash found = engine::hash_world(world.seed);
    ticks += found.tick_count;
    if (found == world) continue;
    ++differing;
    complain({ErrorCode::inconsistent,
              "world " + std::to_string(world.seed) + ": found hash " + hex64(found.hash) + " after " +
                  std::to_string(found.tick_count) + " ticks, expected " + hex64(world.hash) + " after " +
                  std::to_string(world.tick_count),
              ""});
  }
  std::printf("%zu worlds, %llu ticks, %d differ\n", expected->size(), static_cast<unsigned long long>(ticks),
              differing);
  return differing == 0 ? verifier::exit_ok : verifier::exit_finding;
}

/// Runs long enough for a terminal to show the progress bar.
int bar(const Words&) {
  cli::Progress progress("bar", 2);
  progress.update(1);
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  progress.update(2);
  return verifier::exit_ok;
}

struct Command {
  std::string_view name;
  std::size_t word_count;
  const char* words;
  int (*run)(const Words& words);
};
constexpr Command commands[] = {
    {"record", 4, "SCENE INPUTS|- TICKS TRACE", record},
    {"verify", 1, "TRACE", verify},
    {"diff", 2, "TRACE TRACE", diff},
    {"env", 0, "", env},
    {"worlds", 1, "HASHES.TSV", worlds},
    {"bar", 0, "", bar},
};

int run(const Words& words) {
  for (const Command& command : commands)
    if (!words.empty() && words[0] == command.name && words.size() == command.word_count + 1)
      return command.run({words.begin() + 1, words.end()});
  for (const Command& command : commands)
    std::fprintf(stderr, "usage: platform_check %s %s\n", std::string(command.name).c_str(), command.words);
  return verifier::exit_usage;
}

}  // namespace
}  // namespace ticktrue

int main(int argc, char* argv[]) {
  try {
    return ticktrue::run({argv + 1, argv + argc});
  } catch (const std::exception& failure) {
    return ticktrue::complain({ticktrue::ErrorCode::limit, failure.what(), ""});
  }
}
