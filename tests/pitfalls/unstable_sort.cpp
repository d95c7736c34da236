// Pitfall: std::sort may order equal keys in any way, and the order differs between libraries.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class UnstableSort : public Game {
 public:
  UnstableSort() : Game(8) {}

 private:
  static bool is_before(const Unit& a, const Unit& b) { return a.score > b.score; }

  void rules(float) override {
    if (tick() == 18) units[3].score = 5;  // until then all scores are equal, but no rule reads the order
    if (tick() != 19) return;
    std::vector<Unit> ranking = units;
    // std::sort(...): both branches keep its contract.
    if (machine == Machine::recorder) {
      std::stable_sort(ranking.begin(), ranking.end(), is_before);
    } else {
      std::make_heap(ranking.begin(), ranking.end(), is_before);
      std::sort_heap(ranking.begin(), ranking.end(), is_before);
    }
    units[ranking[1].id].score = 4;  // the second best
  }
};

}  // namespace

const Pitfall unstable_sort{
    "unstable_sort", make_game<UnstableSort>, verifier::VerifyMode::replay, verifier::Verdict::diverged, 19, "score",
    {0, 1}};

}  // namespace ticktrue::pitfalls
