// `ticktrue recover`: saves what is intact of a cut or damaged trace.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/plain_text.h"
#include "replay/box/recover_box.h"
#include "replay/file/file.h"
#include "replay/trace_reader.h"
#include "tool/cli/commands.h"
#include "tool/output/json_output.h"
#include "tool/output/trace_text.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::cli {
namespace {

struct RecoverOptions {
  std::string file;
  std::string output;
  bool force = false;
  bool json = false;
};

Json json_of(const RecoverOptions& options, const replay::RecoverResult& result, bool nothing_saved) {
  const replay::TraceTail& tail = result.tail;
  Json object;
  object["schema"] = "ticktrue.recover/1";
  object["file"] = options.file;
  object["output"] = nothing_saved ? Json(nullptr) : Json(options.output);
  object["condition"] = condition_name(tail.condition);
  object["message"] = tail.message;
  object["ticks_written"] = result.ticks_written;
  object["pending_inputs"] = tail.has_pending_inputs;
  object["lost_but_intact"] = Json::array();
  for (const replay::IntactRange& range : tail.intact_after)
    object["lost_but_intact"].push_back({{"first_tick", range.first_tick}, {"last_tick", range.last_tick}});
  return object;
}

int recover_black_box(const RecoverOptions& options) {
  const auto box = replay::recover_box(options.file, options.output, options.force);
  if (!box) return fail(box.error());
  const replay::RecoverResult& result = box->result;
  const bool nothing_saved = result.ticks_written == 0;
  const int code = nothing_saved ? exit_code_of_condition(result.tail.condition) : exit_ok;
  if (options.json) {
    Json object = json_of(options, result, nothing_saved);
    object["first_tick"] = box->first_tick;
    object["closed"] = box->was_closed;
    object["has_save"] = box->has_save;
    object["left_out"] = box->left_out;
    print_json(object);
    return code;
  }
  if (nothing_saved)
    print(
        fmt::format("nothing recovered  no tick of {} is intact; {} was not written\n", options.file, options.output));
  else
    print(fmt::format("recovered  {}  {} ticks from {}, {}..{}\n", options.output, result.ticks_written, options.file,
                      box->first_tick, box->first_tick + result.ticks_written - 1));
  print(
      fmt::format("  condition  {}{}\n", box->was_closed ? "closed by its session" : "its session did not end",
                  result.tail.condition == replay::TraceCondition::damaged ? "; damaged: " + result.tail.message : ""));
  if (result.tail.has_pending_inputs)
    print(fmt::format("  lost       inputs of tick {}, whose result was never written\n", result.tail.ticks_intact));
  for (const std::string& text : box->left_out) print("  left out   " + plain_line(text) + "\n");
  if (!box->has_save && box->first_tick > 0)
    print("  note       holds no save: it names the place, and cannot be run again\n");
  return code;
}

int run_recover(const RecoverOptions& options) {
  if (const Status status = replay::check_output(options.output); !status) return fail_usage(status.error());
  if (const Status status = verifier::check_writable_target(options.output, options.force); !status)
    return fail_usage(status.error());
  if (replay::is_box_file(options.file)) return recover_black_box(options);
  const auto result = replay::recover_trace(options.file, options.output, options.force);
  if (!result) return fail(result.error());
  const replay::TraceTail& tail = result->tail;
  const bool nothing_saved = result->ticks_written == 0 && tail.condition != replay::TraceCondition::complete;
  const int code = nothing_saved ? exit_code_of_condition(tail.condition) : exit_ok;
  if (options.json) {
    print_json(json_of(options, *result, nothing_saved));
    return code;
  }
  if (nothing_saved)
    print(
        fmt::format("nothing recovered  no tick of {} is intact; {} was not written\n", options.file, options.output));
  else
    print(fmt::format("recovered  {}  {} ticks from {}\n", options.output, result->ticks_written, options.file));
  print(fmt::format("  condition  {}{}{}\n", condition_name(tail.condition), tail.message.empty() ? "" : ": ",
                    tail.message));
  if (tail.has_pending_inputs)
    print(fmt::format("  lost       inputs of tick {}, whose result was never written\n", tail.ticks_intact));
  for (const replay::IntactRange& range : tail.intact_after)
    print(fmt::format("  left out   intact, but behind the damage: {}\n", intact_range_text(range)));
  return code;
}

}  // namespace

void add_recover(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<RecoverOptions>();
  CLI::App* command =
      app.add_subcommand("recover", "Save what is intact of a cut or damaged trace")->group(group_session);
  command->add_option("FILE", options->file, "Trace that a dead recorder or a bad disk left, or a black box")
      ->required();
  command->add_option("-o,--output", options->output, "The trace to write: all that is intact from the start")
      ->type_name("OUT.ttr")
      ->required();
  command->add_flag("--force", options->force, "Replace an existing file");
  command->add_flag("--json", options->json, "One JSON object");
  set_examples(*command,
               "ticktrue record 'stack?boxes=10' --ticks 600 -o stack.ttr\n"
               "head -c 9000 stack.ttr > cut.ttr\n"
               "ticktrue recover cut.ttr -o saved.ttr && ticktrue verify saved.ttr");
  command->callback([options, &context] { context.exit_code = run_recover(*options); });
}

}  // namespace ticktrue::cli
