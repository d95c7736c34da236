// `ticktrue columns`: the TICKTRUE_COLUMNS line of a struct, from the debug information of a program.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "tool/cli/commands.h"
#include "tool/debug_info/columns_line.h"
#include "tool/debug_info/program_types.h"
#include "tool/output/json_output.h"
#include "verifier/report/report.h"
#include "verifier/runs/child_process.h"

#ifdef TICKTRUE_HAS_FORK
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace ticktrue::cli {
namespace {

using debug_info::StructLayout;
using debug_info::StructName;
using debug_info::StructTypes;

constexpr double time_max_s = 120;

struct ColumnsOptions {
  std::string program;
  std::string name;
  bool list = false;
  bool table = false;
  bool json = false;
};

Json layout_json(const StructLayout& layout) {
  Json object;
  object["struct"] = layout.name;
  object["size"] = layout.size;
  object["has_private"] = layout.has_private;
  object["members"] = Json::array();
  for (const debug_info::LayoutMember& member : layout.members)
    object["members"].push_back({{"name", member.name},
                                 {"type", member.type},
                                 {"offset", member.offset},
                                 {"size", member.size},
                                 {"column", member.refusal.empty()},
                                 {"refusal", member.refusal.empty() ? Json(nullptr) : Json(member.refusal)}});
  object["padding"] = Json::array();
  for (const debug_info::Gap& gap : layout.gaps)
    object["padding"].push_back({{"first", gap.first}, {"last", gap.last}});
  return object;
}

int run_list(const ColumnsOptions& options) {
  const Result<std::vector<StructName>> names = debug_info::struct_names(options.program);
  if (!names) return fail_usage(names.error());
  if (options.json) {
    Json object;
    object["schema"] = "ticktrue.columns/1";
    object["program"] = options.program;
    object["structs"] = Json::array();
    for (const StructName& each : *names) object["structs"].push_back({{"name", each.name}, {"size", each.size}});
    print_json(object);
    return exit_ok;
  }
  for (const StructName& each : *names) print(fmt::format("{:>8}  {}\n", each.size, each.name));
  return exit_ok;
}

/// Several structs of the name.
Error several(const ColumnsOptions& options, const std::vector<StructTypes>& found) {
  std::string names;
  bool is_same_name = true;
  for (const StructTypes& each : found) {
    names += (names.empty() ? "" : ", ") + each.types[0].name + " (" + std::to_string(each.types[0].size) + " bytes)";
    is_same_name = is_same_name && each.types[0].name == found[0].types[0].name;
  }
  return {ErrorCode::usage,
          options.program + ": struct " + options.name + ": found " + std::to_string(found.size()) + ": " + names +
              ", expected one",
          is_same_name
              ? "two files of the program define it differently: that is undefined in C++; or one of them is older"
              : "name it with its namespace"};
}

int run_struct(const ColumnsOptions& options) {
  Result<std::vector<StructTypes>> found = debug_info::find_structs(options.program, options.name);
  if (!found && found.error().code == ErrorCode::usage) {
    std::vector<std::string> names;
    if (const auto known = debug_info::struct_names(options.program))
      for (const StructName& each : *known) names.push_back(each.name);
    const std::string nearest = nearest_name(options.name, names);
    return fail_usage(Error{ErrorCode::usage, found.error().message,
                            (nearest.empty() ? "" : "did you mean " + nearest + "? ") + "`ticktrue columns " +
                                verifier::shell_word(options.program) + " --list` lists the structs"});
  }
  if (!found) return fail_usage(found.error());
  if (found->size() > 1) return fail_usage(several(options, *found));
  const std::vector<StructLayout> layouts = debug_info::struct_layouts(found->front());
  const std::string lines = debug_info::columns_text(layouts);
  if (options.json) {
    Json object;
    object["schema"] = "ticktrue.columns/1";
    object["program"] = options.program;
    object["lines"] = lines;
    object["structs"] = Json::array();
    for (const StructLayout& layout : layouts) object["structs"].push_back(layout_json(layout));
    print_json(object);
  } else if (options.table) {
    for (const StructLayout& layout : layouts) print(debug_info::layout_table(layout));
  } else {
    print(lines);
  }
  return layouts.back().has_columns() ? exit_ok : exit_finding;
}

int run_columns(const ColumnsOptions& options) {
  if (options.list == !options.name.empty())
    return fail_usage(Error{ErrorCode::usage,
                            options.list ? "columns: found a struct with --list, expected one of them"
                                         : "columns: found no struct, expected its name or --list",
                            "see `ticktrue columns --help`"});
  return options.list ? run_list(options) : run_struct(options);
}

#ifdef TICKTRUE_HAS_FORK
/// Debug information comes from outside, and libdw was not made for hostile files: a child process reads it, with
/// bounds.
int run_isolated(const ColumnsOptions& options) {
  verifier::ChildProcess child;
  std::fflush(nullptr);
  const verifier::ChildProcess::Side side = child.fork();
  if (side == verifier::ChildProcess::Side::failed)
    return fail_usage(Error{ErrorCode::io, "columns: the system gave no process: " + child.failure(), ""});
  if (side == verifier::ChildProcess::Side::child) {
    const rlimit seconds{static_cast<rlim_t>(time_max_s), static_cast<rlim_t>(time_max_s)};
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CPU, &seconds);
    ::setrlimit(RLIMIT_CORE, &no_core);
    int exit_code = run_columns(options);
    if (const Status flushed = flush_output(); !flushed) exit_code = fail_usage(flushed.error());
    std::fflush(nullptr);
    ::_exit(exit_code);
  }
  const verifier::ChildEnd end = child.wait(time_max_s, {});
  if (end.how == verifier::ChildEnd::How::exited) return end.exit_status;
  return fail_usage(
      Error{ErrorCode::corrupt,
            options.program + ": debug information: the reader " +
                (end.how == verifier::ChildEnd::How::timed_out ? fmt::format("found no end after {} s", time_max_s)
                                                               : "ended with signal " + std::to_string(end.signal)) +
                ", expected an ELF file that is whole",
            "build the program anew"});
}
#else
int run_isolated(const ColumnsOptions& options) {
  return run_columns(options);
}
#endif

}  // namespace

void add_columns(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<ColumnsOptions>();
  CLI::App* command =
      app.add_subcommand("columns", "Print the TICKTRUE_COLUMNS line of a struct of a program")->group(group_upkeep);
  command->add_option("PROGRAM", options->program, "Program, shared library or object file, compiled with -g")
      ->required();
  command->add_option("STRUCT", options->name, "Name of the struct, as in Unit or game::Unit");
  command->add_flag("--list", options->list, "List the structs of the program instead, with their sizes");
  command->add_flag("--table", options->table, "Offsets, sizes, types and padding instead of lines");
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.columns/1)");
  command->footer(
      "For a program compiled with -g:\n"
      "  ticktrue columns ./mygame Unit\n"
      "  ticktrue columns ./mygame game::Unit --table\n"
      "  ticktrue columns ./mygame --list");
  command->callback([options, &context] { context.exit_code = run_isolated(*options); });
}

}  // namespace ticktrue::cli
