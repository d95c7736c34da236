// Top level of the command line: help, unknown arguments, exceptions that were not caught below.
// SPDX-License-Identifier: MIT
#include "tool/cli/command_line.h"

#include <fcntl.h>
#ifdef _WIN32
#include <io.h>
#endif

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

#include "base/build_info.h"
#include "engine/engine.h"
#include "tool/cli/commands.h"
#include "tool/cli/plugins.h"
#include "verifier/plugins/plugin.h"
#include "verifier/runs/completion.h"
#include "verifier/runs/plugin_isolation.h"

namespace ticktrue::cli {
namespace {

constexpr const char* description =
    "ticktrue records a simulation once and proves on any machine, at every commit, that it still runs bit for bit "
    "the same.";

constexpr const char* footer =
    R"(Which one do I want?
  simulate a scene, look at speed and result, keep nothing        run
  keep a session in a file (a trace), from a scene and inputs     record
  see what happens in a trace: table, JSON Lines or pictures      replay
  play in a scene in a window, or look at a trace there           play
  know whether a trace still runs bit for bit the same here       verify
  compare two traces of what should be the same session           diff
  look at a trace and what verify finds, in a browser             report
  see what is in a trace, or take its inputs out                  show
  know what makes a program diverge: heap, clock, libm, ...       shake
  make a failing session small: few bodies, inputs and ticks      reduce
  know which call of a tick is missing, extra or another          trail
  know which variable a save forgets                              unsaved
  record a program with a thousand seeds, and verify each         campaign
  save what a killed recorder left                                recover
  turn a mouse recording (or a model of one) into inputs          import
  turn a scene drawn in the R.U.B.E. editor into a scene file     import
  know what an integrator, solver, clock or precision changes     compare
  know what error a method has, and what less would cost          accuracy
  see how stiff and extreme cases end, with the numbers           stress
  compare our physics with Box2D 2.4.1 on a scene                 crosscheck
  know which stages and columns a scene is made of, and why       describe
  list the built-in scenes, print one as JSON                     scenes
  keep golden traces for continuous integration                   golden
  verify thousands of traces, and none twice                      corpus
  find the commit that made a trace diverge                       bisect
  prove that verify finds a changed bit in a trace                inject
  look for worlds in which something cached changes a bit         soak
  name the members of a struct of a program for ticktrue.hpp      columns
  know what this build and this machine compute with              env

Exit codes: 0 match, or done. 1 divergence, non-finite state or a failed check. 2 usage, input/output, bad scene or
inputs. 3 trace incomplete. 4 trace damaged. 5 not comparable. 6 not reproducible here.

Example:
  ticktrue record 'stack?boxes=10' --ticks 600 -o stack.ttr && ticktrue verify stack.ttr)";

/// Everything a user may have meant by an option that does not exist.
std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> subcommand_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

/// "record" or "import mouse": the innermost subcommand that was named.
const CLI::App* selected_command(const CLI::App& app, std::string& path) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().back();
    path += (path.empty() ? "" : " ") + command->get_name();
  }
  return command;
}

/// "SCENE REQUIRED" instead of "SCENE TEXT REQUIRED": what a positional argument is, its name says.
void drop_text_labels(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    for (CLI::Option* option : command->get_options())
      if (option->get_positional() && option->get_type_name() == "TEXT") option->type_name("");
    drop_text_labels(*command);
  }
}

/// Names that other tools have, and the command that does this here.
struct OtherName {
  std::string_view name;
  std::string_view hint;
};
constexpr std::string_view names_the_difference =
    "`ticktrue verify` names tick and columns of a difference, `report` shows them on a page, `shake` looks for the "
    "cause";
