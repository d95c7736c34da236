// A C++ program that finds ticktrue by find_package: records itself in memory's worst order, and verifies itself.
// SPDX-License-Identifier: MIT
#include <ticktrue.h>

#include <cstdio>
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
  uint32_t table = 0;

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
  }
  void register_table(ticktrue_session* session) {
    const ticktrue_member members[] = {TICKTRUE_MEMBER(Particle, position, TICKTRUE_F64),
                                       TICKTRUE_MEMBER(Particle, velocity, TICKTRUE_F64)};
    table = ticktrue_table(session, "particles", sizeof(Particle), members, 2);
  }
  void show(ticktrue_session* session) {
    rows.clear();
    for (const auto& [name, particle] : particles) rows.push_back(*particle);
    ticktrue_rows(session, table, rows.data(), static_cast<uint32_t>(rows.size()));
  }
};

int run(int argc, char** argv, double fault) {
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.name = "consumer-example";
  options.detail = TICKTRUE_DETAIL_FULL;
  options.caller_facts = TICKTRUE_CALLER_FACTS;
  ticktrue_session* session = ticktrue_open_arguments(&options, argc, argv);
  World world(20);
  world.register_table(session);
  world.show(session);
  for (int tick = 0; tick < 120; ++tick) {
    double wind = tick % 50 < 25 ? 1.5 : -0.5;
    double dt = 1.0 / 60;
    ticktrue_input(session, &wind, sizeof wind);
    if (ticktrue_begin_tick(session, &dt) != TICKTRUE_OK) break;
    world.step(dt, wind);
    if (tick == 77) world.particles["particle 7"]->position += fault;
    world.show(session);
    ticktrue_end_tick(session);
  }
  return ticktrue_close(session);
}

}  // namespace

int main(int argc, char** argv) {
  const bool has_fault = argc > 3 && std::string(argv[3]) == "--fault";
  return run(argc, argv, has_fault ? 1e-12 : 0);
}
