// A plug-in that sums the bytes of its inputs. With COUNTING_FAULT in the environment, a nine counts as a ten.
// SPDX-License-Identifier: MIT
#include <cstdint>
#include <cstdlib>

#include "include/ticktrue.h"

namespace {

struct World {
  std::uint64_t tick = 0;
  std::uint64_t total = 0;
};

int create(const ticktrue_host*, const void*, std::size_t, void** simulation, char*, std::size_t) {
  *simulation = new World;
  return 0;
}

void destroy(void* simulation) {
  delete static_cast<World*>(simulation);
}

int columns(void* simulation, const ticktrue_host* host, ticktrue_columns* out) {
  auto* world = static_cast<World*>(simulation);
  host->column(out, "world", "tick", &world->tick, TICKTRUE_U64, 1, 1, 0);
  return host->column(out, "counts", "total", &world->total, TICKTRUE_U64, 1, 1, 0);
}

int step(void* simulation, double, const void* inputs, std::size_t size, const ticktrue_host*, ticktrue_stages*, char*,
         std::size_t) {
  auto* world = static_cast<World*>(simulation);
  const bool is_wrong = std::getenv("COUNTING_FAULT") != nullptr;
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint8_t value = static_cast<const std::uint8_t*>(inputs)[i];
    world->total += is_wrong && value == 9 ? 10u : value;
  }
  ++world->tick;
  return 0;
}

}  // namespace

extern "C" TICKTRUE_PLUGIN_API const ticktrue_plugin* ticktrue_plugin_entry(std::uint32_t) {
  static ticktrue_plugin plugin;
  plugin.struct_size = sizeof plugin;
  plugin.api_version = TICKTRUE_API_VERSION;
  plugin.version = 1;
  plugin.name = "counting-plugin";
  plugin.create = create;
  plugin.destroy = destroy;
  plugin.columns = columns;
  plugin.step = step;
  return &plugin;
}
