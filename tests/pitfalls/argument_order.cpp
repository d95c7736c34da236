// Pitfall: two calls with side effects are arguments of one call; each compiler chooses which comes first.
// SPDX-License-Identifier: MIT
#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class ArgumentOrder : public Game {
 public:
  ArgumentOrder() : Game(8) {}

 private:
  /// The seed is part of the saved state: it is the score of unit 0.
  int random() { return units[0].score = (units[0].score * 5 + 3) % 64; }
  void jump(int up, int forward) { units[5].velocity = static_cast<float>(2 * up + forward); }

  void rules(float) override {
    if (tick() != 20) return;
    // jump(random(), random()): clang calls from left to right, g++ from right to left.
    const int first = random();
    const int second = random();
    machine == Machine::recorder ? jump(first, second) : jump(second, first);
  }
};

}  // namespace

const Pitfall argument_order{"argument_order",
                             make_game<ArgumentOrder>,
                             verifier::VerifyMode::replay,
                             verifier::Verdict::diverged,
                             20,
                             "velocity",
                             {5}};

}  // namespace ticktrue::pitfalls
