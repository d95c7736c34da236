// The build command reads CC, CXX, CFLAGS and CXXFLAGS, and writes the program to the file TICKTRUE_PROGRAM.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/rebuild.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

#include "base/plain_text.h"
#include "tool/experiment/shake/facts.h"
#include "tool/experiment/shake/launch.h"
#include "verifier/runs/child.h"

namespace ticktrue::shake {
namespace {

namespace fs = std::filesystem;

constexpr const char* program_variable = "TICKTRUE_PROGRAM";
constexpr std::size_t last_line_count = 6;
constexpr std::size_t build_output_max = std::size_t{16} << 20;

struct Compilers {
  std::string c;
  std::string cpp;
};

std::string variable_or(const char* name, const char* otherwise) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != 0 ? value : otherwise;
}

Compilers own_compilers() {
  return {variable_or("CC", "cc"), variable_or("CXX", "c++")};
}

verifier::ChildResult run_shell(const std::string& text, double time_s) {
  verifier::ChildCommand command;
  command.argv = {"sh", "-c", text};
  command.limits.time_s = time_s;
  command.limits.output_size_max = build_output_max;
  return verifier::run_child(command);
}

bool is_clang(const std::string& compiler) {
  constexpr double probe_time_s = 30;
  return run_shell(compiler + " --version", probe_time_s).output.find("clang") != std::string::npos;
}

/// Compilers of the other family; empty: none is installed.
Compilers other_compilers() {
  if (is_clang(own_compilers().cpp)) return find_program("g++").empty() ? Compilers{} : Compilers{"gcc", "g++"};
  for (const char* version : {"", "-19", "-18", "-17", "-16", "-15", "-14"})
    if (!find_program(std::string("clang++") + version).empty())
      return {std::string("clang") + version, std::string("clang++") + version};
  return {};
}

/// The flags of a kind, or the reason why this kind cannot be built here.
struct Flags {
  std::string words;
  std::string missing;
};
Flags flags_of(BuildKind kind) {
  switch (kind) {
    case BuildKind::other_compiler:
      return {"", ""};
    case BuildKind::no_optimisation:
      return {"-O0", ""};
    case BuildKind::contraction:
#ifdef __x86_64__
      if (!processor_has("fma")) return {"", "this processor has no fused products"};
      // At -O1, gcc only fuses products with this pass of -O2.
      return {is_clang(own_compilers().cpp) ? "-mfma -ffp-contract=fast"
                                            : "-mfma -ffp-contract=fast -fexpensive-optimizations",
              ""};
#else
      return {"-ffp-contract=fast", ""};
#endif
    case BuildKind::this_processor:
      return {"-O3 -march=native", ""};
  }
  return {};
}

std::string last_lines(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) lines.push_back(plain_line(line));
  std::string last;
  const std::size_t first = lines.size() - std::min(lines.size(), last_line_count);
  for (std::size_t i = first; i < lines.size(); ++i) last += (last.empty() ? "" : "\n") + lines[i];
  return last;
}

/// The error of a build; empty: success.
struct Failure {
  std::string what;
  std::string lines;  // the last printed lines of the command
};
Failure build(const RebuildOptions& options, const std::string& program, const Compilers& compilers,
              const std::string& flags) {
  verifier::ChildCommand command;
  command.argv = {"sh", "-c", options.command};
  const auto with = [&](const char* name) {
    const std::string own = variable_or(name, "");
    return own.empty() || flags.empty() ? own + flags : own + " " + flags;
  };
  command.environment = {{"CC", compilers.c},
                         {"CXX", compilers.cpp},
                         {"CFLAGS", with("CFLAGS")},
                         {"CXXFLAGS", with("CXXFLAGS")},
                         {program_variable, program}};
  command.limits.time_s = options.time_s;
  command.limits.output_size_max = build_output_max;
  const verifier::ChildResult result = verifier::run_child(command);
  std::string what = verifier::child_failure(result, command.limits);
  if (what.empty() && result.end.exit_status != 0) what = "ended with status " + std::to_string(result.end.exit_status);
  std::error_code failed;
  if (what.empty() && !fs::is_regular_file(program, failed))
    what = std::string("left no program in the file that ") + program_variable + " names";
  if (what.empty()) return {};
  return {what, last_lines(result.message.empty() ? result.output : result.message)};
}

std::string path_of(const RebuildOptions& options, const std::string& name) {
  return options.folder + "/built-" + name;
}

bool has_same_bytes(const std::string& a, const std::string& b) {
  std::ifstream left(a, std::ios::binary);
  std::ifstream right(b, std::ios::binary);
  using Bytes = std::istreambuf_iterator<char>;
  return std::equal(Bytes(left), Bytes(), Bytes(right), Bytes());
}

}  // namespace

std::optional<BuildKind> build_kind_named(std::string_view perturbation) {
  constexpr std::string_view names[] = {"other_compiler", "no_optimisation", "contraction", "this_processor"};
  static_assert(std::size(names) == build_kind_count);
  for (std::size_t i = 0; i < build_kind_count; ++i)
    if (names[i] == perturbation) return static_cast<BuildKind>(i);
  return std::nullopt;
}

Builds no_builds(const std::string& why) {
  Builds builds;
  for (Build& build : builds) build.missing = why;
  return builds;
}

Result<std::string> build_as_is(const RebuildOptions& options) {
  std::string program = path_of(options, "0");
  const Failure failure = build(options, program, own_compilers(), "");
  if (failure.what.empty()) return program;
  const std::string hint =
      std::string("it has to build the program anew with CC, CXX, CFLAGS and CXXFLAGS, as the file ") +
      program_variable;
  return Error{ErrorCode::usage, "--rebuild: " + options.command + ": " + failure.what,
               (failure.lines.empty() ? "" : failure.lines + "\n") + hint};
}

Build build_kind(const RebuildOptions& options, BuildKind kind, const std::string& as_is) {
  const Flags flags = flags_of(kind);
  if (!flags.missing.empty()) return {"", flags.missing};
  const bool is_other = kind == BuildKind::other_compiler;
  const Compilers compilers = is_other ? other_compilers() : own_compilers();
  if (compilers.cpp.empty()) return {"", "no other compiler is installed: apt-get install clang"};
  const std::string program = path_of(options, std::to_string(1 + static_cast<int>(kind)));
  const Failure failure = build(options, program, compilers, flags.words);
  if (!failure.what.empty()) {
    const std::string line = failure.lines.substr(failure.lines.rfind('\n') + 1);
    return {"", "--rebuild " + failure.what + (line.empty() ? "" : ": " + line)};
  }
  if (has_same_bytes(program, as_is))
    return {"", "the build is the same, byte for byte: --rebuild has to build anew and to use CXX and CXXFLAGS"};
  return {program, ""};
}

}  // namespace ticktrue::shake
