// `ticktrue play`: the options of the window.
// SPDX-License-Identifier: MIT
#include "tool/play/play.h"

#include <CLI/CLI.hpp>

#include "tool/cli/commands.h"

namespace ticktrue::cli {
namespace {

constexpr int size_min_px = 160;
constexpr int size_max_px = 8192;

/// "1280x800"
void parse_size(const std::string& text, PlayOptions& options) {
  const std::size_t cross = text.find('x');
  const auto number = [&text](const std::string& part) {
    if (part.empty() || part.size() > 4 || part.find_first_not_of("0123456789") != std::string::npos ||
        std::stoi(part) < size_min_px || std::stoi(part) > size_max_px)
      throw CLI::ValidationError("--size", "found \"" + text + "\", expected WIDTHxHEIGHT of " +
                                               std::to_string(size_min_px) + ".." + std::to_string(size_max_px) +
                                               " px, such as 1280x800");
    return std::stoi(part);
  };
  options.width = number(text.substr(0, cross));
  options.height = number(cross == std::string::npos ? "" : text.substr(cross + 1));
}

}  // namespace

void add_play(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<PlayOptions>();
  CLI::App* command =
      app.add_subcommand("play", "A window: play in a scene and record it, or look at a trace")->group(group_session);
  command
      ->add_option("SCENE", options->what,
                   "Scene file (.json) or built-in scene: what is done in it is recorded. Or a trace (.ttr): it is "
                   "played and compared")
      ->required();
  command
      ->add_option("-o,--output", options->output,
                   "The trace to write (default: session-1.ttr, or the next number that is free)")
      ->type_name("OUT.ttr");
  command->add_flag("--force", options->force, "Replace existing files");
  command->add_option("--against", options->against, "Of a trace: another one, drawn as ghosts")->type_name("FILE");
  add_number(*command, "--from", options->from, "Of a trace: begin with so many ticks done");
  command->add_option("--layers", options->layers, "Keys of the layers that are on at first, such as cn")
      ->type_name("KEYS");
  command
      ->add_option_function<std::string>(
          "--size", [options](const std::string& text) { parse_size(text, *options); },
          "Of the picture, px (default 1280x800)")
      ->type_name("WxH");
  command->add_flag("--headless", options->headless, "No window: frames of equal length, as fast as they are drawn");
  command->add_option("--hz", options->hz, "Frames per second with --headless (default 60)")
      ->check(CLI::Range(1.0, 1000.0))
      ->type_name("N");
  add_number(*command, "--frames", options->frame_count, "End after so many frames",
             {1, std::numeric_limits<std::uint64_t>::max()});
  command->add_option("--script", options->script, "Events of a scripted person, as JSON Lines (docs/play.md)")
      ->type_name("FILE");
  command->add_option("--screenshot", options->screenshot, "The last picture")->type_name("FILE.png");
  command->add_option("--dump-frame", options->dump, "What was drawn last, beside the state, as JSON")
      ->type_name("FILE.json");
  command->add_flag("--json", options->json, "One JSON object");
  set_examples(*command,
               "ticktrue play 'pyramid?base=12' --headless --frames 120 -o mine.ttr && ticktrue verify mine.ttr\n"
               "ticktrue play mine.ttr --headless --frames 60 --screenshot mine.png\n"
               "ticktrue play 'mixed_pile?bodies=200' --headless --frames 300 --layers cn --screenshot pile.png",
               "In a window:\n"
               "  ticktrue play thesis\n"
               "  ticktrue play session-1.ttr\n"
               "  ticktrue play mine.ttr --against theirs.ttr\n"
               "h shows the keys, q ends. Nothing that is drawn changes a bit of what is recorded.");
  command->callback([options, &context] { context.exit_code = run_play(*options); });
}

}  // namespace ticktrue::cli
