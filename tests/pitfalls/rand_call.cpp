// Pitfall: rand() has its own state, which no trace holds and the whole process shares.
// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class RandCall : public Game {
 public:
  RandCall() : Game(8) {}

 private:
  void rules(float) override {
    if (tick() == 12) units[2].score = std::rand();  // how far the shot spreads
  }
};

}  // namespace

const Pitfall rand_call{
    "rand_call", make_game<RandCall>, verifier::VerifyMode::replay, verifier::Verdict::not_reproducible, 12, "score",
    {2}};

}  // namespace ticktrue::pitfalls
