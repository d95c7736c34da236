// A lockstep game for two over UDP: each process finds out which player went wrong, where and how.
// SPDX-License-Identifier: MIT
//
//   ./udp_lockstep 0 & ./udp_lockstep 1               both players, at 127.0.0.1
//   ./udp_lockstep 0 & ./udp_lockstep 1 --bug order   a bug on one side: both name tick, column, row and values
//
//     --bug B     flip, order, input or clock            --at N         the tick from which on it shows (100)
//     --loss P    of 100 packets, P are not sent         --seed N       another level: hello refuses to play it
//     --anyway 1  plays in spite of what hello says      --record FILE  a trace of the game, as in lockstep.c
//     --port N    that of player 0 (47100); the other has the next
//     --bundle FILE  after a desync: one file to send, which ticktrue show and report read
//     --verify FILE  runs the ticks of a bundle or a trace again, alone: ticktrue verify F.ttr --command
//     './udp_lockstep 0'
//
// Exit codes are those of ticktrue_close; 3: the other is silent; 5: hello refused. Packets have the byte order of the
// machine; between machines that differ there, a game would write its numbers out.
#define _POSIX_C_SOURCE 200809L
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

#include "ticktrue.h"

/* ---- the game ---------------------------------------------------------------------------------------------------- */

enum { boat_count = 8, tick_count = 300, input_delay = 4 };

typedef struct Boat {
  float place[2], speed[2];
  int32_t points;
} Boat;

typedef struct Game {
  Boat boats[boat_count];
  float wind[2];
  uint32_t random;
} Game;

typedef struct Faults {
  const char* bug;
  uint64_t at; /* tick */
} Faults;

static uint32_t next_random(Game* game) {
  return game->random = game->random * 1664525u + 1013904223u;
}

static void begin_game(Game* game, uint32_t seed) {
  memset(game, 0, sizeof *game);
  game->random = seed;
  for (int i = 0; i < boat_count; ++i)
    for (int lane = 0; lane < 2; ++lane) game->boats[i].place[lane] = (float)(next_random(game) >> 22) / 7.0f;
}

static int has_bug(const Faults* faults, const char* name, uint64_t tick) {
  return tick >= faults->at && strcmp(faults->bug, name) == 0;
}

static void step_game(Game* game, const uint8_t inputs[2], uint64_t tick, const Faults* faults) {
  float centre[2] = {0, 0};
  for (int i = 0; i < boat_count; ++i) /* the bug `order`: a sum in another order, as of an unordered container */
    for (int lane = 0; lane < 2; ++lane)
      centre[lane] += game->boats[has_bug(faults, "order", tick) ? boat_count - 1 - i : i].place[lane] / boat_count;
  for (int i = 0; i < boat_count; ++i) {
    Boat* boat = &game->boats[i];
    const uint8_t input = inputs[i % 2];
    for (int lane = 0; lane < 2; ++lane) {
      const float rudder = (float)((input >> (2 * lane)) & 3) - 1.5f;
      boat->speed[lane] += 0.05f * rudder + 0.01f * game->wind[lane] - 0.002f * (boat->place[lane] - centre[lane]);
      boat->place[lane] += boat->speed[lane] * 0.0166667f;
    }
    if (input & 16) boat->points += (int32_t)(next_random(game) >> 30);
  }
  game->wind[tick % 2] = (float)(next_random(game) >> 24) / 256.0f - 0.5f;
  if (has_bug(faults, "clock", tick)) game->boats[3].speed[0] += (float)(clock() % 1000 + 1) * 1e-5f;
  if (has_bug(faults, "flip", tick) && tick == faults->at) game->boats[5].points ^= 64;
}

/* All that a tick depends on. */
static size_t save_game(void* user, void* buffer, size_t size) {
  if (size >= sizeof(Game)) memcpy(buffer, user, sizeof(Game));
  return sizeof(Game);
}
static int load_game(void* user, const void* bytes, size_t size) {
  if (size != sizeof(Game)) return 1;
  memcpy(user, bytes, size);
  return 0;
}

/* What a person at the tiller would do. */
static uint8_t read_input(uint32_t player, uint64_t tick) {
  return (uint8_t)((tick / 12 + player * 5 + 1) * 2654435761u >> 26);
}

static const char* word_of(int argc, char** argv, const char* name, const char* otherwise) {
  for (int i = 2; i + 1 < argc; ++i)
    if (strcmp(argv[i], name) == 0) return argv[i + 1];
  return otherwise;
}

/* ---- the same with ticktrue: as in lockstep.c ----------------------------------------------------------------------
 */

