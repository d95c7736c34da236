// The budget of automatic substeps: what it bounds, what it counts, and what it must not change.
// SPDX-License-Identifier: MIT
#include <cstring>
#include <string>
#include <vector>

#include "base/hash.h"
#include "base/parallel/chunk_order.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/scene/input.h"
#include "engine/scene/scene_binary.h"
#include "engine/scene/scene_json.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BudgetReport;
using engine::Engine;

namespace {

Scene scene_with_budget(const std::string& text, int budget, Precision precision = Precision::f32) {
  Result<Scene> scene = engine::make_builtin_scene(text);
  REQUIRE(scene.has_value());
  scene->settings.precision = precision;
  engine::use_fixed_substeps(scene->settings, 4);
  scene->settings.auto_substeps.emplace();
  scene->settings.substep_budget = budget;
  return *std::move(scene);
}

BudgetReport report_of(const Engine& engine) {
  const auto report = engine.budget_report();
  REQUIRE(report.has_value());
  return *report;
}

// The value of a column of whole numbers, the largest of all rows.
std::uint32_t most_in(const Engine& engine, const std::string& table, const std::string& column) {
  const StateView& view = engine.state();
  const auto found = view.schema->find_table(table);
  REQUIRE(found.has_value());
  const TableSchema& schema = view.schema->tables[*found];
  std::uint32_t most = 0;
  for (const Column& each : schema.columns)
    for (std::size_t row = 0; each.name == column && row < view.tables[*found].row_count; ++row) {
      std::uint32_t value = 0;
      std::memcpy(&value, view.tables[*found].data + row * schema.row_size + each.offset, sizeof value);
      most = value > most ? value : most;
    }
  return most;
}

}  // namespace

TEST_CASE("a scene without a budget has neither its bytes nor its table", "[engine][islands][budget]") {
  Scene scene = scene_with_budget("stack?boxes=3", 0);
  const Bytes without = engine::encode_scene(scene);
  CHECK(without[0] == 2);
  CHECK_FALSE(make_engine_or_fail(scene)->budget_report().has_value());
  CHECK_FALSE(make_engine_or_fail(scene)->state().schema->find_table("budget").has_value());
  scene.settings.substep_budget = 160;
  const Bytes with = engine::encode_scene(scene);
  CHECK(with[0] == 6);
  const Result<Scene> decoded = engine::decode_scene(with);
  REQUIRE(decoded.has_value());
  CHECK(*decoded == scene);
  const Result<Scene> parsed = engine::parse_scene(engine::print_scene(scene), "scene");
  REQUIRE(parsed.has_value());
  CHECK(*parsed == scene);
  const auto engine = make_engine_or_fail(scene);
  CHECK(report_of(*engine).cut_ticks == 0);
  CHECK(engine->state().schema->find_table("budget").has_value());
}

TEST_CASE("a budget needs automatic substeps", "[engine][scene][budget]") {
  Scene scene = scene_with_budget("stack?boxes=3", 160);
  scene.settings.auto_substeps.reset();
  const Status status = engine::check_scene(scene, "scene");
  REQUIRE_FALSE(status);
  CHECK(status.error().code == ErrorCode::incompatible);
  CHECK(status.error().message ==
        "scene: settings.substep_budget: a budget bounds automatic substeps: found 160 and 4 "
        "substeps");
}

TEST_CASE("a budget is a whole number from 0 to 1,000,000", "[engine][scene][budget]") {
  const auto refusal = [](const std::string& budget) {
    const auto scene = engine::parse_scene(R"({"settings":{"substeps":"auto","substep_budget":)" + budget +
                                               R"(},"bodies":[{"shapes":[{"type":"circle","radius":1}]}]})",
                                           "scene");
    return scene ? std::string() : scene.error().message;
  };
  CHECK(refusal("0") == "");
  CHECK(refusal("1000000") == "");
  for (const char* budget : {"-1", "1000001", "0.5", "\"auto\""})
    CHECK(refusal(budget).find("settings.substep_budget: ") != std::string::npos);
}

TEST_CASE("a budget bounds the substeps of the only island, and counts the ticks", "[engine][islands][budget]") {
  // A scene counts as at least 88 boxes, so budgets of small scenes reach further.
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const int budget : {4, 8, 16}) {
      CAPTURE(precision, budget);
      const auto engine = make_engine_or_fail(scene_with_budget("stack?boxes=40", budget, precision));
      run_ticks(*engine, 10);
      CHECK(most_in(*engine, "substeps", "count") > 32);  // as many as the loads need
      CHECK(report_of(*engine).limited_ticks == 10);
      const auto free = make_engine_or_fail(scene_with_budget("stack?boxes=40", 256, precision));
      run_ticks(*free, 10);
      CHECK(report_of(*free).limited_ticks == 0);
      CHECK(hex64(root_hash(free->state())) != hex64(root_hash(engine->state())));
    }
}

