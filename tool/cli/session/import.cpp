// `ticktrue import`: turns recordings of other kinds into inputs, and scenes of other editors into scenes.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "engine/scene/scene_json.h"
#include "tool/cli/commands.h"
#include "tool/import/import_mouse.h"
#include "tool/import/import_rube.h"
#include "tool/import/mouse_model.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::cli {
namespace {

constexpr std::size_t session_file_size_max = 256u << 20;  // two months of mouse moves

struct MouseOptions {
  std::string csv;
  std::optional<std::uint64_t> model_seed;
  std::uint64_t seconds = 60;
  std::string scene;
  bool right_presses = false;
  std::string output;
  bool force = false;
};

Result<std::vector<engine::Input>> make_inputs(const MouseOptions& options, const engine::Scene& scene) {
  if (options.model_seed)
    return tool::model_mouse_session(scene, *options.model_seed, static_cast<double>(options.seconds));
  const Result<std::string> csv = read_text_file(options.csv, session_file_size_max);
  if (!csv) return csv.error();
  tool::MouseImportOptions import_options;
  import_options.right_presses = options.right_presses;
  return tool::import_mouse(*csv, options.csv, scene, import_options);
}

Status write_lines(const engine::Scene& scene, const std::vector<engine::Input>& inputs, const MouseOptions& options) {
  if (options.output == "-") {
    for (const engine::Input& input : inputs) print(engine::print_input(scene, input) + "\n");
    return {};
  }
  auto file = verifier::DataFile::create(options.output, options.force);
  if (!file) return file.error();
  for (const engine::Input& input : inputs)
    if (const Status status = file->write(engine::print_input(scene, input) + "\n"); !status) return status;
  return file->close();
}

int run_import_mouse(const MouseOptions& options) {
  if (options.csv.empty() != options.model_seed.has_value())
    return fail_usage(Error{ErrorCode::usage,
                            options.csv.empty() ? "import mouse: found neither a CSV file nor --model, expected one"
                                                : "import mouse: found a CSV file and --model, expected one of them",
                            ""});
  if (options.output != "-")
    if (const Status status = verifier::check_writable_target(options.output, options.force); !status)
      return fail_usage(status.error());
  if (const Status status = verifier::check_not_read(options.output, {options.csv, options.scene}); !status)
    return fail_usage(status.error());
  const Result<engine::Scene> scene = load_scene_argument(options.scene);
  if (!scene) return fail_usage(scene.error());
  const auto inputs = make_inputs(options, *scene);
  if (!inputs) return fail_usage(inputs.error());
  if (const Status status = write_lines(*scene, *inputs, options); !status) return fail_usage(status.error());

  std::vector<std::uint64_t> count_of_kind(engine::input_kinds.size());
  for (const engine::Input& input : *inputs) ++count_of_kind[static_cast<std::size_t>(input.kind)];
  std::string counts;
  for (std::size_t i = 0; i < engine::input_kinds.size(); ++i)
    if (count_of_kind[i] > 0 && engine::input_kinds[i].kind != engine::InputKind::end)
      counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count_of_kind[i], engine::input_kinds[i].name);
  const std::uint64_t tick_count = inputs->empty() ? 0 : inputs->back().tick;
  print_note(fmt::format("{}: {} ({} ticks, {:.1f} s)", options.output, counts.empty() ? "no inputs" : counts,
                         tick_count, static_cast<double>(tick_count) * scene->settings.dt));
  return exit_ok;
}

struct RubeOptions {
  std::string file;
  std::string output;
  bool force = false;
};

/// `dir/car.json` is the scene "car".
std::string scene_name(const std::string& path) {
  const std::size_t begin = path.find_last_of('/') == std::string::npos ? 0 : path.find_last_of('/') + 1;
  return path.substr(begin, path.find_last_of('.') > begin ? path.find_last_of('.') - begin : std::string::npos);
}

