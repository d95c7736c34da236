// Pitfall: a rule reads the time of day instead of the length of the tick.
// SPDX-License-Identifier: MIT
#include <chrono>

#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class WallClock : public Game {
 public:
  WallClock() : Game(8) {}

 private:
  void rules(float) override {
    if (tick() != 10) return;
    const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
    units[3].score = static_cast<std::int32_t>(now & 0x7fffffff);  // when the shield runs out
  }
};

}  // namespace

const Pitfall wall_clock{
    "wall_clock", make_game<WallClock>, verifier::VerifyMode::replay, verifier::Verdict::not_reproducible, 10, "score",
    {3}};

}  // namespace ticktrue::pitfalls
