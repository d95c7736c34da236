// This engine as a child process: the same motion as in this process, and errors instead of results.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/engine_program.h"

#include <filesystem>
#include <string>

#include "engine/engine.h"
#include "tests/support/catch.h"
#include "tests/support/scenes.h"
#include "tool/study/peer_curves.h"
#include "tool/study/worlds.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

using Catch::Matchers::Contains;

// Beside the tool, in the same build.
std::string engine_run() {
  return (std::filesystem::path(TICKTRUE_TOOL).parent_path() / "engine_run").string();
}

tool::Box2d3Plan planned(std::uint64_t tick_count, std::uint64_t interval) {
  tool::Box2d3Plan plan;
  plan.tick_count = tick_count;
  plan.body_interval = interval;
  plan.warm_up = true;
  return plan;
}

}  // namespace

TEST_CASE("a chain swings in engine_run as it does in this process", "[verifier][study][equivalence]") {
  Scene scene = worlds::chain(Precision::f32, 5, {1, 0}, 1);
  scene.bodies.push_back(scene.bodies[1]);
  scene.bodies.back().type = engine::BodyType::kinematic_body;
  scene.bodies.back().mass.reset();
  scene.bodies.back().position = {50, 3};
  scene.bodies.back().velocity = {1, 2};
  scene.bodies.back().angular_velocity = 0.5;
  auto run = tool::make_engine_program_peer(engine_run(), scene, {}, planned(60, 20));
  if (!run) FAIL(run.error().message + "\n" + run.error().hint);
  CHECK((*run)->ms_per_tick() > 0);
  const auto own = engine::make_engine(scene);
  REQUIRE(own);
  for (int tick = 1; tick <= 60; ++tick) {
    (*run)->step();
    REQUIRE((*own)->step({scene.settings.dt, {}}, nullptr));
    if (tick % 20 != 0) continue;
    const auto theirs = (*run)->bodies();
    const auto ours = (*own)->bodies();
    REQUIRE(theirs.size() == ours.size());
    for (std::size_t i = 0; i < ours.size(); ++i) {
      INFO("tick " << tick << ", body " << i);
      // Nine digits of a float read back to it; an angle is written as its cosine and sine.
      CHECK(theirs[i].origin.x == Approx(ours[i].origin.x).epsilon(0).margin(1e-6));
      CHECK(theirs[i].origin.y == Approx(ours[i].origin.y).epsilon(0).margin(1e-6));
      CHECK(theirs[i].angle == Approx(ours[i].angle).epsilon(0).margin(1e-8));
      CHECK(theirs[i].velocity.x == Approx(ours[i].velocity.x).epsilon(0).margin(1e-6));
      CHECK(theirs[i].velocity.y == Approx(ours[i].velocity.y).epsilon(0).margin(1e-6));
    }
  }
}

TEST_CASE("an engine program that is missing, refuses or answers nonsense gives an error",
          "[verifier][study][corruption]") {
  const Scene scene = stack_scene(1);
  const auto missing = tool::make_engine_program_peer("/nowhere/engine_run", scene, {}, planned(1, 1));
  REQUIRE_FALSE(missing);
  CHECK(missing.error().code == ErrorCode::usage);
  CHECK_THAT(missing.error().message, Contains("engine_run: engine_run cannot be started"));
  const auto nonsense = tool::make_engine_program_peer("/bin/echo", scene, {}, planned(1, 1));
  REQUIRE_FALSE(nonsense);
  CHECK(nonsense.error().code == ErrorCode::corrupt);
  CHECK_THAT(nonsense.error().message, Contains("engine_run: the answer of echo: line 1"));
  const auto refused = tool::make_engine_program_peer(engine_run(), scene, {}, planned(0, 1));
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::io);
  CHECK_THAT(refused.error().message, Contains("ended with status 2"));
  CHECK(tool::runs_in_node("build/wasm/engine_run.js"));
  CHECK_FALSE(tool::runs_in_node("build/release/engine_run"));
}

TEST_CASE("times of WebAssembly and native ones are never judged against each other", "[verifier][study]") {
  tool::PeerCurves curves;
  const auto point = [](const char* setting, double error, double ms) {
    tool::PeerPoint out;
    out.setting = setting;
    out.error = error;
    out.time_ms.min = ms;
    return out;
  };
  curves.ours = {point("4 sub", 0.1, 1), point("8 sub", 0.001, 9)};
  curves.box2d = {point("4 sub", 0.5, 10), point("8 sub", 0.1, 20)};
  curves.is_judged = false;
  tool::conclude(curves);
  CHECK(curves.ratio == Approx(0.01));  // at 8 substeps
  CHECK_FALSE(curves.holds);
  CHECK_THAT(curves.conclusion, Contains("not comparable"));
  curves.is_judged = true;
  tool::conclude(curves);
  CHECK(curves.holds);
}

TEST_CASE("an engine program must be there", "[verifier][study]") {
  tool::PeerCurvesOptions options;
  options.names = {"swinging_chain_50"};
  options.kinds = {tool::PeerKind::box2d3};
  options.engine_program = "/nowhere/engine_run";
  const auto missing = tool::run_peer_curves(options);
  REQUIRE_FALSE(missing);
  CHECK(missing.error().code == ErrorCode::usage);
  CHECK_THAT(missing.error().message, Contains("found no file \"/nowhere/engine_run\""));
  CHECK_THAT(missing.error().hint, Contains("./dev build wasm engine_run"));
}
