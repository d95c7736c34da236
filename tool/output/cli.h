// Functions shared by the subcommands: messages, data output, the SCENE argument, tick ranges, stop signals.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/state/simulation.h"
#include "engine/engine.h"
#include "engine/scene/scene.h"
#include "verifier/report/exit_codes.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace ticktrue::cli {

using verifier::exit_code_of;
using verifier::exit_damaged;
using verifier::exit_finding;
using verifier::exit_incomplete;
using verifier::exit_not_comparable;
using verifier::exit_not_reproducible;
using verifier::exit_ok;
using verifier::exit_usage;
using verifier::worst_exit_code;

/// The context passed to every add_x. The callback of a subcommand stores its exit code here.
struct CliContext {
  int exit_code = exit_ok;
  std::vector<std::string> program;  // the words behind `--`, of a command that runs a program
};

// The groups of `ticktrue --help`: CLI::App::group(...) of each subcommand.
inline constexpr const char* group_session = "session";
inline constexpr const char* group_study = "study";
inline constexpr const char* group_upkeep = "upkeep";

// Messages go to stderr, as `ticktrue: error: place: what: found, expected`, the hint indented on a line of its own.
void print_error(const Error& error);
void print_warning(std::string_view text);
void print_note(std::string_view text);
/// Prints the error and returns the exit code it means: `return fail(result.error());`
int fail(const Error& error);
/// The same for commands that were given a scene or inputs, not a trace: exit_usage, or exit_finding for inconsistent.
int fail_usage(const Error& error);

// All data goes to standard output through these functions; see base/plain_text.h for escapes. A closed reader
// (`| head`) is no error: the rest is dropped.
void print(std::string_view text);
/// From here on data goes to this file instead of stdout; null: every write fails. For a process whose stdout others
/// use.
void use_data_output(std::FILE* file);
/// False if standard output is closed: long listings stop early.
bool output_is_open();
/// Flushes and returns a pending write error (a full disk). Main calls it last.
Status flush_output();

/// A SCENE argument: a JSON file if it ends in .json or exists as a file, else a built-in `name?key=value&...`.
/// Errors: io, usage (unknown name, with a suggestion), invalid_scene, limit, incompatible (also f32 too far from the
/// origin: check_f32_reach).
Result<engine::Scene> load_scene_argument(const std::string& text);
/// The same without check_f32_reach, for the scene of a session that `reduce` or `soak` wrote: such a scene may come
/// from a trace.
Result<engine::Scene> load_session_scene(const std::string& text);

/// The whole content of a file of at most `size_max` bytes. Errors: io, limit.
Result<std::string> read_text_file(const std::string& path, std::size_t size_max);

/// The candidate nearest to the typed text (few edits, or its beginning); empty if none is near.
std::string nearest_name(std::string_view typed, const std::vector<std::string>& candidates);

/// Ticks as users write them: `A..B` (both included), `A..`, `..B`, or a single `A`.
struct TickRange {
  std::uint64_t first = 0;
  std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  bool contains(std::uint64_t tick) const { return tick >= first && tick <= last; }
};
/// Errors: usage. `option` is what the message names first, such as "--ticks".
Result<TickRange> parse_tick_range(const std::string& text, const std::string& option);

/// From here on Ctrl-C, termination and the end of the terminal (unless ignored: nohup) do not kill the tool but make
/// stop_requested() true; one more, over a second later, kills.
void catch_stop_signals();
bool stop_requested();

/// A number option: decimal digits only, so that `-1` and `0x10` are refused; `min` and `max` are allowed values.
struct NumberRange {
  std::uint64_t min = 0;
  std::uint64_t max = std::numeric_limits<std::uint64_t>::max();
};
CLI::Option* add_number(CLI::App& command, const std::string& name, std::uint64_t& target, const std::string& help,
                        NumberRange range = {});
CLI::Option* add_number(CLI::App& command, const std::string& name, std::optional<std::uint64_t>& target,
                        const std::string& help, NumberRange range = {});

/// Text that stands below the options in a subcommand's help: `examples` has one line each, without indentation;
/// `remarks` follow as they are.
void set_examples(CLI::App& command, std::string_view examples, std::string_view remarks = {});

}  // namespace ticktrue::cli
