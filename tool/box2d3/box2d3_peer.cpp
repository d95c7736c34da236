// Runs Box2D 3: peer.mjs in node, or the program ticktrue_box2d3.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/box2d3_peer.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "engine/json/json_tree.h"
#include "tool/box2d/length_scale.h"
#include "tool/box2d3/answer_program.h"
#include "tool/box2d3/box2d3_playback.h"
#include "tool/box2d3/box2d3_script.h"
#include "verifier/runs/child.h"
#include "verifier/runs/data_file.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::tool {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view setup_hint =
    "run ./dev setup box2d3, and set TICKTRUE_BOX2D3 to its folder build/box2d3 (docs/crosscheck.md)";

Error no_box2d3(const std::string& what) {
  return Error{ErrorCode::usage, "box2d3 needs node and npm's box2d3-wasm: " + what, std::string(setup_hint)};
}

// What runs Box2D 3: a program that is built with it, or else node with a package in a folder.
struct Box2d3Place {
  std::string program;
  std::string folder;
};

// Empty if there is none.
std::string program_beside_this_one() {
  std::error_code failed;
  const fs::path self = fs::read_symlink("/proc/self/exe", failed);
  if (failed) return {};
  const fs::path program = self.parent_path() / "ticktrue_box2d3";
  return fs::is_regular_file(program, failed) ? program.string() : std::string();
}

Result<Box2d3Place> find_box2d3() {
  const char* named = std::getenv(box2d3_variable);
  if (named == nullptr)
    if (std::string program = program_beside_this_one(); !program.empty()) return Box2d3Place{std::move(program), {}};
  if (named == nullptr || *named == '\0') return no_box2d3("TICKTRUE_BOX2D3 is not set");
  std::error_code failed;
  if (fs::is_regular_file(named, failed)) return Box2d3Place{fs::absolute(named, failed).string(), {}};
  if (!fs::exists(fs::path(named) / "node_modules" / "box2d3-wasm" / "package.json", failed))
    return no_box2d3(fmt::format("TICKTRUE_BOX2D3: found no node_modules/box2d3-wasm in {}, expected one",
                                 engine::in_quotes(engine::shortened(named))));
  return Box2d3Place{{}, named};
}

// The version that package.json says: at most 64 KiB are read.
Result<std::string> package_version(const std::string& folder) {
  std::ifstream file(fs::path(folder) / "node_modules" / "box2d3-wasm" / "package.json", std::ios::binary);
  std::string text(std::size_t{64} << 10, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  const nlohmann::json description = nlohmann::json::parse(text, nullptr, false);
  if (!description.is_object() || !description.value("version", nlohmann::json()).is_string())
    return no_box2d3("package.json of box2d3-wasm: found no version, expected one");
  return engine::shortened(description.at("version").get<std::string>());
}

}  // namespace

Result<std::unique_ptr<Box2d3Peer>> make_box2d3_peer(const engine::Scene& scene, const Box2d3Options& options,
                                                     const Box2d3Plan& plan) {
  const Result<Box2d3Place> place = find_box2d3();
  if (!place) return place.error();
  const double scale = choose_length_scale(scene);
  const Result<std::string> text = box2d3_scene_text(scene, options, plan, scale);
  if (!text) return text.error();

  const Result<verifier::RunFolder> files = verifier::RunFolder::make("ticktrue-box2d3", "");
  if (!files) return files.error();
  const std::string script_path = files->path() + "/peer.mjs";
  const std::string scene_path = files->path() + "/scene.json";
  std::vector<std::string> argv{place->program, scene_path};
  if (place->program.empty()) {
    if (const Status written = verifier::write_data_file(script_path, box2d3_script); !written) return written.error();
    argv = {"node", script_path, place->folder, scene_path};
  }
  if (const Status written = verifier::write_data_file(scene_path, *text); !written) return written.error();

  Result<Box2d3Answer> answer = run_answer_program("box2d3", argv, scene, options, plan);
  if (!answer && answer.error().code == ErrorCode::usage)
    return Error{ErrorCode::usage, answer.error().message, std::string(setup_hint)};
  if (!answer) return answer.error();
  return play_back(scene, plan, scale, *std::move(answer));
}

bool box2d3_runs_in_node() {
  const Result<Box2d3Place> place = find_box2d3();
  return !place || place->program.empty();
}

Result<std::string> box2d3_version() {
  const Result<Box2d3Place> place = find_box2d3();
  if (!place) return place.error();
  const bool is_node = place->program.empty();
  const Result<std::string> package = is_node ? package_version(place->folder) : Result<std::string>(std::string());
  if (!package) return package.error();
  const std::string program = is_node ? "node" : place->program;
  verifier::ChildCommand command;
  command.argv = {program, "--version"};
  command.environment = {{"NODE_OPTIONS", std::nullopt}};
  command.limits.time_s = 60;
  command.limits.output_size_max = 4096;
  const verifier::ChildResult ran = run_child(command);
  if (const std::string failure = child_failure(ran, command.limits); !failure.empty())
    return no_box2d3(program + " " + failure);
  if (ran.end.exit_status != 0)
    return no_box2d3(fmt::format("{} --version ended with status {}, expected 0", program, ran.end.exit_status));
  if (is_node) return fmt::format("3 (box2d3-wasm {})", *package);
  return fmt::format("3 (native {})", engine::shortened(std::string_view(ran.output).substr(0, ran.output.find('\n'))));
}

}  // namespace ticktrue::tool
