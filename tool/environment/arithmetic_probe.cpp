// The parts of the probe and their digests.
// SPDX-License-Identifier: MIT
#include "tool/environment/arithmetic_probe.h"

#include <string>

#include "base/assert.h"
#include "base/bytes.h"
#include "base/hash.h"
#include "base/random.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "engine/math/exponential.h"
#include "engine/math/trig.h"
#include "engine/simd/probe.h"
#include "tool/environment/float_environment.h"

namespace ticktrue::tool {
namespace {

void probe_functions(ByteWriter& out) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const double angle = random.real(-1000, 1000);
    const double other = random.real(-1000, 1000);
    const engine::SinCos turn = engine::sin_cos(angle);
    out.f64(turn.sin);
    out.f64(turn.cos);
    out.f64(engine::arc_tangent(angle, other));
    const engine::Decay decay = engine::decay_over(angle < 0 ? -angle / 100 : angle / 100);
    out.f64(decay.factor);
    out.f64(decay.mean);
  }
}

/// What bodies of a lively scene are seen to do: not the columns of its state, so that a new column changes nothing
/// here.
void probe_scene(const std::string& precision, ByteWriter& out) {
  const auto scene = engine::make_builtin_scene("mixed_pile?bodies=9&substeps=4&precision=" + precision);
  TICKTRUE_ASSERT(scene.has_value());
  const auto made = engine::make_engine(*scene);
  TICKTRUE_ASSERT(made.has_value());
  engine::Engine& engine = **made;
  for (int tick = 0; tick < 120; ++tick)
    if (!engine.step({scene->settings.dt, {}}, nullptr)) return;  // the digest of nothing is not the expected one
  for (const engine::BodyReport& body : engine.bodies())
    for (const double value :
         {body.center.x, body.center.y, body.angle, body.velocity.x, body.velocity.y, body.angular_velocity})
      out.f64(value);
}

template <typename Function>
std::uint64_t digest_of(Function function) {
  ByteWriter out;
  function(out);
  return hash64(out.view());
}

// Those of the scenes change with the physics: `./dev golden update` says so and writes them again.
constexpr std::uint64_t functions_expected = 0x7427705cceb460e1u;
constexpr std::uint64_t arithmetic_f32_expected = 0xcce1f8098abfaf40u;
constexpr std::uint64_t arithmetic_f64_expected = 0x5d2764d655f87b41u;
constexpr std::uint64_t scene_f32_expected = 0x28aee73457da46c5u;
constexpr std::uint64_t scene_f64_expected = 0x43f8660424f13c3fu;

}  // namespace

std::vector<ProbePart> probe_arithmetic() {
  return {
      {"operations", "+ - * / square root, conversions, subnormals", probe_float_environment().digest,
       float_digest_expected},
      {"functions", "sine, cosine, arc tangent, decay", digest_of(probe_functions), functions_expected},
      {"arithmetic_f32", "rotations, roots, vector lanes in f32", digest_of(engine::f32::probe_arithmetic),
       arithmetic_f32_expected},
      {"arithmetic_f64", "rotations, roots, vector lanes in f64", digest_of(engine::f64::probe_arithmetic),
       arithmetic_f64_expected},
      {"scene_f32", "120 ticks of nine bodies in f32", digest_of([](ByteWriter& out) { probe_scene("f32", out); }),
       scene_f32_expected},
      {"scene_f64", "120 ticks of nine bodies in f64", digest_of([](ByteWriter& out) { probe_scene("f64", out); }),
       scene_f64_expected},
  };
}

}  // namespace ticktrue::tool
