// Messages, data output, the SCENE argument, tick ranges, stop signals: shared by the subcommands.
// SPDX-License-Identifier: MIT
#include "tool/output/cli.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>

#include "base/limits.h"
#include "base/plain_text.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/json/nearest_name.h"
#include "engine/scene/scene_json.h"
#include "tool/output/scene_notes.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::cli {
namespace {

std::FILE* data_output = stdout;
int output_error = 0;  // errno of the first write of data that failed

volatile std::sig_atomic_t stop_signal = 0;
volatile std::time_t stop_time = 0;

void remember_stop(int signal) {
  // One request to stop may arrive as two signals (`timeout` signals the process and then its group): only a later one
  // kills.
  const std::time_t now = std::time(nullptr);
  if (stop_signal != 0 && now - stop_time > 1) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
  if (stop_signal == 0) stop_time = now;
  stop_signal = 1;
}

void print_message(const char* kind, std::string_view text) {
  if (data_output != nullptr)
    std::fflush(data_output);  // on a terminal, data printed before the message stands before it
  std::fprintf(stderr, "ticktrue: %s: %s\n", kind, plain_line(text).c_str());
}

std::optional<std::uint64_t> parse_number(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

std::string in_quotes(std::string_view text) {
  return "\"" + std::string(text) + "\"";
}

/// The parameter that the first unknown one of `NAME?key=value&...` may have been meant for; empty if none is near.
std::string nearest_parameter(std::string_view text) {
  const std::size_t question = text.find('?');
  if (question == std::string_view::npos) return "";
  std::vector<std::string> names;
  for (const engine::BuiltinScene& scene : engine::builtin_scenes())
    if (scene.name == text.substr(0, question))
      for (const engine::SceneParameter& parameter : scene.parameters) names.emplace_back(parameter.name);
  for (const std::string_view name : engine::scene_setting_names()) names.emplace_back(name);
  for (std::string_view rest = text.substr(question + 1); !rest.empty();) {
    const std::string_view part = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(part.size() + 1, rest.size()));
    const std::string_view key = part.substr(0, part.find('='));
    if (std::find(names.begin(), names.end(), key) == names.end()) return nearest_name(key, names);
  }
  return "";
}

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

std::uint64_t checked_number(const std::string& name, const std::string& text, NumberRange range) {
  const std::optional<std::uint64_t> value = parse_number(text);
  if (!value || *value < range.min || *value > range.max) {
    std::string expected = "a whole number";
    if (range.max != std::numeric_limits<std::uint64_t>::max())
      expected += " from " + std::to_string(range.min) + " to " + std::to_string(range.max);
    else if (range.min > 0)
      expected += ", at least " + std::to_string(range.min);
    throw CLI::ValidationError(name, "found " + in_quotes(text) + ", expected " + expected);
  }
  return *value;
}

}  // namespace

void print_error(const Error& error) {
  print_message("error", error.message);
  if (!error.hint.empty()) std::fprintf(stderr, "  %s\n", plain_line(error.hint).c_str());
}

void print_warning(std::string_view text) {
  print_message("warning", text);
}

void print_note(std::string_view text) {
  print_message("note", text);
}

int fail(const Error& error) {
  print_error(error);
  return exit_code_of(error.code);
}

int fail_usage(const Error& error) {
  print_error(error);
  return error.code == ErrorCode::inconsistent ? exit_finding : exit_usage;
}

void print(std::string_view text) {
  if (output_error != 0) return;
  if (data_output == nullptr) {
    output_error = EBADF;
    return;
  }
  static bool at_line_start = true;
  const std::string plain = plain_text(text, at_line_start);
  if (std::fwrite(plain.data(), 1, plain.size(), data_output) != plain.size()) output_error = errno != 0 ? errno : EIO;
}

void use_data_output(std::FILE* file) {
  data_output = file;
}

bool output_is_open() {
  return output_error == 0;
}

Status flush_output() {
  if (output_error == 0 && data_output != nullptr && std::fflush(data_output) != 0)
    output_error = errno != 0 ? errno : EIO;
  if (output_error == 0 || output_error == EPIPE) return {};
  return Error{ErrorCode::io, "standard output: cannot write: " + verifier::system_message(output_error), ""};
}

Result<std::string> read_text_file(const std::string& path, std::size_t size_max) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return Error{ErrorCode::io, path + ": cannot open: " + verifier::system_message(errno), ""};
  std::string text;
  char block[1 << 16];
  std::size_t count = 0;
  while ((count = std::fread(block, 1, sizeof block, file)) > 0 && text.size() <= size_max) text.append(block, count);
  const int error_number = std::ferror(file) != 0 ? errno : 0;
  std::fclose(file);
  if (error_number != 0)
    return Error{ErrorCode::io, path + ": cannot read: " + verifier::system_message(error_number), ""};
  if (text.size() > size_max)
    return Error{ErrorCode::limit,
                 path + ": file size: found more than " + std::to_string(size_max) + " bytes, expected at most that",
                 ""};
  return text;
}