Status write_scene(const engine::Scene& scene, const RubeOptions& options) {
  if (options.output == "-") {
    print(engine::print_scene(scene));
    return {};
  }
  auto file = verifier::DataFile::create(options.output, options.force);
  if (!file) return file.error();
  if (const Status status = file->write(engine::print_scene(scene)); !status) return status;
  return file->close();
}

int run_import_rube(const RubeOptions& options) {
  if (options.output != "-")
    if (const Status status = verifier::check_writable_target(options.output, options.force); !status)
      return fail_usage(status.error());
  if (const Status status = verifier::check_not_read(options.output, {options.file}); !status)
    return fail_usage(status.error());
  const Result<std::string> json = read_text_file(options.file, tool::rube_file_size_max);
  if (!json) return fail_usage(json.error());
  const auto imported = tool::import_rube(*json, options.file, scene_name(options.file));
  if (!imported) return fail_usage(imported.error());
  for (const std::string& note : imported->notes) print_note(options.file + ": " + note);
  const engine::Scene& scene = imported->scene;
  if (const Status status = engine::check_scene(scene, options.file); !status) return fail_usage(status.error());
  if (const Status status = write_scene(scene, options); !status) return fail_usage(status.error());
  std::size_t shape_count = 0;
  for (const engine::Body& body : scene.bodies) shape_count += body.shapes.size();
  print_note(fmt::format("{}: {} bodies, {} shapes, {} joints", options.output, scene.bodies.size(), shape_count,
                         scene.joints.size()));
  return exit_ok;
}

void add_import_rube(CLI::App& import, CliContext& context) {
  auto options = std::make_shared<RubeOptions>();
  CLI::App* rube = import.add_subcommand("rube", "A scene drawn in the R.U.B.E. Box2D editor, as a scene file");
  rube->add_option("FILE", options->file, "\"Raw info\" JSON that the editor exported")->required();
  rube->add_option("-o,--output", options->output, "The scene file to write, - for standard output")
      ->type_name("F.json")
      ->required();
  rube->add_flag("--force", options->force, "Replace an existing file");
  rube->footer(
      "A drawing: `ticktrue import rube car.json -o scene.json && ticktrue run scene.json --ticks 600`.\n"
      "What is left out or changed (images, pulleys, ...) is listed on standard error.");
  rube->callback([options, &context] { context.exit_code = run_import_rube(*options); });
}

}  // namespace

void add_import(CLI::App& app, CliContext& context) {
  CLI::App* import = app.add_subcommand("import", "Turn recordings of other kinds into inputs, drawings into scenes")
                         ->group(group_session);
  import->require_subcommand(1);
  set_examples(*import, "ticktrue import mouse --model 1 --seconds 20 --scene thesis -o session.jsonl");

  auto options = std::make_shared<MouseOptions>();
  CLI::App* mouse = import->add_subcommand("mouse", "Mouse sessions of a person, or of a model of one, as inputs");
  mouse->add_option("CSV", options->csv, "Session as CSV (Balabit Mouse Dynamics Challenge)");
  add_number(*mouse, "--model", options->model_seed, "Instead of a file: a seeded model of clicks and drags")
      ->type_name("SEED");
  add_number(*mouse, "--seconds", options->seconds, "How long the model plays (default 60)", {1, 100'000});
  mouse->add_option("--scene", options->scene, "The scene the session is for: its pointer's window, its dt")
      ->type_name("SCENE")
      ->required();
  mouse->add_flag("--right", options->right_presses, "The right button presses and drags like the left one");
  mouse->add_option("-o,--output", options->output, "The JSON Lines file to write, - for standard output")
      ->type_name("F.jsonl")
      ->required();
  mouse->add_flag("--force", options->force, "Replace an existing file");
  set_examples(*mouse,
               "ticktrue import mouse --model 1 --seconds 20 --scene thesis -o session.jsonl\n"
               "ticktrue record thesis --inputs session.jsonl -o session.ttr",
               "A person's session: `ticktrue import mouse person.csv --scene thesis -o person.jsonl`.");
  mouse->callback([options, &context] { context.exit_code = run_import_mouse(*options); });
  add_import_rube(*import, context);
}

}  // namespace ticktrue::cli
