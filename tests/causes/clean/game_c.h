// The frame of the clean programs in C: eight units, whose whole state is recorded or verified.
// SPDX-License-Identifier: MIT
#pragma once

#include <stdint.h>

#include "include/ticktrue.h"

enum { unit_count = 8, tick_count = 60 };

struct unit {
  int64_t position;
  int64_t score;
};

/// Opens a session, runs the rules once per tick and returns the exit code.
static int play(const char* name, int argc, char** argv, void (*rules)(struct unit* units, uint64_t tick)) {
  ticktrue_options options = {0};
  options.struct_size = sizeof options;
  options.name = name;
  options.version = 1;
  options.detail = TICKTRUE_DETAIL_FULL;
  ticktrue_session* session = ticktrue_open_arguments(&options, argc, argv);
  struct unit units[unit_count] = {{0, 0}};
  ticktrue_column(session, "units", "position", &units->position, TICKTRUE_I64, 1, unit_count, sizeof *units);
  ticktrue_column(session, "units", "score", &units->score, TICKTRUE_I64, 1, unit_count, sizeof *units);
  for (uint64_t tick = 0; tick < tick_count; ++tick) {
    if (ticktrue_begin_tick(session, 0) != TICKTRUE_OK) break;
    rules(units, tick);
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
  }
  return ticktrue_close(session);
}
