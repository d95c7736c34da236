// A tick of a settled scene allocates nothing: operator new is counted while the tick runs.
// SPDX-License-Identifier: MIT
//
// Not counted: memory of decoded inputs, which is allocated by design.
// Not run with sanitizers, which replace operator new.
#include <atomic>
#include <cstdlib>
#include <new>

#include "base/build_info.h"
#include "base/parallel/chunk_order.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"

#ifndef __SANITIZE_ADDRESS__

namespace {

std::atomic<std::size_t> allocation_count{0};

void* counted(std::size_t size) {
  ++allocation_count;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void* counted(std::size_t size, std::size_t alignment) {
  ++allocation_count;
  if (void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) {
  return counted(size);
}
void* operator new[](std::size_t size) {
  return counted(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace ticktrue::test {
namespace {

void check_settled(const engine::Scene& scene, const engine::EngineOptions& options) {
  const auto engine = make_engine_or_fail(scene, options);
  const TickInput input{scene.settings.dt, {}};
  // Enough ticks to reach the largest memory use of this scene.
  for (int tick = 0; tick < 600; ++tick) REQUIRE(engine->step(input, nullptr));
  const std::size_t before = allocation_count;
  bool did = true;
  for (int tick = 0; tick < 20; ++tick) did = engine->step(input, nullptr) && did;
  const std::size_t allocated = allocation_count - before;
  CHECK(did);
  CHECK(allocated == 0);
}

}  // namespace

TEST_CASE("a tick of a settled scene allocates nothing", "[engine][allocation]") {
  {
    const std::size_t before = allocation_count;
    const std::vector<int> seen(100);
    REQUIRE(seen.size() + allocation_count - before == 101);  // the counter works
  }
  for (const char* text : {"stack",
                           "pyramid?base=10",
                           "pyramid?base=10&sleep=1",
                           "pyramid?base=10&substeps=auto",
                           "mixed_pile?bodies=60",
                           "mixed_pile?bodies=60&broad_phase=sweep_and_prune",
                           "mixed_pile?bodies=60&broad_phase=uniform_grid",
                           "shapes?bodies=30",
                           "circles?columns=6&rows=4&locate_impacts=1",
                           "bridge",
                           "chain",
                           "bridge?joints=direct",
                           "chain?joints=direct&integrator=velocity_verlet",
                           "joint_grid?columns=8",
                           "projectile",
                           "slide",
                           "sensors",
                           "stack?solver=pgs",
                           "stack?solver=impulse",
                           "stack?precision=f64",
                           "stack?integrator=rk4",
                           "stack?integrator=velocity_verlet",
                           "tumbler?columns=5"}) {
    auto scene = engine::make_builtin_scene(text);
    REQUIRE(scene.has_value());
    CAPTURE(text);
    check_settled(*scene, {});
    // Small chunks, as on several threads, so that even these small scenes have several.
    ChunkOrder order(false);
    engine::EngineOptions in_chunks;
    in_chunks.parallel = {&order, 8};
    check_settled(*scene, in_chunks);
  }
}

TEST_CASE("a tick on several threads allocates nothing", "[engine][allocation][threads]") {
  SKIP_UNLESS(build_info().has_threads, "a build without threads");
  const auto scene = engine::make_builtin_scene("pyramid?base=20");
  REQUIRE(scene.has_value());
  for (const unsigned thread_count : {2u, 4u}) {
    engine::EngineOptions options;
    options.thread_count = thread_count;
    CAPTURE(thread_count);
    check_settled(*scene, options);
  }
}

}  // namespace ticktrue::test

#endif
