// Pitfall: sin of the platform's library, whose rounding differs between libraries.
// SPDX-License-Identifier: MIT
#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class Libm : public Game {
 public:
  Libm() : Game(8) {}

 private:
  /// sin of a small angle in two libraries: the same series, summed from either end.
  static float sine(float x) {
    const float s = x * x;
    if (machine == Machine::recorder) return x * (1 + s * (-1 / 6.0F + s * (1 / 120.0F + s * (-1 / 5040.0F))));
    return x - x * s / 6 + x * s * s / 120 - x * s * s * s / 5040;
  }
  void rules(float dt) override {
    if (tick() >= 15) units[2].velocity = sine(dt * static_cast<float>(tick()));  // it sways
  }
};

}  // namespace

const Pitfall libm{"libm", make_game<Libm>, verifier::VerifyMode::replay, verifier::Verdict::diverged, 16, "velocity",
                   {2}};

}  // namespace ticktrue::pitfalls