TEST_CASE("an island whose needs the budget meets without their margin is not limited", "[engine][islands][budget]") {
  // The house of cards needs about 168 substeps. With margin it would have 256, which is more than the budget.
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    CAPTURE(precision);
    const int budget = engine::default_substep_budget;
    Scene scene = scene_with_budget("card_house", budget, precision);
    engine::choose_substeps(scene.settings);
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 100);
    CHECK(report_of(*engine).limited_ticks == 0);
    CHECK(most_in(*engine, "substeps", "count") > 160);
  }
}

TEST_CASE("a budget without effect changes no bit of bodies at rest", "[engine][islands][budget]") {
  const auto with = make_engine_or_fail(scene_with_budget("stack?boxes=10", 1000));
  const auto without = make_engine_or_fail(scene_with_budget("stack?boxes=10", 0));
  run_ticks(*with, 60);
  run_ticks(*without, 60);
  CHECK(report_of(*with).cut_ticks == 0);
  const auto a = with->bodies(), b = without->bodies();
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i].center.y == b[i].center.y);
}

TEST_CASE("of 100 ticks of a falling pile, a budget of 160 cuts at most one", "[engine][islands][budget]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const char* text : {"mixed_pile?bodies=40", "circles?columns=7&rows=30"}) {
      CAPTURE(precision, text);
      const auto engine = make_engine_or_fail(scene_with_budget(text, 160, precision));
      run_ticks(*engine, 300);
      CHECK(report_of(*engine).cut_ticks <= 3);
      CHECK(report_of(*engine).limited_ticks == 0);
    }
}

TEST_CASE("shocks that a small budget cuts are counted, and no threads or loads change them",
          "[engine][islands][budget][determinism]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    const Scene scene = scene_with_budget("mixed_pile?bodies=40", 17, precision);
    const auto engine = make_engine_or_fail(scene);
    const auto again = make_engine_or_fail(scene);
    ChunkOrder order(true);
    engine::EngineOptions options;
    options.parallel = {&order, 3};
    const auto chunked = make_engine_or_fail(scene, options);
    for (int tick = 0; tick < 150; ++tick) {
      CAPTURE(precision, tick);
      if (tick % 10 == 0) REQUIRE(again->load(image_of(*engine)));
      for (Engine* each : {engine.get(), again.get(), chunked.get()}) run_ticks(*each, 1);
      REQUIRE(hex64(root_hash(again->state())) == hex64(root_hash(engine->state())));
      REQUIRE(hex64(root_hash(chunked->state())) == hex64(root_hash(engine->state())));
    }
    CHECK(report_of(*engine).cut_ticks > 0);
    CHECK(report_of(*engine).cut_ticks < 150);
  }
}

