// A C++ program that finds ticktrue by find_package: records itself in memory's worst order, and verifies itself.
// SPDX-License-Identifier: MIT
//
//   ./consumer --record f.ttr --sync-test 1      each tick runs twice
//   ./consumer --verify f.ttr --mode restore     from each save of the trace, too
//   ./consumer --verify f.ttr --from 100         from the last save before tick 100
#include <ticktrue.h>

#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace {

struct Particle {
  double position = 0;
  double velocity = 0;
};

/// A world whose objects lie anywhere: what is registered are rows copied together before each end_tick.
struct World {
  std::map<std::string, std::unique_ptr<Particle>> particles;
  std::vector<Particle> rows;
  uint32_t tick = 0;
  uint32_t table = 0;
  ticktrue_session* session = nullptr;

  explicit World(int count) {
    for (int i = 0; i < count; ++i) {
      auto particle = std::make_unique<Particle>();
      particle->velocity = 0.25 * i;
      particles["particle " + std::to_string(i)] = std::move(particle);
    }
  }
  void step(double dt, double wind) {
    for (auto& [name, particle] : particles) {
      particle->velocity += (wind - 0.125 * particle->velocity) * dt;
      particle->position += particle->velocity * dt;
    }
    ++tick;
  }
  void register_table() {
    const ticktrue_member members[] = {TICKTRUE_MEMBER(Particle, position, TICKTRUE_F64),
                                       TICKTRUE_MEMBER(Particle, velocity, TICKTRUE_F64)};
    table = ticktrue_table(session, "particles", sizeof(Particle), members, 2);
  }
  void show() {
    rows.clear();
    for (const auto& [name, particle] : particles) rows.push_back(*particle);
    ticktrue_rows(session, table, rows.data(), static_cast<uint32_t>(rows.size()));
  }
  std::vector<char> save() const {
    std::vector<char> bytes;
    const auto put = [&](const void* data, size_t size) {
      bytes.insert(bytes.end(), static_cast<const char*>(data), static_cast<const char*>(data) + size);
    };
    put(&tick, sizeof tick);
    for (const auto& [name, particle] : particles) put(particle.get(), sizeof *particle);
    return bytes;
  }
  bool load(const char* bytes, size_t size) {
    if (size != sizeof tick + particles.size() * sizeof(Particle)) return false;
    std::memcpy(&tick, bytes, sizeof tick);
    bytes += sizeof tick;
    for (auto& [name, particle] : particles) {
      std::memcpy(particle.get(), bytes, sizeof *particle);
      bytes += sizeof *particle;
    }
    show();
    return true;
  }
};

size_t save_world(void* user, void* buffer, size_t size) {
  const std::vector<char> bytes = static_cast<const World*>(user)->save();
  if (bytes.size() <= size) std::memcpy(buffer, bytes.data(), bytes.size());
  return bytes.size();
}

int load_world(void* user, const void* bytes, size_t size) {
  return static_cast<World*>(user)->load(static_cast<const char*>(bytes), size) ? 0 : 1;
}

int run(int argc, char** argv, double fault) {
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.name = "consumer-example";
  options.detail = TICKTRUE_DETAIL_FULL;
  options.caller_facts = TICKTRUE_CALLER_FACTS;
  World world(20);
  options.checkpoint_interval = 50;
  options.save = save_world;
  options.load = load_world;
  options.user = &world;
  world.session = ticktrue_open_arguments(&options, argc, argv);
  world.register_table();
  world.show();
  while (world.tick < 120) {
    double wind = world.tick % 50 < 25 ? 1.5 : -0.5;
    double dt = 1.0 / 60;
    ticktrue_input(world.session, &wind, sizeof wind);
    if (ticktrue_begin_tick(world.session, &dt) != TICKTRUE_OK) break;
    if (world.tick == 77) world.particles["particle 7"]->position += fault;
    world.step(dt, wind);
    world.show();
    ticktrue_end_tick(world.session);
  }
  return ticktrue_close(world.session);
}

}  // namespace

int main(int argc, char** argv) {
  const bool has_fault = argc > 3 && std::string(argv[argc - 1]) == "--fault";
  return run(argc, argv, has_fault ? 1e-12 : 0);
}
