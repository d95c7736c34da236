// Results that are equal on every platform and under its emulator: refusal of wrong float settings, findings, loaded
// states.
// SPDX-License-Identifier: MIT
#include <cfenv>
#include <string>

#include "base/float_behaviour.h"
#include "base/hash.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "replay/recorder.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"

namespace ticktrue::test {
namespace {

// --- float settings -------------------------------------------------------------------------------------------------

/// Sets another rounding mode during its lifetime. `took` is false if the platform has only one mode.
class OtherRounding {
 public:
  explicit OtherRounding(int mode)
      : before_(std::fegetround()), took(std::fesetround(mode) == 0 && std::fegetround() == mode) {}
  ~OtherRounding() { std::fesetround(before_); }
  OtherRounding(const OtherRounding&) = delete;
  OtherRounding& operator=(const OtherRounding&) = delete;

 private:
  int before_;

 public:
  const bool took;
};

#if defined(__x86_64__) || defined(__SSE2__) || defined(__aarch64__) || defined(__arm__)
#define TICKTRUE_TEST_CAN_FLUSH
#endif

#ifdef TICKTRUE_TEST_CAN_FLUSH
#if defined(__aarch64__)
std::uint64_t control_word() {
  std::uint64_t word = 0;
  __asm__ volatile("mrs %0, fpcr" : "=r"(word));
  return word;
}
void set_control_word(std::uint64_t word) {
  __asm__ volatile("msr fpcr, %0" : : "r"(word) : "memory");
}
constexpr std::uint64_t flush_bits = 1u << 24;  // FZ
#elif defined(__arm__)
std::uint64_t control_word() {
  std::uint32_t word = 0;
  __asm__ volatile("vmrs %0, fpscr" : "=r"(word));
  return word;
}
void set_control_word(std::uint64_t word) {
  __asm__ volatile("vmsr fpscr, %0" : : "r"(static_cast<std::uint32_t>(word)) : "memory");
}
constexpr std::uint64_t flush_bits = 1u << 24;  // FZ
#else
std::uint64_t control_word() {
  return __builtin_ia32_stmxcsr();
}
void set_control_word(std::uint64_t word) {
  __builtin_ia32_ldmxcsr(static_cast<unsigned>(word));
}
constexpr std::uint64_t flush_bits = 1u << 15;  // FTZ
#endif

/// Flushes subnormal results to zero during its lifetime.
class Flushing {
 public:
  Flushing() : before_(control_word()) { set_control_word(before_ | flush_bits); }
  ~Flushing() { set_control_word(before_); }
  Flushing(const Flushing&) = delete;
  Flushing& operator=(const Flushing&) = delete;

 private:
  std::uint64_t before_;
};
#endif

Status check_with_rounding(int mode, bool& took) {
  const OtherRounding other(mode);
  took = other.took;
  return check_float_behaviour();
}

}  // namespace

TEST_CASE("a thread with the defaults of IEEE 754 may simulate", "[portable][float_behaviour][determinism]") {
  const Status status = check_float_behaviour();
  INFO((status ? "" : status.error().message));
  CHECK(status.has_value());
}

TEST_CASE("another rounding mode is refused by name", "[portable][float_behaviour][determinism]") {
  struct Case {
    int mode;
    const char* words;
  };
  for (const Case& c : {
#ifdef FE_UPWARD
           Case{FE_UPWARD, "rounding upward"},
#endif
#ifdef FE_DOWNWARD
           Case{FE_DOWNWARD, "rounding downward"},
#endif
#ifdef FE_TOWARDZERO
           Case{FE_TOWARDZERO, "rounding toward_zero"},
#endif
           Case{FE_TONEAREST, ""}}) {
    bool took = false;
    const Status status = check_with_rounding(c.mode, took);
    CAPTURE(c.words);
    if (!took || c.words[0] == 0) {
      CHECK(status.has_value());
      continue;
    }
    REQUIRE_FALSE(status.has_value());
    CHECK(status.error().code == ErrorCode::unsupported);
    CHECK_THAT(status.error().message, Catch::Contains(c.words));
  }
}

TEST_CASE("each wrong behaviour is refused by name", "[portable][float_behaviour][determinism]") {
  const FloatBehaviour right{"nearest", false, false, false};
  CHECK(check_float_behaviour(right).has_value());
  const auto refusal = [](const FloatBehaviour& behaviour) {
    const Status status = check_float_behaviour(behaviour);
    return status ? std::string() : status.error().message;
  };
  CHECK_THAT(refusal({"upward", false, false, false}), Catch::Contains("rounding upward"));
  CHECK_THAT(refusal({"nearest", true, false, false}), Catch::Contains("subnormal results flushed"));
  CHECK_THAT(refusal({"nearest", false, true, false}), Catch::Contains("subnormal operands taken as zero"));
  CHECK_THAT(refusal({"nearest", false, false, true}), Catch::Contains("a * b + c rounded once"));
}

#ifdef TICKTRUE_TEST_CAN_FLUSH
TEST_CASE("flush-to-zero is seen, and nothing is recorded under it", "[portable][float_behaviour][determinism]") {
  const TemporaryFolder folder;
  ToySimulation toy(3);
  replay::NoInputs inputs(1.0 / 60);
  FloatBehaviour found;
  std::string message;
  {
    const Flushing flushing;
    found = probe_float_behaviour();
    const auto recorded = replay::record(toy, inputs, folder.file("flush.ttr"), full_toy_setup(3, 0, 0), toy_facts,
                                         {3, plain_writer(), {}});
    if (!recorded) message = recorded.error().message;
  }
  CHECK(found.flushes_to_zero);
  CHECK_THAT(message, Catch::Contains("subnormal results flushed to zero"));
  CHECK(check_float_behaviour().has_value());
}
#endif

// --- the engine -----------------------------------------------------------------------------------------------------

TEST_CASE("a state taken along in the middle of a run gives the same bits to its end",
          "[portable][restore][determinism]") {
  for (const char* text : {"mixed_pile?bodies=12&precision=f32", "mixed_pile?bodies=12&precision=f64",
                           "stack?boxes=4&solver=impulse&precision=f32"}) {
    CAPTURE(text);
    const auto scene = engine::make_builtin_scene(text);
    REQUIRE(scene.has_value());
    const auto original = engine::make_engine(*scene);
    const auto other = engine::make_engine(*scene, {false, engine::BroadPhaseKind::brute_force});
    REQUIRE(original.has_value());
    REQUIRE(other.has_value());
    const TickInput input{scene->settings.dt, {}};
    for (int tick = 0; tick < 60; ++tick) REQUIRE((*original)->step(input, nullptr));
    Bytes image;
    encode_image((*original)->state(), image);
    REQUIRE((*other)->load(image).has_value());
    for (int tick = 60; tick < 120; ++tick) {
      REQUIRE((*original)->step(input, nullptr));
      REQUIRE((*other)->step(input, nullptr));
      REQUIRE(root_hash((*other)->state()) == root_hash((*original)->state()));
    }
  }
}

}  // namespace ticktrue::test
