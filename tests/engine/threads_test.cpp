// Neither the number of threads nor the order of chunks changes a bit.
// SPDX-License-Identifier: MIT
//
// Verified: tick hashes of scenes with every solver, joint, shape and force. Chunks are so small that each loop has
// many. Sequential runs in other orders reliably find a dependence on the order. Runs on 2, 4 and 8 threads may find
// concurrent writes.
// Not verified: races that change no bit; -fsanitize=thread is run by hand (docs/decisions/0016-chunks.md).
#include "base/build_info.h"
#include "base/parallel/chunk_order.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"

namespace ticktrue::test {
namespace {

engine::EngineOptions in_order(ChunkOrder& order, std::size_t chunk_size) {
  engine::EngineOptions options;
  options.parallel = {&order, chunk_size};
  return options;
}

engine::EngineOptions on_threads(unsigned thread_count, std::size_t chunk_size) {
  engine::EngineOptions options;
  options.thread_count = thread_count;
  options.parallel.chunk_size_forced = chunk_size;
  return options;
}

Session builtin_session(const std::string& text) {
  Result<engine::Scene> scene = engine::make_builtin_scene(text);
  REQUIRE(scene.has_value());
  return {text, *std::move(scene), {}};
}

/// Scenes that use several threads without being forced to.
std::vector<Session> wide_sessions() {
  std::vector<Session> sessions;
  for (const char* text : {"pyramid?base=40", "mixed_pile?bodies=800", "joint_grid?columns=30", "tumbler?columns=20",
                           "pyramid?base=30&precision=f64", "pyramid?base=30&broad_phase=uniform_grid",
                           "gas?bodies=900", "many_pyramids?rows=4&columns=4"})
    sessions.push_back(builtin_session(text));
  Session island = builtin_session("pyramid?base=45");  // one island, with enough contacts for threads to build it
  island.name = "pyramid with sleep";
  island.scene.settings.sleep.emplace();
  sessions.push_back(island);
  return sessions;
}

}  // namespace

TEST_CASE("the order in which chunks are done changes no bit", "[engine][threads][determinism]") {
  constexpr std::uint64_t tick_count = 60;
  std::size_t run_count = 0;
  for (const Session& session : property_sessions()) {
    const std::vector<std::uint64_t> expected = tick_hashes(session, tick_count);
    for (const bool reversed : {false, true})
      for (const std::size_t chunk_size : {1, 3}) {
        ChunkOrder order(reversed);
        CAPTURE(session.name, reversed, chunk_size);
        CHECK(tick_hashes(session, tick_count, in_order(order, chunk_size)) == expected);
        run_count += order.run_count;
      }
  }
  CHECK(run_count > 100000);  // the runs used chunks
}

TEST_CASE("a long row of joints is solved in order, on any threads", "[engine][threads][joints][determinism]") {
  constexpr std::uint64_t tick_count = 40;
  for (const char* text : {"chain?links=40", "chain?links=40&precision=f64"}) {
    const Session session = builtin_session(text);
    const std::vector<std::uint64_t> expected = tick_hashes(session, tick_count);
    for (const std::size_t chunk_size : {1, 2}) {
      ChunkOrder order(true);
      CAPTURE(text, chunk_size);
      CHECK(tick_hashes(session, tick_count, in_order(order, chunk_size)) == expected);
      CHECK(order.run_count > 0);
    }
  }
}

TEST_CASE("golden scenes give the same in chunks out of order", "[engine][threads][golden]") {
  for (const GoldenSession& golden : golden_sessions()) {
    const std::uint64_t tick_count = golden.tick_count < 150 ? golden.tick_count : 150;
    const std::vector<std::uint64_t> expected = tick_hashes(golden.session, tick_count);
    ChunkOrder order(true);
    CAPTURE(golden.session.name);
    CHECK(tick_hashes(golden.session, tick_count, in_order(order, 2)) == expected);
  }
}

TEST_CASE("any number of threads gives the same bits", "[engine][threads][determinism]") {
  SKIP_UNLESS(build_info().has_threads, "a build without threads");
  constexpr std::uint64_t tick_count = 8;
  for (const Session& session : property_sessions()) {
    const std::vector<std::uint64_t> expected = tick_hashes(session, tick_count);
    for (const unsigned thread_count : {2u, 4u, 8u}) {
      CAPTURE(session.name, thread_count);
      CHECK(tick_hashes(session, tick_count, on_threads(thread_count, 2)) == expected);
    }
  }
}

TEST_CASE("large scenes give the same bits on threads and in any order", "[engine][threads][determinism]") {
  constexpr std::uint64_t tick_count = 25;
  for (const Session& session : wide_sessions()) {
    const std::vector<std::uint64_t> expected = tick_hashes(session, tick_count);
    CAPTURE(session.name);
    for (const bool reversed : {false, true}) {
      ChunkOrder order(reversed);
      CHECK(tick_hashes(session, tick_count, in_order(order, 0)) == expected);
      CHECK(order.run_count > tick_count);  // the work was shared
    }
    if (!build_info().has_threads) {
      WARN("skipped on threads: a build without threads");
      continue;
    }
    for (const unsigned thread_count : {2u, 4u}) {
      CAPTURE(thread_count);
      CHECK(tick_hashes(session, tick_count, on_threads(thread_count, 0)) == expected);
    }
  }
}

TEST_CASE("every golden scene gives the same bits with every number of threads", "[engine][threads][golden][.slow]") {
  for (const GoldenSession& golden : golden_sessions()) {
    const std::vector<std::uint64_t> expected = tick_hashes(golden.session, golden.tick_count);
    for (const unsigned thread_count : {2u, 4u, 8u})
      for (const std::size_t chunk_size : {0, 2}) {
        CAPTURE(golden.session.name, thread_count, chunk_size);
        CHECK(tick_hashes(golden.session, golden.tick_count, on_threads(thread_count, chunk_size)) == expected);
      }
  }
}

TEST_CASE("a small scene asks no other thread", "[engine][threads]") {
  for (const char* text : {"stack", "thesis", "bridge", "pyramid?base=5"}) {
    ChunkOrder order(false, 8);
    CAPTURE(text);
    tick_hashes(builtin_session(text), 60, in_order(order, 0));
    CHECK(order.run_count == 0);
  }
}

TEST_CASE("a run restored from an image goes on the same on threads", "[engine][threads][restore]") {
  const Session session = builtin_session("mixed_pile?bodies=200");
  ChunkOrder order(true);
  const auto original = make_engine_or_fail(session.scene);
  for (std::uint64_t tick = 0; tick < 40; ++tick) REQUIRE(original->step(input_of(session, tick), nullptr));
  const auto restored = make_engine_or_fail(session.scene, in_order(order, 3));
  REQUIRE(restored->load(image_of(*original)).has_value());
  for (std::uint64_t tick = 40; tick < 70; ++tick) {
    REQUIRE(original->step(input_of(session, tick), nullptr));
    REQUIRE(restored->step(input_of(session, tick), nullptr));
    CAPTURE(tick);
    REQUIRE(image_of(*restored) == image_of(*original));
  }
}

}  // namespace ticktrue::test
