// Pitfall: a float too large for an int is converted to an int; C++ leaves the result undefined.
// SPDX-License-Identifier: MIT
#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class FloatToInt : public Game {
 public:
  FloatToInt() : Game(8) {}

 private:
  /// static_cast<int>(value): cvttss2si of x86 gives the smallest int, fcvtzs of ARM the nearest.
  static std::int32_t to_int(float value) {
    if (value < 2147483648.0F) return static_cast<std::int32_t>(value);
    return machine == Machine::recorder ? INT32_MIN : INT32_MAX;
  }
  void rules(float) override { units[3].score = to_int(1e8F * static_cast<float>(tick() + 1)); }
};

}  // namespace

const Pitfall float_to_int{
    "float_to_int", make_game<FloatToInt>, verifier::VerifyMode::replay, verifier::Verdict::diverged, 21, "score", {3}};

}  // namespace ticktrue::pitfalls
