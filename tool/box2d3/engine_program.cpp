// Runs engine_run and plays its answer back.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/engine_program.h"

#include <string_view>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "engine/scene/scene_json.h"
#include "tool/box2d3/answer_program.h"
#include "tool/box2d3/box2d3_playback.h"
#include "verifier/runs/data_file.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::tool {

bool runs_in_node(const std::string& program) {
  return std::string_view(program).ends_with(".js");
}

Result<std::unique_ptr<Box2d3Peer>> make_engine_program_peer(const std::string& program, const engine::Scene& scene,
                                                             const Box2d3Options& options, const Box2d3Plan& plan) {
  TICKTRUE_ASSERT(plan.contact_window == 0);
  const Result<verifier::RunFolder> files = verifier::RunFolder::make("ticktrue-engine", "");
  if (!files) return files.error();
  const std::string scene_path = files->path() + "/scene.json";
  if (const Status written = verifier::write_data_file(scene_path, engine::print_scene(scene)); !written)
    return written.error();
  std::vector<std::string> argv;
  if (runs_in_node(program)) argv.push_back("node");
  argv.insert(argv.end(), {program, scene_path, std::to_string(plan.tick_count), std::to_string(plan.body_interval),
                           plan.warm_up ? "1" : "0"});
  Result<Box2d3Answer> answer = run_answer_program("engine_run", argv, scene, options, plan);
  if (!answer) return answer.error();
  return play_back(scene, plan, 1, *std::move(answer));
}

}  // namespace ticktrue::tool
