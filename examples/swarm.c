// A swarm whose rules need sine, arc tangent, powers, random numbers and sorting: all of them from ticktrue/math.h.
// SPDX-License-Identifier: MIT
//
//   ./swarm --record swarm.ttr   plays 600 ticks and records them
//   ./swarm --verify swarm.ttr   plays them again and compares every tick
//
// The recording also verifies where the program is built with fused multiply-add. The game itself adds only products
// with powers of two, which are exact. Products inside of ticktrue/math.h cannot be fused.
#include <stdio.h>
#include <string.h>
#include <ticktrue.h>
#include <ticktrue/math.h>

enum { unit_count = 64, tick_count = 600 };

typedef struct Unit {
  float position[2];
  float heading;
  double energy;
} Unit;

static Unit units[unit_count];
static ticktrue_random generator;

static int by_energy(const void* a, const void* b, void* user) {
  (void)user;
  return ticktrue_total_order(((const Unit*)a)->energy, ((const Unit*)b)->energy);
}

static void begin_game(void) {
  generator = ticktrue_random_seeded(42, 0);
  for (int i = 0; i < unit_count; ++i) {
    units[i].position[0] = ticktrue_random_float(&generator);
    units[i].position[1] = ticktrue_random_float(&generator);
    units[i].heading = (float)ticktrue_random_between(&generator, -3, 3);
    units[i].energy = 1 + ticktrue_random_double(&generator);
  }
}

static void step_game(float dt) {
  static Unit buffer[unit_count];
  const Unit* leader = &units[ticktrue_random_below(&generator, unit_count)];
  const float goal[2] = {leader->position[0], leader->position[1]};
  for (int i = 0; i < unit_count; ++i) {
    Unit* unit = &units[i];
    const float dx = goal[0] - unit->position[0], dy = goal[1] - unit->position[1];
    const float turn = ticktrue_atan2f(dy, dx) - unit->heading;
    const float way = ticktrue_fmodf(ticktrue_hypotf(dx, dy), 1.0f);
    unit->heading += ticktrue_sinf(turn) / 8;
    unit->position[0] += ticktrue_cosf(unit->heading) / 64;
    unit->position[1] += ticktrue_sinf(unit->heading) / 64;
    unit->energy = ticktrue_pow(unit->energy, 0.99) + ticktrue_exp(-(double)way) / 256;
    if (unit->energy > 2) unit->energy = ticktrue_log(unit->energy) + (double)dt;
  }
  ticktrue_sort(units, unit_count, sizeof(Unit), by_energy, NULL, buffer);
}

int main(int argc, char** argv) {
  ticktrue_options options;
  memset(&options, 0, sizeof options);
  options.struct_size = sizeof options;
  options.name = "swarm-example";
  options.version = 1;
  options.detail = TICKTRUE_DETAIL_FULL;
  ticktrue_session* session = ticktrue_open_arguments(&options, argc, argv);
  begin_game();
  ticktrue_column(session, "units", "position", units[0].position, TICKTRUE_F32, 2, unit_count, sizeof(Unit));
  ticktrue_column(session, "units", "heading", &units[0].heading, TICKTRUE_F32, 1, unit_count, sizeof(Unit));
  ticktrue_column(session, "units", "energy", &units[0].energy, TICKTRUE_F64, 1, unit_count, sizeof(Unit));
  ticktrue_column(session, "generator", "state", &generator.state, TICKTRUE_U64, 1, 1, 0);

  double dt = 1.0 / 60;
  for (int tick = 0; tick < tick_count; ++tick) {
    if (ticktrue_begin_tick(session, &dt) != TICKTRUE_OK) break;
    step_game((float)dt);
    ticktrue_end_tick(session);
  }
  printf("least energy %.17g\n", units[0].energy);
  return ticktrue_close(session);
}