std::string nearest_name(std::string_view typed, const std::vector<std::string>& candidates) {
  return std::string(engine::nearest_name(typed, {candidates.begin(), candidates.end()}));
}

Result<engine::Scene> load_session_scene(const std::string& text) {
  std::error_code code;
  if (ends_with(text, ".json") || std::filesystem::exists(text, code)) {
    const Result<std::string> json = read_text_file(text, limits::scene_file_size_max);
    if (!json) {
      const bool missing = !std::filesystem::exists(text, code);
      return Error{json.error().code, json.error().message,
                   missing ? "a file to begin with: ticktrue scenes stack --print > level.json" : ""};
    }
    return engine::parse_scene(*json, text);
  }
  const std::string name = text.substr(0, text.find('?'));
  std::vector<std::string> names;
  std::string list;
  for (const engine::BuiltinScene& scene : engine::builtin_scenes()) {
    names.emplace_back(scene.name);
    list += (list.empty() ? "" : ", ") + names.back();
  }
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    const std::string nearest = nearest_name(name, names);
    return Error{ErrorCode::usage,
                 "scene " + in_quotes(text) +
                     ": found neither a file nor a built-in scene of this name, expected a file or " + list,
                 nearest.empty() ? "`ticktrue scenes` lists the built-in scenes with their parameters"
                                 : "did you mean " + nearest + "? `ticktrue scenes` lists them with their parameters"};
  }
  Result<engine::Scene> scene = engine::make_builtin_scene(text);
  if (scene || !scene.error().hint.empty()) return scene;
  const std::string nearest = nearest_parameter(text);
  if (nearest.empty()) return scene;
  return Error{scene.error().code, scene.error().message, "did you mean " + nearest + "?"};
}

Result<engine::Scene> load_scene_argument(const std::string& text) {
  Result<engine::Scene> scene = load_session_scene(text);
  if (!scene) return scene;
  if (const Status status = tool::check_f32_reach(*scene, text); !status) return status.error();
  return scene;
}

Result<TickRange> parse_tick_range(const std::string& text, const std::string& option) {
  const Error refused{ErrorCode::usage,
                      option + ": found " + in_quotes(text) + ", expected A..B, A.., ..B or one tick, with A <= B", ""};
  TickRange range;
  const std::size_t dots = text.find("..");
  if (dots == std::string::npos) {
    const auto tick = parse_number(text);
    if (!tick) return refused;
    range.first = range.last = *tick;
    return range;
  }
  const std::string_view first = std::string_view(text).substr(0, dots);
  const std::string_view last = std::string_view(text).substr(dots + 2);
  if (first.empty() && last.empty()) return refused;
  if (!first.empty()) {
    const auto tick = parse_number(first);
    if (!tick) return refused;
    range.first = *tick;
  }
  if (!last.empty()) {
    const auto tick = parse_number(last);
    if (!tick) return refused;
    range.last = *tick;
  }
  if (range.first > range.last) return refused;
  return range;
}

void catch_stop_signals() {
#ifdef _WIN32
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, remember_stop);
#else
  // Without SA_RESTART: a read that waits for live input returns, so that the recording can be closed.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (signal == SIGHUP && before.sa_handler == SIG_IGN) continue;  // nohup: it goes on without the terminal
    struct sigaction action {};
    action.sa_handler = remember_stop;
    sigaction(signal, &action, nullptr);
  }
#endif
}

bool stop_requested() {
  return stop_signal != 0;
}

CLI::Option* add_number(CLI::App& command, const std::string& name, std::uint64_t& target, const std::string& help,
                        NumberRange range) {
  return command
      .add_option_function<std::string>(
          name, [&target, name, range](const std::string& text) { target = checked_number(name, text, range); }, help)
      ->type_name("N");
}

CLI::Option* add_number(CLI::App& command, const std::string& name, std::optional<std::uint64_t>& target,
                        const std::string& help, NumberRange range) {
  return command
      .add_option_function<std::string>(
          name, [&target, name, range](const std::string& text) { target = checked_number(name, text, range); }, help)
      ->type_name("N");
}

void set_examples(CLI::App& command, std::string_view examples, std::string_view remarks) {
  std::string text = "Examples:";
  while (!examples.empty()) {
    const std::size_t end = std::min(examples.find('\n'), examples.size());
    const std::string_view line = examples.substr(0, end);
    text += line.empty() ? "\n" : "\n  " + std::string(line);
    examples.remove_prefix(std::min(end + 1, examples.size()));
  }
  if (!remarks.empty()) text += "\n\n" + std::string(remarks);
  command.footer(text);
}

}  // namespace ticktrue::cli
