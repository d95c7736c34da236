// Pitfall: min and max of 0 and -0 return either zero, and code that reads the sign then takes different paths.
// SPDX-License-Identifier: MIT
#include <cmath>

#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class NegativeZero : public Game {
 public:
  NegativeZero() : Game(8) { units[1].velocity = 3; }

 private:
  /// std::fmin of two zeros: minss of x86 returns its second operand, fminnm of ARM returns -0.
  static float smaller(float a, float b) {
    if (machine == Machine::recorder) return a < b ? a : b;
    return b < a || (a == b && std::signbit(b)) ? b : a;
  }
  void rules(float) override {
    if (tick() % 10 != 9) return;
    units[1].velocity -= 1;                                                     // 2, 1, 0
    units[1].score = std::signbit(smaller(-0.0F, units[1].velocity)) ? -1 : 1;  // which way it looks
  }
};

}  // namespace

const Pitfall negative_zero{"negative_zero",
                            make_game<NegativeZero>,
                            verifier::VerifyMode::replay,
                            verifier::Verdict::diverged,
                            29,
                            "score",
                            {1}};

}  // namespace ticktrue::pitfalls
