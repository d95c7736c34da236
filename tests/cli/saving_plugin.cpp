// A plug-in with save and load: units whose number changes, and a generator that is in the save and in no column.
// SPDX-License-Identifier: MIT
//
// The setup is its seed. SAVING_PLUGIN=FAULT makes it misbehave; see plugin_saves_test.cpp. To the file that
// SAVING_PLUGIN_LOADS names, each load adds a line: the id of its process.
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "include/ticktrue.h"

namespace {

bool has(const char* fault) {
  const char* asked = std::getenv("SAVING_PLUGIN");
  return asked != nullptr && std::strcmp(asked, fault) == 0;
}

/// A fault of `place` that ends or stops the process.
void end_process(const std::string& place) {
  if (has((place + ":crash").c_str())) ::raise(SIGSEGV);
  if (has((place + ":exit").c_str())) ::_exit(0);
  if (has((place + ":hang").c_str()))
    for (;;) ::pause();
}

struct Unit {
  std::uint32_t id;
  std::uint32_t hits;
  double x;
};

struct World {
  std::uint64_t tick = 0;
  std::uint64_t generator = 0;  // in no column
  std::uint32_t next_id = 0;
  std::vector<Unit> units;

  std::uint32_t draw(std::uint32_t count) {
    generator ^= generator << 13;
    generator ^= generator >> 7;
    generator ^= generator << 17;
    return static_cast<std::uint32_t>(generator >> 33) % count;
  }
  void spawn() { units.push_back({next_id++, 0, 0.5 * draw(100)}); }
};

/// The save: this, then the units.
struct SaveHead {
  std::uint64_t tick, generator;
  std::uint32_t next_id, unit_count;
};

int create(const ticktrue_host*, const void* setup, std::size_t size, void** simulation, char*, std::size_t) {
  auto* world = new World;
  world->generator = std::strtoull(std::string(static_cast<const char*>(setup), size).c_str(), nullptr, 10) * 2 + 1;
  for (int i = 0; i < 3; ++i) world->spawn();
  *simulation = world;
  return 0;
}

void destroy(void* simulation) {
  delete static_cast<World*>(simulation);
}

int columns(void* simulation, const ticktrue_host* host, ticktrue_columns* out) {
  auto* world = static_cast<World*>(simulation);
  const auto count = static_cast<std::uint32_t>(world->units.size());
  Unit* units = world->units.data();
  host->column(out, "world", "tick", &world->tick, TICKTRUE_U64, 1, 1, 0);
  host->column(out, "units", "id", count > 0 ? &units->id : nullptr, TICKTRUE_U32, 1, count, sizeof(Unit));
  host->column(out, "units", "hits", count > 0 ? &units->hits : nullptr, TICKTRUE_U32, 1, count, sizeof(Unit));
  host->column(out, "units", "x", count > 0 ? &units->x : nullptr, TICKTRUE_F64, 1, count, sizeof(Unit));
  return host->key(out, "units", 1);
}

int step(void* simulation, double dt, const void*, std::size_t, const ticktrue_host*, ticktrue_stages*, char*,
         std::size_t) {
  auto* world = static_cast<World*>(simulation);
  for (Unit& unit : world->units) {
    unit.x += dt * (world->draw(9) - 4.0);
    unit.hits += world->draw(4) == 0 ? 1U : 0U;
  }
  if (world->draw(3) == 0) world->spawn();
  if (world->draw(4) == 0 && world->units.size() > 1)
    world->units.erase(world->units.begin() + world->draw(static_cast<std::uint32_t>(world->units.size())));
  ++world->tick;
  return 0;
}

std::size_t save(void* simulation, void* buffer, std::size_t size) {
  auto* world = static_cast<World*>(simulation);
  end_process("save");
  if (has("save:throw")) throw std::runtime_error("no disk");
  if (has("never") || (has("odd") && world->tick % 20 != 0)) return TICKTRUE_SAVE_FAILED;
  if (has("nothing")) return 0;
  if (has("grows")) return size + 1;
  if (has("changes") && world->tick >= 20) ++world->units.at(0).hits;
  const SaveHead head{world->tick, world->generator, world->next_id, static_cast<std::uint32_t>(world->units.size())};
  std::vector<std::uint8_t> bytes(sizeof head + world->units.size() * sizeof(Unit));
  std::memcpy(bytes.data(), &head, sizeof head);
  if (!world->units.empty()) std::memcpy(bytes.data() + sizeof head, world->units.data(), bytes.size() - sizeof head);
  if (has("short")) bytes.pop_back();
  if (bytes.size() <= size) std::memcpy(buffer, bytes.data(), bytes.size());
  if (has("beyond")) static_cast<std::uint8_t*>(buffer)[size] = 1;
  return bytes.size();
}

void tell_load() {
  const char* path = std::getenv("SAVING_PLUGIN_LOADS");
  if (path == nullptr) return;
  const int file = ::open(path, O_WRONLY | O_CREAT | O_APPEND, 0600);
  const std::string line = std::to_string(::getpid()) + "\n";
  if (::write(file, line.data(), line.size()) != static_cast<ssize_t>(line.size())) std::abort();
  ::close(file);
}

int load(void* simulation, const void* bytes, std::size_t size) {
  auto* world = static_cast<World*>(simulation);
  tell_load();
  end_process("load");
  if (has("load:throw")) throw std::runtime_error("no disk");
  SaveHead head{};
  if (size < sizeof head) return 1;
  std::memcpy(&head, bytes, sizeof head);
  if (size != sizeof head + head.unit_count * sizeof(Unit)) return 2;
  if (has("refuses")) return 3;
  world->tick = head.tick;
  if (!has("forgets")) world->generator = head.generator;
  world->next_id = head.next_id;
  world->units.resize(head.unit_count);
  if (head.unit_count > 0)
    std::memcpy(world->units.data(), static_cast<const std::uint8_t*>(bytes) + sizeof head, size - sizeof head);
  if (has("leaves") && head.unit_count > 0) world->units[0].hits += 7;
  return 0;
}

/// Never called where a trace has saves.
int loaded(void*, char*, std::size_t) {
  std::abort();
}

}  // namespace

extern "C" TICKTRUE_PLUGIN_API const ticktrue_plugin* ticktrue_plugin_entry(std::uint32_t) {
  static ticktrue_plugin plugin;
  plugin.struct_size = has("older") ? offsetof(ticktrue_plugin, save) : sizeof plugin;
  plugin.api_version = has("older") ? 4 : TICKTRUE_API_VERSION;
  plugin.name = "saving-plugin";
  plugin.create = create;
  plugin.destroy = destroy;
  plugin.columns = columns;
  plugin.step = step;
  plugin.loaded = has("older") ? nullptr : loaded;
  plugin.save = has("no save") ? nullptr : save;
  plugin.load = has("no load") ? nullptr : load;
  plugin.build = "r7 of the test";
  static const std::string long_text(5'000, 'x');
  if (has("long")) plugin.build = long_text.c_str();
  return &plugin;
}
