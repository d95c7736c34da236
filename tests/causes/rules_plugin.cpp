// Causes within a plug-in: its setup names the one mistake of its rules, or none.
// SPDX-License-Identifier: MIT
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "include/ticktrue.h"

namespace {

constexpr std::uint32_t unit_count = 4;

struct World {
  std::uint64_t tick = 0;
  std::int64_t score[unit_count] = {3, 1, 4, 1};
  const char* rule = "";
};

/// The mistakes. Each adds its value to a score.
std::int64_t garbage() {
  // A block this large was never memory of the tool, whose old contents would depend on all that the tool does.
  auto* block = static_cast<volatile std::uint8_t*>(std::malloc(1u << 20));
  const std::int64_t value = block[40];  // never written
  std::free(const_cast<std::uint8_t*>(block));
  return value;
}
std::int64_t local_hour() {
  const std::time_t noon = 1'764'000'000;
  std::tm parts{};
  return ::localtime_r(&noon, &parts) != nullptr ? parts.tm_hour : 0;
}

constexpr struct {
  const char* name;
  std::int64_t (*add)();
} rules[] = {{"garbage", garbage}, {"local_hour", local_hour}, {"clean", [] { return std::int64_t{7}; }}};

int create(const ticktrue_host*, const void* setup, std::size_t size, void** simulation, char* text,
           std::size_t text_size) {
  for (const auto& rule : rules) {
    if (size != std::strlen(rule.name) || std::memcmp(setup, rule.name, size) != 0) continue;
    auto* world = new World;
    world->rule = rule.name;
    *simulation = world;
    return 0;
  }
  std::snprintf(text, text_size, "rule: expected garbage, local_hour or clean");
  return 1;
}

void destroy(void* simulation) {
  delete static_cast<World*>(simulation);
}

int columns(void* simulation, const ticktrue_host* host, ticktrue_columns* out) {
  auto* world = static_cast<World*>(simulation);
  host->column(out, "world", "tick", &world->tick, TICKTRUE_U64, 1, 1, 0);
  return host->column(out, "units", "score", world->score, TICKTRUE_I64, 1, unit_count, 0);
}

int step(void* simulation, double, const void*, std::size_t, const ticktrue_host*, ticktrue_stages*, char*,
         std::size_t) {
  auto* world = static_cast<World*>(simulation);
  std::int64_t& score = world->score[world->tick % unit_count];
  score = score * 3 % 1'000 + 1;
  if (world->tick == 20)
    for (const auto& rule : rules)
      if (std::strcmp(rule.name, world->rule) == 0) score += rule.add();
  ++world->tick;
  return 0;
}

}  // namespace

extern "C" TICKTRUE_PLUGIN_API const ticktrue_plugin* ticktrue_plugin_entry(std::uint32_t) {
  static ticktrue_plugin plugin;
  plugin.struct_size = sizeof plugin;
  plugin.api_version = TICKTRUE_API_VERSION;
  plugin.version = 1;
  plugin.name = "causes-plugin";
  plugin.create = create;
  plugin.destroy = destroy;
  plugin.columns = columns;
  plugin.step = step;
  return &plugin;
}