typedef struct Match {
  ticktrue_session* session;
  uint32_t self;
  int socket, loss, anyway, hello_arrived, has_our_hello, other_is_done, is_refused, is_desync;
  uint64_t input_end[2]; /* [player], ticks whose inputs are known */
  uint8_t inputs[2][tick_count];
} Match;

static void open_session(Match* match, Game* game, const uint32_t* seed, int argc, char** argv) {
  ticktrue_options options = {0};
  options.struct_size = sizeof options;
  options.mode = TICKTRUE_LIVE;
  options.name = "udp-lockstep";
  options.caller_facts = TICKTRUE_CALLER_FACTS;
  options.setup = seed;
  options.setup_size = sizeof *seed;
  options.player = match->self;
  options.save = save_game; /* a bundle begins at the last save before the desync */
  options.load = load_game;
  options.user = game;
  options.checkpoint_interval = 50;
  match->session = ticktrue_open_arguments(&options, argc, argv);
  const ticktrue_member members[] = {TICKTRUE_MEMBER(Boat, place, TICKTRUE_F32),
                                     TICKTRUE_MEMBER(Boat, speed, TICKTRUE_F32),
                                     TICKTRUE_MEMBER(Boat, points, TICKTRUE_I32)};
  const uint32_t boats = ticktrue_table(match->session, "boats", sizeof(Boat), members, 3);
  ticktrue_rows(match->session, boats, game->boats, boat_count);
  ticktrue_column(match->session, "world", "wind", game->wind, TICKTRUE_F32, 2, 1, 0);
  ticktrue_column(match->session, "world", "random", &game->random, TICKTRUE_U32, 1, 1, 0);
}

static void run_ticks(Match* match, Game* game, const Faults* faults) {
  for (uint64_t tick; (tick = ticktrue_tick(match->session)) < match->input_end[0] && tick < match->input_end[1];) {
    uint8_t inputs[2] = {match->inputs[0][tick], match->inputs[1][tick]};
    if (has_bug(faults, "input", tick) && tick == faults->at) inputs[!match->self] ^= 21;
    ticktrue_input(match->session, inputs, sizeof inputs);
    if (ticktrue_begin_tick(match->session, NULL) != TICKTRUE_OK) return;
    step_game(game, inputs, tick, faults);
    ticktrue_end_tick(match->session);
  }
}

/* The ticks of a file instead of those of a match. */
static int run_recorded(ticktrue_session* session, Game* game, const Faults* faults) {
  uint8_t inputs[2];
  while (ticktrue_input(session, inputs, sizeof inputs) == TICKTRUE_OK &&
         ticktrue_begin_tick(session, NULL) == TICKTRUE_OK) {
    step_game(game, inputs, ticktrue_tick(session), faults);
    ticktrue_end_tick(session);
  }
  return ticktrue_close(session);
}

/* ---- the other player: packets that hold all that may be missing, so that lost ones do not matter ---------------- */

enum { input_max = 32, root_max = 16, rest_max = 8192, message_max = 1200, silence_max = 2000 };

typedef struct Packet {
  uint8_t has_hello, hello_arrived, is_done, root_count; /* is_done: the sender needs nothing more */
  uint64_t input_end, first_root, roots[root_max];       /* inputs: of the ticks before input_end */
  uint8_t inputs[input_max], rest[rest_max];             /* rest: hello, or a message about a desync */
} Packet;

static int is_done(const Match* match) {
  int is_whole = 1;
  if (match->is_desync) ticktrue_desync_report(match->session, &is_whole);
  return match->is_refused || (is_whole && ticktrue_tick(match->session) == tick_count);
}

static void send_packet(Match* match) {
  static uint32_t random = 1;
  Packet packet;
  const uint64_t tick = ticktrue_tick(match->session), end = match->input_end[match->self];
  memset(&packet, 0, sizeof packet);
  packet.hello_arrived = (uint8_t)match->hello_arrived;
  packet.has_hello = !match->has_our_hello;
  packet.is_done = (uint8_t)is_done(match);
  packet.input_end = end;
  for (uint64_t i = 0; i < input_max && i < end; ++i) packet.inputs[i] = match->inputs[match->self][end - 1 - i];
  packet.first_root = tick > root_max ? tick - root_max : 0;
  for (uint64_t t = packet.first_root; t < tick; ++t)
    ticktrue_root(match->session, t, &packet.roots[packet.root_count++]);
  size_t size = packet.has_hello ? ticktrue_hello(match->session, packet.rest, rest_max)
                                 : ticktrue_desync_message(match->session, !match->self, packet.rest, message_max);
  random = random * 1664525u + 1013904223u;
  if ((int)((random >> 16) % 100) >= match->loss) send(match->socket, &packet, offsetof(Packet, rest) + size, 0);
}

