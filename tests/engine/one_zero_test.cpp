// A state contains no -0. The order of terms would otherwise decide the sign of a zero sum.
// SPDX-License-Identifier: MIT
//
// Verified: after each stage of each tick, in sessions with every solver, integrator, joint, shape, force and input.
// Not verified: states loaded from an image, which keep a -0 of the image.
#include <fstream>
#include <iterator>

#include "base/build_info.h"
#include "base/parallel/chunk_order.h"
#include "engine/scene/input.h"
#include "engine/scene/scene_json.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

class ZeroObserver final : public StageObserver {
 public:
  explicit ZeroObserver(const engine::Engine& engine) : engine_(engine) {}
  void after_stage(std::size_t stage, const StateView& state) override {
    if (!found.empty()) return;
    const auto place = find_negative_zero(state);
    if (!place) return;
    const TableSchema& table = state.schema->tables[place->table];
    found = "tick " + std::to_string(engine_.tick() - 1) + ", " + engine_.stage_names()[stage] + ": " + table.name +
            "." + table.columns[place->column].name + ", row " + std::to_string(place->row);
  }
  std::string found;

 private:
  const engine::Engine& engine_;
};

/// The place of the first -0 of a run; empty: none.
std::string negative_zero_of(const Session& session, std::uint64_t tick_count) {
  const auto engine = make_engine_or_fail(session.scene);
  if (find_negative_zero(engine->state())) return "the initial state";
  ZeroObserver observer(*engine);
  for (std::uint64_t tick = 0; tick < tick_count && observer.found.empty(); ++tick)
    REQUIRE(engine->step(input_of(session, tick), &observer));
  return observer.found;
}

std::string text_of(const std::string& name) {
  std::ifstream in(std::string(TICKTRUE_SOURCE_DIR) + "/tests/worlds/" + name);
  REQUIRE(in.good());
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A scene of tests/worlds with its inputs, in the requested precision.
Session session_of_files(const std::string& name, Precision precision) {
  Result<Scene> scene = engine::parse_scene(text_of(name + ".json"), name);
  REQUIRE(scene.has_value());
  Session session{name, *std::move(scene), {}};
  session.scene.settings.precision = precision;
  const std::string lines = text_of(name + ".jsonl");
  std::vector<std::vector<engine::Input>> inputs;  // [tick]
  for (std::size_t begin = 0; begin < lines.size();) {
    const std::size_t end = lines.find('\n', begin);
    auto input = engine::parse_input(session.scene, lines.substr(begin, end - begin), name);
    REQUIRE(input.has_value());
    if (inputs.size() <= input->tick) inputs.resize(input->tick + 1);
    input->sequence = static_cast<std::uint32_t>(inputs[input->tick].size());
    inputs[input->tick].push_back(*input);
    begin = end + 1;
  }
  inputs.pop_back();  // the last input ends the session
  for (const std::vector<engine::Input>& of_tick : inputs) {
    session.inputs.emplace_back();
    engine::encode_inputs(of_tick, session.inputs.back());
  }
  return session;
}

}  // namespace

TEST_CASE("no stage stores a negative zero", "[engine][determinism][zero]") {
  for (const Session& session : property_sessions()) {
    CAPTURE(session.name);
    CHECK(negative_zero_of(session, 60) == "");
  }
}

TEST_CASE("scenes and inputs full of negative zeros store none", "[engine][determinism][zero]") {
  for (const auto& precision : engine::precisions) {
    CAPTURE(precision.name);
    Scene scene = empty_scene(precision.kind);
    scene.gravity = {-0.0, -0.0};
    scene.inputs = {engine::InputKind::spawn, engine::InputKind::impulse, engine::InputKind::set_velocity,
                    engine::InputKind::set_gravity};
    for (int i = 0; i < 3; ++i) scene.bodies.push_back(body_of(disc_shape(0.5), {-0.0, 3.0 * i}));
    for (Body& body : scene.bodies) {
      body.velocity = {-0.0, -0.0};
      body.angle = -0.0;
      body.angular_velocity = -0.0;
    }
    scene.prototypes.push_back(scene.bodies[0]);
    scene.prototypes[0].name = "disc";
    Session session{"negative zeros", scene, {}};
    for (const engine::InputKind kind : scene.inputs) {
      engine::Input input;
      input.kind = kind;
      for (double& value : input.values) value = -0.0;
      Bytes bytes;
      engine::encode_inputs({input}, bytes);
      session.inputs.push_back(bytes);
    }
    CHECK(negative_zero_of(session, 20) == "");
  }
}

TEST_CASE("the sign of a friction force without a value does not follow the batches of contacts",
          "[engine][determinism][zero][threads][regression]") {
  for (const auto& precision : engine::precisions) {
    const Session session = session_of_files("sign_of_zero", precision.kind);
    const std::uint64_t tick_count = session.inputs.size();
    const std::vector<std::uint64_t> expected = tick_hashes(session, tick_count);
    for (const std::size_t chunk_size : {1, 2, 3, 5}) {
      CAPTURE(precision.name, chunk_size);
      ChunkOrder order(true);
      engine::EngineOptions options;
      options.parallel = {&order, chunk_size};
      const bool same = tick_hashes(session, tick_count, options) == expected;
      CHECK(same);
    }
  }
}
