// Cause: a sound library flushes denormal numbers to zero, for the whole thread that loads it.
// SPDX-License-Identifier: MIT
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "tests/causes/game.h"

extern "C" void audio_start();

namespace {

void set_own_floats() {
#ifdef __SSE2__
  _mm_setcsr(0x1f80);  // the default of a new process
#endif
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (is_mended) set_own_floats();
  double& speed = game.units[5].velocity;
  if (tick == 0) speed = 1e-300;
  speed *= 0.25;
}

}  // namespace

int main(int argc, char** argv) {
  audio_start();
  return gallery::play("library_flush", argc, argv, rules);
}
