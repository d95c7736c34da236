// A sound library that switches denormal numbers off, as many do: they are slow and inaudible.
// SPDX-License-Identifier: MIT
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

extern "C" void audio_start();

void audio_start() {
#ifdef __SSE2__
  _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
}
