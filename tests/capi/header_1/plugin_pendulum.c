// A plug-in in C: a chain of pendulums that the tool records, verifies, saves and restores.
// SPDX-License-Identifier: MIT
//
//   ticktrue record --plugin ./libplugin_pendulum.so 8 --ticks 600 -o chain.ttr      8: the setup, number of pendulums
//   ticktrue verify --plugin ./libplugin_pendulum.so chain.ttr --mode restore
//
// TICKTRUE_EXAMPLE_FAULT=crash|hang|drift makes it misbehave from tick 100 on, to see what is told.
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ticktrue.h"

typedef struct Link {
  uint32_t id;
  double angle;    /* rad */
  double velocity; /* rad/s */
} Link;

typedef struct Chain {
  uint64_t tick;
  uint32_t count;
  Link* links;
  double* torque; /* derived: not registered, made anew by every step */
} Chain;

static const char* const stages[] = {"torques", "move"};

static void destroy(void* simulation) {
  Chain* chain = simulation;
  free(chain->links);
  free(chain->torque);
  free(chain);
}

static int create(const ticktrue_host* host, const void* setup, size_t size, void** simulation, char* text,
                  size_t text_size) {
  (void)host;
  char word[16] = "";
  if (size > 0 && size < sizeof word) memcpy(word, setup, size);
  const long count = strtol(word, NULL, 10);
  if (count < 1 || count > 1000) {
    snprintf(text, text_size, "number of pendulums: expected 1..1000");
    return 1;
  }
  Chain* chain = calloc(1, sizeof *chain);
  chain->count = (uint32_t)count;
  chain->links = calloc(chain->count, sizeof *chain->links);
  chain->torque = calloc(chain->count, sizeof *chain->torque);
  for (uint32_t i = 0; i < chain->count; ++i) chain->links[i] = (Link){i, i % 2 ? 0.5 : -0.25, 0};
  *simulation = chain;
  return 0;
}

static int columns(void* simulation, const ticktrue_host* host, ticktrue_columns* out) {
  Chain* chain = simulation;
  Link* links = chain->links;
  host->column(out, "world", "tick", &chain->tick, TICKTRUE_U64, 1, 1, 0);
  host->column(out, "links", "id", &links->id, TICKTRUE_U32, 1, chain->count, sizeof *links);
  host->column(out, "links", "angle", &links->angle, TICKTRUE_F64, 1, chain->count, sizeof *links);
  host->column(out, "links", "velocity", &links->velocity, TICKTRUE_F64, 1, chain->count, sizeof *links);
  return host->key(out, "links", 1);
}

static int step(void* simulation, double dt, const void* inputs, size_t inputs_size, const ticktrue_host* host,
                ticktrue_stages* done, char* text, size_t text_size) {
  Chain* chain = simulation;
  (void)text, (void)text_size;
  const char* fault = getenv("TICKTRUE_EXAMPLE_FAULT");
  if (fault == NULL || chain->tick < 100) fault = "";
  if (strcmp(fault, "crash") == 0) *(volatile int*)chain->tick = 1;
  while (strcmp(fault, "hang") == 0) continue;
  for (size_t i = 0; i < inputs_size; ++i) chain->links[i % chain->count].velocity += ((const int8_t*)inputs)[i] / 64.0;
  for (uint32_t i = 0; i < chain->count; ++i) {
    const double angle = chain->links[i].angle;
    chain->torque[i] = -9.8125 * (angle - angle * angle * angle / 6);
    if (i > 0) chain->torque[i] += 2 * (chain->links[i - 1].angle - angle);
    if (i + 1 < chain->count) chain->torque[i] += 2 * (chain->links[i + 1].angle - angle);
  }
  host->stage_done(done, 0);
  for (uint32_t i = 0; i < chain->count; ++i) {
    chain->links[i].velocity += chain->torque[i] * dt;
    chain->links[i].angle += chain->links[i].velocity * dt;
  }
  if (strcmp(fault, "drift") == 0) chain->links[chain->count / 2].velocity *= 1 + 1e-15;
  ++chain->tick;
  host->stage_done(done, 1);
  return 0;
}

static int loaded(void* simulation, char* text, size_t text_size) {
  (void)simulation, (void)text, (void)text_size; /* nothing derives from the state between ticks */
  return 0;
}

static int row_name(void* simulation, const char* table, uint32_t row, char* text, size_t text_size) {
  (void)simulation;
  if (strcmp(table, "links") != 0) return 1;
  snprintf(text, text_size, "pendulum %u", (unsigned)row);
  return 0;
}

const ticktrue_plugin* ticktrue_plugin_entry(uint32_t api_version) {
  static const ticktrue_plugin plugin = {
      .struct_size = sizeof plugin,
      .api_version = TICKTRUE_API_VERSION,
      .version = 1,
      .name = "pendulum-example",
      .stages = stages,
      .stage_count = 2,
      .create = create,
      .destroy = destroy,
      .columns = columns,
      .step = step,
      .loaded = loaded,
      .row_name = row_name,
  };
  return api_version >= TICKTRUE_API_VERSION ? &plugin : NULL;
}