constexpr std::string_view reads_a_trace = "`ticktrue show` says what is in a trace, `replay` writes its states";
constexpr OtherName other_names[] = {
    {"analyse", names_the_difference},
    {"analyze", names_the_difference},
    {"cat", reads_a_trace},
    {"check", "`ticktrue verify` compares a trace with this build"},
    {"debug", names_the_difference},
    {"diagnose", names_the_difference},
    {"dump", reads_a_trace},
    {"explain", names_the_difference},
    {"find", names_the_difference},
    {"fix", "`ticktrue recover` saves what is intact of a damaged trace"},
    {"html", "`ticktrue report` writes a page that plays the trace"},
    {"info", reads_a_trace},
    {"inspect", reads_a_trace},
    {"list", "`ticktrue scenes` lists the scenes that are built in"},
    {"locate", names_the_difference},
    {"minimise", "`ticktrue reduce` makes a failing session small"},
    {"minimize", "`ticktrue reduce` makes a failing session small"},
    {"repair", "`ticktrue recover` saves what is intact of a damaged trace"},
    {"salvage", "`ticktrue recover` saves what is intact of a damaged trace"},
    {"shrink", "`ticktrue reduce` makes a failing session small"},
    {"simulate", "`ticktrue run` simulates a scene, `record` also writes a trace"},
    {"test", "`ticktrue verify` compares a trace with this build"},
    {"why", names_the_difference},
};

/// The next step after a command that does not exist.
std::string command_hint(const std::string& word, const std::vector<std::string>& names) {
  for (const OtherName& other : other_names)
    if (other.name == word) return std::string(other.hint);
  const std::string nearest = nearest_name(word, names);
  return nearest.empty() ? "see `ticktrue --help`" : "did you mean " + nearest + "?";
}

int report_usage(const CLI::App& app, const CLI::ParseError& parse_error, const std::vector<std::string>& words) {
  std::string path;
  const CLI::App* command = selected_command(app, path);
  std::string what = parse_error.what();
  if (what.size() > 1 && std::islower(static_cast<unsigned char>(what[1])) != 0)
    what[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(what[0])));
  std::string hint = "see `ticktrue " + (path.empty() ? "" : path + " ") + "--help`";
  if (dynamic_cast<const CLI::ExtrasError*>(&parse_error) != nullptr) {
    std::vector<std::string> options = option_names(*command);
    for (const std::string& name : option_names(app)) options.push_back(name);
    for (const std::string& word : words) {
      const std::string name = word.substr(0, word.find('='));
      if (name.compare(0, 2, "--") != 0 || std::find(options.begin(), options.end(), name) != options.end()) continue;
      what = "found option " + name + ", expected one that the command has";
      const std::string nearest = nearest_name(name, options);
      if (!nearest.empty()) hint = "did you mean " + nearest + "? " + hint;
      break;
    }
  }
  return fail_usage(Error{ErrorCode::usage, (path.empty() ? "command line" : path) + ": " + what, hint});
}

/// The words behind `--` of a command that runs a program: options among them are not ours. Returns how many are left.
int take_program(int argc, char** argv, CliContext& context) {
  constexpr std::string_view takers[] = {"shake", "trail", "unsaved"};
  if (argc < 2 || std::find(std::begin(takers), std::end(takers), argv[1]) == std::end(takers)) return argc;
  for (int i = 2; i < argc; ++i) {
    if (std::string_view(argv[i]) != "--") continue;
    context.program.assign(argv + i + 1, argv + argc);
    return i;
  }
  return argc;
}

