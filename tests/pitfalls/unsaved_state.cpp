// Pitfall: a member that later ticks depend on is not part of the saved state.
// SPDX-License-Identifier: MIT
#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class UnsavedState : public Game {
 public:
  UnsavedState() : Game(8) {}

 private:
  void rules(float) override {
    if (cooldown_ > 0) --cooldown_;
    if (cooldown_ > 0) return;
    ++units[1].score;  // fires
    cooldown_ = 10;
  }
  int cooldown_ = 0;  // ticks; in no column
};

}  // namespace

// The checkpoint before tick 16 lacks the cooldown, so a simulation loaded from it fires at once.
const Pitfall unsaved_state{"unsaved_state",
                            make_game<UnsavedState>,
                            verifier::VerifyMode::restore,
                            verifier::Verdict::state_incomplete,
                            16,
                            "score",
                            {1}};

}  // namespace ticktrue::pitfalls
