// Runs a program that answers as peer.mjs does, and reads its answer.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/answer_program.h"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>

#include "engine/json/json_tree.h"
#include "verifier/runs/child.h"

namespace ticktrue::tool {
namespace {

constexpr double body_size_estimate = 90;  // bytes of a body in the answer of a tick

// What a program wrote last to its standard error: its first line, for people.
std::string first_message_line(const std::string& text) {
  return engine::shortened(std::string_view(text).substr(0, text.find('\n')));
}

// Errors: limit.
Status check_answer_size(const std::string& name, const engine::Scene& scene, const Box2d3Options& options,
                         const Box2d3Plan& plan) {
  const double report_count = static_cast<double>(plan.tick_count) / static_cast<double>(plan.body_interval) + 1;
  const double size = report_count * body_size_estimate * static_cast<double>(scene.bodies.size());
  if (size <= static_cast<double>(options.answer_size_max)) return {};
  return Error{ErrorCode::limit,
               fmt::format("{}: the answer would be too large: found {} bodies for {} ticks ({:.0f} MiB), "
                           "expected at most {} MiB",
                           name, scene.bodies.size(), plan.tick_count, size / 0x1p20, options.answer_size_max >> 20),
               "fewer seconds"};
}

}  // namespace

Result<Box2d3Answer> run_answer_program(const std::string& name, const std::vector<std::string>& argv,
                                        const engine::Scene& scene, const Box2d3Options& options,
                                        const Box2d3Plan& plan) {
  if (const Status fits = check_answer_size(name, scene, options, plan); !fits) return fits.error();
  const std::string program = std::filesystem::path(argv.front()).filename().string();
  verifier::ChildCommand command;
  command.argv = argv;
  command.environment = {{"NODE_OPTIONS", std::nullopt}};
  command.limits.time_s = options.time_max_s;
  command.limits.output_size_max = options.answer_size_max;
  command.limits.printed_size_max = options.answer_size_max + command.limits.message_size_max;
  const verifier::ChildResult ran = run_child(command);
  if (const std::string failure = child_failure(ran, command.limits); !failure.empty()) {
    const bool is_missing = ran.end.how == verifier::ChildEnd::How::not_started;
    return Error{is_missing ? ErrorCode::usage : ErrorCode::io, fmt::format("{}: {} {}", name, program, failure),
                 first_message_line(ran.message)};
  }
  if (ran.end.exit_status != 0)
    return Error{ErrorCode::io,
                 fmt::format("{}: {} ended with status {}, expected 0", name, program, ran.end.exit_status),
                 first_message_line(ran.message)};
  return read_box2d3_answer(ran.output, scene, plan, fmt::format("{}: the answer of {}", name, program));
}

}  // namespace ticktrue::tool