int parse_and_run(int argc, char** argv) {
  if (const char* name = std::getenv(engine::instruction_set_variable); name != nullptr)
    if (const Status status = engine::use_instruction_set(name); !status) return fail_usage(status.error());
  // For tests of commands that documents print and that take long: what is wrong with the words is told, and nothing is
  // run. The first word, and in no help.
  const bool parse_only = argc > 1 && std::string_view(argv[1]) == "--parse-only";
  if (parse_only) {
    ++argv;
    --argc;
  }
  CliContext context;
  argc = take_program(argc, argv, context);
  const std::vector<std::string> words(argv + (argc > 0 ? 1 : 0), argv + argc);
  CLI::App app{description, "ticktrue"};
  app.footer(footer);
  app.set_version_flag("--version", build_line());
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.fallthrough();  // so that --plugin may stand behind the command
  const auto plugin_options = add_plugin_options(app);
  add_run(app, context);
  add_record(app, context);
  add_replay(app, context);
  add_play(app, context);
  add_verify(app, context);
  add_diff(app, context);
  add_report(app, context);
  add_show(app, context);
  add_recover(app, context);
  add_import(app, context);
  add_shake(app, context);
  add_reduce(app, context);
  add_trail(app, context);
  add_unsaved(app, context);
  add_campaign(app, context);
  add_compare(app, context);
  add_accuracy(app, context);
  add_stress(app, context);
  add_crosscheck(app, context);
  add_describe(app, context);
  add_scenes(app, context);
  add_golden(app, context);
  add_corpus(app, context);
  add_bisect(app, context);
  add_inject(app, context);
  add_soak(app, context);
  add_columns(app, context);
  add_env(app, context);

  drop_text_labels(app);

  if (words.empty()) {
    print(app.help());
    return exit_usage;
  }
  if (words[0].compare(0, 1, "-") != 0) {
    const std::vector<std::string> names = subcommand_names(app);
    if (std::find(names.begin(), names.end(), words[0]) == names.end()) {
      return fail_usage(Error{ErrorCode::usage,
                              "command line: found command \"" + words[0] + "\", which does not exist",
                              command_hint(words[0], names)});
    }
  }
  app.parse_complete_callback([&plugin_options, parse_only] {
    if (parse_only) throw CLI::RuntimeError(exit_ok);
    if (const auto exit_code = begin_plugins(*plugin_options)) throw CLI::RuntimeError(*exit_code);
  });
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& stop) {
    return stop.get_exit_code();
  } catch (const CLI::CallForHelp&) {
    print(app.help());
  } catch (const CLI::CallForVersion&) {
    print(build_line() + "\n");
  } catch (const CLI::ParseError& parse_error) {
    return report_usage(app, parse_error, words);
  }
  return context.exit_code;
}

#ifdef _WIN32
/// What is printed has the same bytes on every system: no line end is changed on the way.
void prepare_standard_streams() {
  ::_setmode(1, _O_BINARY);
  ::_setmode(2, _O_BINARY);
}
#else
/// A standard stream that was closed at start stays closed: else the next file opened takes its number, and messages go
/// into a trace. Read-only, so that writing to it still fails.
void prepare_standard_streams() {
  for (int descriptor = 0; descriptor <= 2; ++descriptor)
    if (::fcntl(descriptor, F_GETFD) == -1 && ::open("/dev/null", O_RDONLY) != descriptor) return;
  std::signal(SIGPIPE, SIG_IGN);  // a reader that goes away is seen as a failed write, not as a death
  std::signal(SIGXFSZ, SIG_IGN);  // so is a limit on the size of files
}
#endif

int run_to_exit_code(int argc, char** argv) {
  int exit_code = exit_usage;
  try {
    exit_code = parse_and_run(argc, argv);
  } catch (const verifier::PluginFailure& failure) {
    print_error(Error{ErrorCode::usage, failure.what(), ""});
    return exit_finding;
  } catch (const std::bad_alloc&) {
    return fail_usage(Error{ErrorCode::limit, "memory: the system refused to give more", ""});
  } catch (const std::exception& exception) {
    return fail_usage(Error{ErrorCode::usage, std::string("internal: ") + exception.what(), ""});
  }
  if (const Status flushed = flush_output(); !flushed) return fail_usage(flushed.error());
  return exit_code;
}

}  // namespace

int run_command_line(int argc, char** argv) {
  prepare_standard_streams();
  verifier::take_completion_pipe();
  const int exit_code = run_to_exit_code(argc, argv);
  std::fflush(nullptr);  // a slow reader of the output is no plug-in that hangs
  // From here on an exit is the tool's own: in a child process with plug-ins, and for the parent process.
  verifier::finish_isolated(exit_code);
  verifier::report_completion();
  return exit_code;
}

}  // namespace ticktrue::cli
