// A session for MSVC's binary interface: 100 ticks recorded, verified, and verified with another value. No C library.
// SPDX-License-Identifier: MIT
#include "ticktrue.h"

__declspec(dllimport) void __stdcall ExitProcess(unsigned code);

/* What compilers call for themselves, in place of a C library. */
int _fltused = 1;

static int play(int32_t mode, double push) {
  double height = 1, speed = 0;
  ticktrue_options options;
  volatile unsigned char* bytes = (volatile unsigned char*)&options;
  for (size_t i = 0; i < sizeof options; ++i) bytes[i] = 0;
  options.struct_size = sizeof options;
  options.name = "msvc-session";
  options.version = 1;
  options.mode = mode;
  options.path = "msvc.ttr";
  options.flags = TICKTRUE_OVERWRITE;
  options.detail = TICKTRUE_DETAIL_FULL;
  options.caller_facts = TICKTRUE_CALLER_FACTS;
  ticktrue_session* session = ticktrue_open(&options);
  ticktrue_column(session, "ball", "height", &height, TICKTRUE_F64, 1, 1, 0);
  ticktrue_column(session, "ball", "speed", &speed, TICKTRUE_F64, 1, 1, 0);
  double dt = 0.015625;
  for (int tick = 0; tick < 100; ++tick) {
    if (ticktrue_begin_tick(session, &dt) != TICKTRUE_OK) break;
    speed -= 9.8125 * dt;
    height += speed * dt;
    if (tick == 50) height += push;
    ticktrue_end_tick(session);
  }
  return ticktrue_close(session);
}

void start(void) {
  const int recorded = play(TICKTRUE_RECORD, 0);
  const int green = play(TICKTRUE_VERIFY, 0);
  const int red = play(TICKTRUE_VERIFY, 0.125);
  ExitProcess(recorded == 0 && green == 0 && red == 1 ? 0 : 1);
}
