// A lockstep game for two in C: recorded, verified by itself, and broken on purpose to see what is told.
// SPDX-License-Identifier: MIT
//
//   ./lockstep --record game.ttr              plays 600 ticks and records them
//   ./lockstep --verify game.ttr              plays the recorded inputs again and compares every tick
//   ./lockstep --verify game.ttr --bug order  the same with a determinism bug: order, clock, padding or pointer
//
// Lines that begin with `t:` in the margin are all that ticktrue needs.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "ticktrue.h"

enum { player_count = 2, ball_count = 6, tick_count = 600 };

typedef struct Input {
  uint8_t buttons[player_count]; /* bit 0 left, bit 1 right, bit 2 kick */
} Input;

typedef struct Ball {
  uint8_t owner; /* three bytes of padding follow */
  float position[2];
  float velocity[2];
  struct Ball* last_hit;
} Ball;

typedef struct Game {
  float paddle[player_count];
  int32_t score[player_count];
  uint32_t random; /* the generator's state is state */
  Ball balls[ball_count];
} Game;

static uint32_t next_random(Game* game) {
  return game->random = game->random * 1664525u + 1013904223u;
}

static void begin_game(Game* game, uint32_t seed) {
  memset(game, 0, sizeof *game);
  game->random = seed;
  for (int i = 0; i < ball_count; ++i) {
    Ball* ball = &game->balls[i];
    ball->owner = (uint8_t)(i % player_count);
    ball->position[1] = 1.0f + (float)i;
    ball->velocity[0] = (float)(next_random(game) >> 24) / 64.0f - 2.0f;
  }
}

/* Where the balls are on average. The bug `order`: the sum in another order, as an unordered container may give it. */
static float centre_of(const Game* game, const char* bug) {
  float sum = 0;
  for (int i = 0; i < ball_count; ++i)
    sum += game->balls[strcmp(bug, "order") == 0 ? ball_count - 1 - i : i].position[0];
  return sum / ball_count;
}

static void step_game(Game* game, const Input* input, float dt, const char* bug) {
  for (int p = 0; p < player_count; ++p) {
    const int direction = ((input->buttons[p] >> 1) & 1) - (input->buttons[p] & 1);
    game->paddle[p] += 3.0f * dt * (float)direction;
  }
  const float centre = centre_of(game, bug);
  for (int i = 0; i < ball_count; ++i) {
    Ball* ball = &game->balls[i];
    ball->velocity[0] -= 0.015625f * dt * centre; /* a breeze towards the middle */
    ball->velocity[1] -= 9.8125f * dt;
    for (int lane = 0; lane < 2; ++lane) ball->position[lane] += ball->velocity[lane] * dt;
    if (ball->position[1] > 0) continue;
    ball->position[1] = -ball->position[1];
    ball->velocity[1] = -0.875f * ball->velocity[1];
    if (input->buttons[ball->owner] & 4) ball->velocity[1] += 2.0f;
    ball->velocity[0] += 0.25f * (game->paddle[ball->owner] - ball->position[0]);
    game->score[ball->owner] += 1 + (int32_t)(next_random(game) >> 31);
    ball->last_hit = &game->balls[(i + 1) % ball_count];
    if (strcmp(bug, "clock") == 0 && i == 3) ball->velocity[0] += (float)(clock() % 100 + 1) * 1e-4f;
  }
}

/* What a person at the keyboard would do. */
static Input read_input(uint64_t tick) {
  Input input;
  for (int p = 0; p < player_count; ++p)
    input.buttons[p] = (uint8_t)((tick / 20 + (uint64_t)p * 3) * 2654435761u >> 29);
  return input;
}

static void register_state(ticktrue_session* session, Game* game, const char* bug) {
  Ball* balls = game->balls;
  ticktrue_column(session, "players", "paddle", game->paddle, TICKTRUE_F32, 1, player_count, 0);              /* t: */
  ticktrue_column(session, "players", "score", game->score, TICKTRUE_I32, 1, player_count, 0);                /* t: */
  ticktrue_column(session, "random", "state", &game->random, TICKTRUE_U32, 1, 1, 0);                          /* t: */
  ticktrue_column(session, "balls", "owner", &balls->owner, TICKTRUE_U8, 1, ball_count, sizeof *balls);       /* t: */
  ticktrue_column(session, "balls", "position", balls->position, TICKTRUE_F32, 2, ball_count, sizeof *balls); /* t: */
  ticktrue_column(session, "balls", "velocity", balls->velocity, TICKTRUE_F32, 2, ball_count, sizeof *balls); /* t: */
  if (strcmp(bug, "pointer") == 0) /* wrong: an address is another one in every run */
    ticktrue_column(session, "balls", "last_hit", &balls->last_hit, TICKTRUE_U64, 1, ball_count, sizeof *balls);
  if (strcmp(bug, "padding") == 0) /* wrong: the bytes between owner and position belong to nobody */
    ticktrue_column(session, "balls", "padding", &balls->owner + 1, TICKTRUE_U8, 3, ball_count, sizeof *balls);
}

static int is_bug(const char* name) {
  return !strcmp(name, "order") || !strcmp(name, "clock") || !strcmp(name, "padding") || !strcmp(name, "pointer");
}

int main(int argc, char** argv) {
  const char* bug = "";
  for (int i = 1; i + 1 < argc; ++i)
    if (strcmp(argv[i], "--bug") == 0) bug = argv[i + 1];
  if (*bug && !is_bug(bug)) {
    fprintf(stderr, "lockstep: --bug: found %s, expected order, clock, padding or pointer\n", bug);
    return 2;
  }

  uint32_t seed = 42;
  ticktrue_options options = {0};                                              /* t: */
  options.struct_size = sizeof options;                                        /* t: */
  options.name = "lockstep-example";                                           /* t: */
  options.version = 1;                                                         /* t: */
  options.caller_facts = TICKTRUE_CALLER_FACTS; /* told in reports */          /* t: */
  options.setup = &seed;                                                       /* t: */
  options.setup_size = sizeof seed;                                            /* t: */
  options.detail = TICKTRUE_DETAIL_FULL; /* a small game: values in reports */ /* t: */
  ticktrue_session* session = ticktrue_open_arguments(&options, argc, argv);   /* t: */
  size_t size = 0;                                                             /* t: */
  const void* setup = ticktrue_setup(session, &size);                          /* t: */
  if (setup != NULL && size == sizeof seed) memcpy(&seed, setup, size);        /* t: */

  Game* game = malloc(sizeof *game);
  begin_game(game, seed);
  uintptr_t left_behind = (uintptr_t)game >> 12; /* what a used piece of memory may hold */
  if (strcmp(bug, "padding") == 0)
    for (int i = 0; i < ball_count; ++i) memcpy(&game->balls[i].owner + 1, &left_behind, 3);
  register_state(session, game, bug); /* t: */

  double dt = 1.0 / 60;
  for (uint64_t tick = 0; tick < tick_count; ++tick) {
    Input input = read_input(tick);
    ticktrue_input(session, &input, sizeof input);               /* t: verify: the recorded ones */
    if (ticktrue_begin_tick(session, &dt) != TICKTRUE_OK) break; /* t: */
    step_game(game, &input, (float)dt, bug);
    ticktrue_end_tick(session); /* t: */
  }
  printf("score %d : %d\n", (int)game->score[0], (int)game->score[1]);
  free(game);
  return ticktrue_close(session); /* t: prints the report */
}
