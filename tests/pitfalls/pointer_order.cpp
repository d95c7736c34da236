// Pitfall: a set of pointers is ordered by address, and the heap of the next run gives other addresses.
// SPDX-License-Identifier: MIT
#include <array>
#include <set>

#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class PointerOrder : public Game {
 public:
  PointerOrder() : Game(8) { units[1].position = 1.6F; }

 private:
  struct Runner {
    std::uint32_t unit = 0;
  };
  /// The result of `new Runner` on two heaps: one returns rising addresses, one returns falling addresses.
  Runner* place_of(std::uint32_t unit) { return &heap_[machine == Machine::recorder ? unit : 7 - unit]; }

  void rules(float) override {
    std::set<Runner*> arrived;
    for (const Unit& unit : units) {
      Runner* runner = place_of(unit.id);
      runner->unit = unit.id;
      if (unit.position < 1) arrived.insert(runner);
    }
    if (!arrived.empty()) ++units[(*arrived.begin())->unit].score;  // the prize goes to the "first"
  }
  std::array<Runner, 8> heap_{};
};

}  // namespace

const Pitfall pointer_order{
    "pointer_order", make_game<PointerOrder>, verifier::VerifyMode::replay, verifier::Verdict::diverged, 34, "score",
    {0, 1}};

}  // namespace ticktrue::pitfalls
