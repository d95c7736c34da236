// Pitfall: the compiler fuses a product and a sum, which then round once instead of twice.
// SPDX-License-Identifier: MIT
#include <cmath>

#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class Contraction : public Game {
 public:
  Contraction() : Game(8) {}

 private:
  /// a * b + c: one instruction on ARM and on x86 with -march=native -ffp-contract=fast (the default of g++).
  static float product_and_sum(float a, float b, float c) {
    if (machine == Machine::other) return std::fma(a, b, c);
    const float product = a * b;
    return product + c;
  }
  void rules(float) override {
    if (tick() < 10) return;
    Unit& unit = units[4];
    unit.velocity = product_and_sum(-0.05F, unit.position, unit.velocity);  // a spring pulls it
  }
};

}  // namespace

const Pitfall contraction{"contraction",
                          make_game<Contraction>,
                          verifier::VerifyMode::replay,
                          verifier::Verdict::diverged,
                          16,
                          "velocity",
                          {4}};

}  // namespace ticktrue::pitfalls
