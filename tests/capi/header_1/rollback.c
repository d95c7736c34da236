// A rollback loop in C: the other player's inputs arrive late, are guessed, and corrected by going back.
// SPDX-License-Identifier: MIT
//
//   ./rollback --record game.ttr                  plays 600 ticks over a bad line; only confirmed ticks are recorded
//   ./rollback --verify game.ttr                  plays the recorded inputs again, and goes back every few ticks
//   ./rollback --verify game.ttr --bug unsaved    going back forgets one field: verify names it
#include <stdio.h>
#include <string.h>

#include "ticktrue.h"

enum { tick_count = 600, delay_max = 7, history_count = 16 };

typedef struct Fighter {
  int32_t x, y, speed_y;
  uint32_t hits;
  uint32_t cooldown; /* ticks */
} Fighter;

typedef struct Game {
  uint64_t tick;
  Fighter fighters[2];
} Game;

static void step_game(Game* game, const uint8_t buttons[2]) {
  for (int i = 0; i < 2; ++i) {
    Fighter* f = &game->fighters[i];
    f->x += ((buttons[i] >> 1) & 1) * 40 - (buttons[i] & 1) * 40;
    if (f->y == 0 && (buttons[i] & 4)) f->speed_y = 300;
    f->y += f->speed_y;
    f->speed_y -= f->y > 0 ? 20 : f->speed_y;
    if (f->y < 0) f->y = 0;
    if (f->cooldown > 0) --f->cooldown;
    if ((buttons[i] & 8) && f->cooldown == 0) {
      ++game->fighters[1 - i].hits;
      f->cooldown = 12;
    }
  }
  ++game->tick;
}

static uint8_t buttons_of(uint64_t tick, int player) {
  return (uint8_t)((tick / 9 + (uint64_t)player * 5) * 2654435761u >> 28);
}

/* How many of the other player's inputs have arrived here when this tick begins. */
static uint64_t arrived_at(uint64_t tick) {
  const uint64_t delay = (tick * 2246822519u >> 20) % delay_max;
  return tick < delay ? 0 : tick - delay;
}

/* The other player's buttons where they have arrived, else a guess: as in the last tick that is known. */
static uint8_t remote_buttons(uint64_t tick, uint64_t arrived) {
  return tick < arrived ? buttons_of(tick, 1) : arrived > 0 ? buttons_of(arrived - 1, 1) : 0;
}

static void register_state(ticktrue_session* session, Game* game) {
  Fighter* f = game->fighters;
  ticktrue_column(session, "world", "tick", &game->tick, TICKTRUE_U64, 1, 1, 0);
  ticktrue_column(session, "fighters", "x", &f->x, TICKTRUE_I32, 1, 2, sizeof *f);
  ticktrue_column(session, "fighters", "y", &f->y, TICKTRUE_I32, 1, 2, sizeof *f);
  ticktrue_column(session, "fighters", "speed_y", &f->speed_y, TICKTRUE_I32, 1, 2, sizeof *f);
  ticktrue_column(session, "fighters", "hits", &f->hits, TICKTRUE_U32, 1, 2, sizeof *f);
  ticktrue_column(session, "fighters", "cooldown", &f->cooldown, TICKTRUE_U32, 1, 2, sizeof *f);
}

typedef struct Match {
  ticktrue_session* session;
  Game game;
  Game saved[history_count];   /* [tick % history_count], before that tick */
  uint8_t used[history_count]; /* [tick % history_count], buttons of the other player it ran with */
  int forgets;                 /* the bug: one field is not restored */
} Match;

static int run_tick(Match* match, uint64_t arrived) {
  const uint64_t tick = match->game.tick;
  uint8_t buttons[2] = {buttons_of(tick, 0), remote_buttons(tick, arrived)};
  ticktrue_input(match->session, buttons, sizeof buttons);
  if (ticktrue_begin_tick(match->session, NULL) != TICKTRUE_OK) return 0;
  match->saved[tick % history_count] = match->game;
  match->used[tick % history_count] = buttons[1];
  step_game(&match->game, buttons);
  return ticktrue_end_tick(match->session) == TICKTRUE_OK;
}

/* Back to before `tick`, and on again to where it was. */
static void run_again_from(Match* match, uint64_t tick, uint64_t arrived) {
  const uint64_t now = match->game.tick;
  const uint32_t cooldown = match->game.fighters[0].cooldown;
  match->game = match->saved[tick % history_count];
  if (match->forgets) match->game.fighters[0].cooldown = cooldown;
  ticktrue_rewind(match->session, tick);
  while (match->game.tick < now && run_tick(match, arrived)) continue;
}

int main(int argc, char** argv) {
  static Match match; /* all zero */
  int is_verify = 0;
  for (int i = 1; i < argc; ++i) {
    if (strcmp(argv[i], "unsaved") == 0) match.forgets = 1;
    if (strcmp(argv[i], "--verify") == 0) is_verify = 1;
  }
  ticktrue_options options = {0};
  options.struct_size = sizeof options;
  options.name = "rollback-example";
  options.detail = TICKTRUE_DETAIL_FULL;
  options.rollback_max = history_count;
  match.session = ticktrue_open_arguments(&options, argc, argv);
  register_state(match.session, &match.game);

  uint64_t confirmed = 0, back_count = 0;
  for (;;) {
    const uint64_t now = match.game.tick;
    uint64_t arrived = now == tick_count || is_verify ? now : arrived_at(now);
    if (arrived < confirmed) arrived = confirmed;
    uint64_t wrong = confirmed;
    while (wrong < arrived && (is_verify || match.used[wrong % history_count] == buttons_of(wrong, 1))) ++wrong;
    if (is_verify && now % 5 == 0 && now > 4) wrong = now - 3; /* going back must be harmless: try it */
    if (wrong < arrived) {
      run_again_from(&match, wrong, arrived);
      ++back_count;
    }
    confirmed = is_verify && now < tick_count ? (now > 4 ? now - 4 : 0) : arrived;
    if (ticktrue_confirm(match.session, confirmed) != TICKTRUE_OK || now == tick_count) break;
    if (!run_tick(&match, arrived)) break;
  }
  printf("%llu ticks, went back %llu times, hits %u : %u\n", (unsigned long long)match.game.tick,
         (unsigned long long)back_count, (unsigned)match.game.fighters[1].hits, (unsigned)match.game.fighters[0].hits);
  return ticktrue_close(match.session);
}