static void take_packet(Match* match, const Packet* packet, size_t rest) {
  const uint32_t other = !match->self;
  int status = TICKTRUE_OK;
  if (packet->has_hello && !match->hello_arrived) {
    char text[2000];
    status = ticktrue_hello_check(match->session, other, packet->rest, rest, text, sizeof text);
    if (text[0]) printf("player %u: hello of player %u:\n%s\n", (unsigned)match->self, (unsigned)other, text);
    match->is_refused = status == TICKTRUE_DIVERGED && !match->anyway;
    match->hello_arrived = status != TICKTRUE_REFUSED;
  }
  match->has_our_hello |= packet->hello_arrived;
  match->other_is_done = packet->is_done;
  if (!match->hello_arrived || match->is_refused) return;
  for (uint64_t i = input_max; i-- > 0;)
    if (match->input_end[other] < tick_count && packet->input_end == match->input_end[other] + i + 1)
      match->inputs[other][match->input_end[other]++] = packet->inputs[i];
  for (uint64_t i = 0; i < packet->root_count && i < root_max; ++i)
    status = ticktrue_peer_root(match->session, other, packet->first_root + i, packet->roots[i]);
  if (!packet->has_hello && rest > 0) status = ticktrue_desync_receive(match->session, other, packet->rest, rest);
  match->is_desync |= status == TICKTRUE_DIVERGED;
}

static int open_socket(const Match* match, int port) {
  struct sockaddr_in own = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)}, other = own;
  own.sin_port = htons((uint16_t)(port + (int)match->self));
  other.sin_port = htons((uint16_t)(port + !match->self));
  const int opened = socket(AF_INET, SOCK_DGRAM, 0);
  if (bind(opened, (struct sockaddr*)&own, sizeof own) != 0) return -1;
  return connect(opened, (struct sockaddr*)&other, sizeof other) == 0 ? opened : -1;
}

int main(int argc, char** argv) {
  static Match match;
  static Game game;
  const Faults faults = {word_of(argc, argv, "--bug", ""), (uint64_t)atoi(word_of(argc, argv, "--at", "100"))};
  const uint32_t seed = (uint32_t)atoi(word_of(argc, argv, "--seed", "1"));
  match.self = argc > 1 && argv[1][0] == '1' ? 1 : 0;
  match.loss = atoi(word_of(argc, argv, "--loss", "0"));
  match.anyway = atoi(word_of(argc, argv, "--anyway", "0"));
  begin_game(&game, seed);
  open_session(&match, &game, &seed, argc, argv);
  if (word_of(argc, argv, "--verify", NULL) != NULL) return run_recorded(match.session, &game, &faults);
  match.socket = open_socket(&match, atoi(word_of(argc, argv, "--port", "47100")));
  if (match.socket < 0) return perror("udp_lockstep: port"), 2;
  int silence = 0, rest = 0; /* rounds of 2 ms; the other needs our last packets, too */
  while (silence < silence_max && rest < 30) {
    struct pollfd waits = {match.socket, POLLIN, 0};
    Packet packet;
    ++silence;
    for (int wait_ms = 2; poll(&waits, 1, wait_ms) > 0; wait_ms = 0) {
      const ssize_t size = recv(match.socket, &packet, sizeof packet, 0);
      if (size < (ssize_t)offsetof(Packet, rest)) {
        poll(NULL, 0, 2); /* refused: the other has not started, and the next call would not wait */
        break;
      }
      take_packet(&match, &packet, (size_t)size - offsetof(Packet, rest));
      silence = 0;
    }
    uint64_t* end = &match.input_end[match.self];
    for (; *end < tick_count && *end < ticktrue_tick(match.session) + input_delay; ++*end)
      match.inputs[match.self][*end] = read_input(match.self, *end);
    if (match.hello_arrived && !match.is_refused) run_ticks(&match, &game, &faults);
    send_packet(&match);
    rest = is_done(&match) && match.other_is_done ? rest + 1 : 0;
  }
  const char* bundle = word_of(argc, argv, "--bundle", NULL);
  if (match.is_desync && bundle != NULL && ticktrue_bundle(match.session, bundle) != TICKTRUE_OK)
    fprintf(stderr, "udp_lockstep: %s\n", ticktrue_message(match.session));
  const int code = ticktrue_close(match.session); /* prints the report */
  return match.is_refused ? 5 : code == 0 && rest == 0 ? 3 : code;
}
