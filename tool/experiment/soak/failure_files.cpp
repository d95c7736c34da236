// Writes a shrunk world, and reads a written world.
// SPDX-License-Identifier: MIT
#include "tool/experiment/soak/failure_files.h"

#include <chrono>
#include <filesystem>
#include <system_error>

#include "engine/scene/scene_json.h"
#include "tool/experiment/shrink.h"
#include "tool/session/input_source.h"
#include "verifier/report/report.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::soak {
namespace {

std::string inputs_text(const SoakCase& soak_case) {
  std::string text;
  for (const engine::Input& input : soak_case.inputs)
    if (input.kind != engine::InputKind::end) text += print_input(soak_case.scene, input) + "\n";
  return text;
}

Status write_case(const SoakCase& soak_case, const std::string& folder, const Variant& variant) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) return Error{ErrorCode::io, folder + ": cannot be made: " + failed.message(), ""};
  if (const Status written = verifier::write_data_file(folder + "/scene.json", print_scene(soak_case.scene)); !written)
    return written;
  if (const Status written = verifier::write_data_file(folder + "/inputs.jsonl", inputs_text(soak_case)); !written)
    return written;
  return verifier::write_data_file(
      folder + "/command", "ticktrue soak " + verifier::shell_word(folder + "/scene.json") + " --inputs " +
                               verifier::shell_word(folder + "/inputs.jsonl") + " --ticks " +
                               std::to_string(soak_case.tick_count) + " --checks " + variant_text(variant) + "\n");
}

SoakCase shrink_case(const SoakCase& soak_case, const Finding& finding, const FailureOptions& options,
                     std::size_t& test_count) {
  const auto still_fails = [&](const SoakCase& candidate) {
    const auto found = examine_variant(candidate, finding.variant, options.oracle);
    return found && found->is_refused == finding.is_refused;
  };
  if (options.shrink_time_s <= 0 || !still_fails(soak_case)) return soak_case;
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  ShrinkOptions shrink_options;
  shrink_options.first_wrong_tick = finding.tick;
  shrink_options.is_over = [&] {
    return std::chrono::duration<double>(Clock::now() - start).count() > options.shrink_time_s;
  };
  ShrinkResult result = shrink(soak_case, still_fails, shrink_options);
  test_count = result.test_count;
  return std::move(result.smallest);
}

}  // namespace

FailedWorld write_failure(const SoakCase& soak_case, std::uint64_t world_seed, const Finding& finding,
                          const FailureOptions& options) {
  FailedWorld failure;
  failure.world_seed = world_seed;
  failure.variant = variant_text(finding.variant);
  failure.tick = finding.tick;
  failure.what = finding.what;
  std::size_t test_count = 0;
  const SoakCase smallest = shrink_case(soak_case, finding, options, test_count);
  failure.test_count = test_count;
  failure.body_count = smallest.scene.bodies.size();
  failure.tick_count = smallest.tick_count;
  failure.folder = options.folder;
  if (const Status written = write_case(smallest, failure.folder, finding.variant); !written) {
    failure.folder.clear();
    failure.what += " (not written: " + written.error().message + ")";
  }
  return failure;
}

Result<SoakCase> read_case(const engine::Scene& scene, const std::string& inputs_path, std::uint64_t tick_count) {
  SoakCase soak_case{scene, {}, tick_count};
  if (inputs_path.empty()) return soak_case;
  Result<tool::LineReader> lines = tool::LineReader::open(inputs_path);
  if (!lines) return lines.error();
  std::uint32_t sequence = 0;
  for (;;) {
    const auto line = lines->next({});
    if (!line) return line.error();
    if (!*line) return soak_case;
    if ((*line)->find_first_not_of(" \t\r") == std::string_view::npos) continue;
    Result<engine::Input> input = engine::parse_input(scene, **line, lines->place());
    if (!input) return input.error();
    input->sequence = sequence++;
    soak_case.inputs.push_back(*input);
  }
}

}  // namespace ticktrue::soak
