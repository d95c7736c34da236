// A plug-in with one fault, chosen by TICKTRUE_BAD_PLUGIN: what the tool says of each is in run.sh.
// SPDX-License-Identifier: MIT
#include <stdlib.h>
#include <string.h>

#include "ticktrue.h"

static const char* fault(void) {
  const char* text = getenv("TICKTRUE_BAD_PLUGIN");
  return text == NULL ? "" : text;
}
static int has(const char* name) {
  return strcmp(fault(), name) == 0;
}

static double values[4];
static int step_count;

static int create(const ticktrue_host* host, const void* setup, size_t size, void** simulation, char* text,
                  size_t text_size) {
  (void)host, (void)setup, (void)size;
  if (has("loud")) memset(text, 'x', text_size);
  *simulation = has("nothing") ? NULL : values;
  return has("loud");
}
static void destroy(void* simulation) {
  (void)simulation;
  if (has("destroy")) abort();
}
static int columns(void* simulation, const ticktrue_host* host, ticktrue_columns* out) {
  (void)simulation;
  if (has("empty")) return 0;
  host->column(out, "rows", "x", values, has("type") && step_count > 1 ? TICKTRUE_U64 : TICKTRUE_F64, 1,
               has("stride") ? 2 : 4, has("stride") ? 4 : 0);
  if (has("late") && step_count > 1) host->column(out, "rows", "y", values, TICKTRUE_F64, 1, 4, 0);
  if (has("rows")) host->column(out, "rows", "z", values, TICKTRUE_F64, 1, 3, 0);
  if (has("null")) host->column(out, "rows", "n", NULL, TICKTRUE_F64, 1, 4, 0);
  return has("columns");
}
static int step(void* simulation, double dt, const void* inputs, size_t size, const ticktrue_host* host,
                ticktrue_stages* done, char* text, size_t text_size) {
  (void)simulation, (void)inputs, (void)size, (void)text_size;
  ++step_count;
  values[0] += dt;
  if (has("infinite") && step_count == 3) values[1] = 1e308 * 10 * values[0];
  if (has("step") && step_count == 3) {
    strcpy(text, "out of fuel");
    return 1;
  }
  host->stage_done(done, has("order") ? 1 : 0);
  if (!has("stages")) host->stage_done(done, has("beyond") ? 9 : 1);
  return 0;
}

const ticktrue_plugin* ticktrue_plugin_entry(uint32_t api_version) {
  static const char* const stages[] = {"first", "second"};
  static ticktrue_plugin plugin;
  (void)api_version;
  plugin.struct_size = has("size") ? 12 : sizeof plugin;
  plugin.api_version = has("version") ? 99 : TICKTRUE_API_VERSION;
  plugin.name = has("name") ? "" : has("engine") ? "ticktrue.engine" : "bad-plugin";
  plugin.stages = stages;
  plugin.stage_count = has("many") ? 100000 : 2;
  plugin.create = create;
  plugin.destroy = destroy;
  plugin.columns = columns;
  plugin.step = has("missing") ? NULL : step;
  if (has("entry")) abort();
  return has("old") ? NULL : &plugin;
}
