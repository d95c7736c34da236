// Pitfall: a processor mode flushes subnormal numbers to zero; a library or -ffast-math sets the mode at start.
// SPDX-License-Identifier: MIT
#include <cfloat>

#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class FlushToZero : public Game {
 public:
  FlushToZero() : Game(8) { units[6].velocity = 1e-30F; }

 private:
  /// A result after some code has set FTZ. NEON code of 32-bit ARM always behaves in this way.
  static float flushed(float value) {
    const bool is_subnormal = value < FLT_MIN && value > -FLT_MIN;
    return machine == Machine::other && is_subnormal ? 0.0F : value;
  }
  void rules(float) override { units[6].velocity = flushed(0.5F * units[6].velocity); }  // drag
};

}  // namespace

const Pitfall flush_to_zero{"flush_to_zero",
                            make_game<FlushToZero>,
                            verifier::VerifyMode::replay,
                            verifier::Verdict::diverged,
                            26,
                            "velocity",
                            {6}};

}  // namespace ticktrue::pitfalls