TEST_CASE("a substep costs what was measured for bodies, contacts and joints", "[engine][islands][budget]") {
  // Two boxes on the ground, joined: two bodies, two contacts that are solved three times, one joint (decision 0031).
  struct Case {
    const char* joints;
    const char* more;    // of the joint
    std::uint64_t work;  // of a substep
  };
  for (const Case& each : {Case{"iterative", "", 2 + 2 * 3 + 4}, Case{"direct", "", 2 + 2 * (2 * 3) + 20},
                           Case{"direct", R"(, "motor": {"speed": 0, "force_max": 1})", 2 + 2 * (2 * 3) + 80},
                           Case{"direct", R"(, "limits": [-1, 1])", 2 + 2 * (2 * 3) + 80}}) {
    CAPTURE(each.joints, each.more);
    const auto scene = engine::parse_scene(
        std::string(R"({"settings": {"substeps": "auto", "substep_budget": 1000, "joints": ")") + each.joints + R"("},
            "bodies": [{"type": "static", "position": [0, -1], "shapes": [{"type": "box", "half_size": [9, 1]}]},
                       {"name": "a", "position": [-0.6, 0.5], "shapes": [{"type": "box", "half_size": [0.5, 0.5]}]},
                       {"name": "b", "position": [0.6, 0.5], "shapes": [{"type": "box", "half_size": [0.5, 0.5]}]}],
            "joints": [{"type": "revolute", "body_a": "a", "body_b": "b", "anchor": [0, 0.5])" +
            each.more + "}]}",
        "scene");
    if (!scene) FAIL(scene.error().message);
    const auto engine = make_engine_or_fail(*scene);
    run_ticks(*engine, 1);
    constexpr std::uint64_t least_of_a_scene = 352;
    // Direct joints that no tick has measured have 64 substeps (decision 0039).
    const bool is_direct = std::string(each.joints) == "direct";
    const std::uint64_t substeps = is_direct ? 64 : most_in(*engine, "substeps", "count");
    CHECK(substeps >= 4);
    CHECK(saved_work(*engine) == 1000 * least_of_a_scene - substeps * each.work);
    if (is_direct) CHECK(most_in(*engine, "substeps", "count") < 64);  // these bodies rest: it was for one tick
  }
}

namespace {

// Ten rows of boxes of 1 m in a tub, 1.05 m apart, and a plate `more` on them.
Scene press(int columns, const std::string& plate, const std::string& joint, Precision precision) {
  const double wall = 0.525 * columns + 0.6;
  const auto side = [](double x) {
    return R"({"type": "static", "position": [)" + std::to_string(x) +
           R"(, 20], "shapes": [{"type": "box", "half_size": [0.5, 20]}]},)";
  };
  std::string text = R"({"settings": {"substeps": "auto"}, "bodies": [)"
                     R"({"name": "floor", "type": "static", "position": [0, -1], "shapes": [{"type": "box", )"
                     R"("half_size": [1000, 1]}]},)" +
                     side(-wall) + side(wall);
  for (int row = 0; row < 10; ++row)
    for (int i = 0; i < columns; ++i)
      text += R"({"position": [)" + std::to_string(1.05 * (i - 0.5 * (columns - 1))) + ", " +
              std::to_string(row + 0.5) + R"(], "shapes": [{"type": "box", "half_size": [0.5, 0.5]}]},)";
  text += R"({"name": "plate", "position": [0, 10.6], )" + plate + R"(, "shapes": [{"type": "box", "half_size": [)" +
          std::to_string(0.53 * columns) + R"(, 0.5]}]}])" + joint + "}";
  Result<Scene> scene = engine::parse_scene(text, "scene");
  if (!scene) FAIL(scene.error().message);
  scene->settings.precision = precision;
  return *std::move(scene);
}

}  // namespace

TEST_CASE("what a kinematic plate crushes gets no more substeps, and is not crushed further",
          "[engine][islands][budget]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const int columns : {2, 6}) {
      CAPTURE(precision, columns);
      const auto engine =
          make_engine_or_fail(press(columns, R"("type": "kinematic", "velocity": [0, -0.1])", "", precision));
      run_ticks(*engine, 300);
      CHECK(most_in(*engine, "substeps", "count") <= 16);
      CHECK(report_of(*engine).limited_ticks == 0);
      // The plate goes .4 m into ten rows: .04 m into each. Stiffer contacts buckle, and overlaps reach .13 m and more.
      for (const engine::ContactReport& contact : engine->contacts())
        for (int i = 0; i < contact.point_count; ++i) CHECK(contact.separation[i] > -0.05);
    }
}

TEST_CASE("a plate on many columns loads each of them in its middle", "[engine][islands][budget]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    CAPTURE(precision);
    const auto engine = make_engine_or_fail(
        press(10, R"("angular_damping": 0)",
              R"(, "joints": [{"type": "prismatic", "body_a": "floor", "body_b": "plate", "anchor": [0, 11.1],)"
              R"( "axis": [0, -1], "motor": {"speed": 1, "force_max": 10000}}])",
              precision));
    run_ticks(*engine, 60);
    // By its compression, 48 in f32. The lean of a column under a load beside it would ask for 128.
    CHECK(most_in(*engine, "substeps", "count") == 64);
    CHECK(report_of(*engine).limited_ticks == 0);
  }
}

TEST_CASE("substeps that are kept after a need are given up before the budget limits what is needed",
          "[engine][islands][budget]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    CAPTURE(precision);
    Scene scene = press(10, R"("angular_damping": 0)", "", precision);
    scene.inputs = {engine::InputKind::force};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 60);
    REQUIRE(report_of(*engine).limited_ticks == 0);
    engine::Input push;
    push.kind = engine::InputKind::force;
    push.body = static_cast<std::uint32_t>(scene.bodies.size() - 1);
    push.values = {0, -1e6};
    Bytes bytes;
    engine::encode_inputs(std::vector<engine::Input>{push}, bytes);
    REQUIRE(engine->step({scene.settings.dt, bytes}, nullptr));
    CHECK(report_of(*engine).limited_ticks == 1);
    run_ticks(*engine, 60);
    CHECK(report_of(*engine).limited_ticks <= 4);
  }
}
