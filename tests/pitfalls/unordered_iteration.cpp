// Pitfall: a float sum over an unordered_map, whose order depends on the standard library.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <unordered_map>

#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class UnorderedIteration : public Game {
 public:
  UnorderedIteration() : Game(8) {
    for (std::uint32_t i = 1; i < 4; ++i) units[i].position = 1.5F + 0.2F * static_cast<float>(i);
  }

 private:
  void rules(float) override {
    std::unordered_map<std::uint32_t, float> pulls;  // of units within range
    for (const Unit& unit : units)
      if (unit.position < 1.3F) pulls[unit.id] = 0.01F * unit.position;
    std::vector<float> in_order;
    for (const auto& [id, pull] : pulls) in_order.push_back(pull);
    // Another library stores the same elements in another order.
    if (machine == Machine::other) std::reverse(in_order.begin(), in_order.end());
    float sum = 0;
    for (const float pull : in_order) sum += pull;
    units[7].velocity = sum;
  }
};

}  // namespace

const Pitfall unordered_iteration{"unordered_iteration",
                                  make_game<UnorderedIteration>,
                                  verifier::VerifyMode::replay,
                                  verifier::Verdict::diverged,
                                  32,
                                  "velocity",
                                  {7}};

}  // namespace ticktrue::pitfalls
