// Clean: particles in a pool with free places, reached by index, and a table of handles by name.
// SPDX-License-Identifier: MIT
#include <string>
#include <unordered_map>
#include <vector>

#include "tests/causes/game.h"

namespace {

struct Particle {
  double height = 0;
  std::uint32_t age = 0;
};

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  static std::vector<Particle> particles;
  static std::vector<std::size_t> free_places;
  static std::unordered_map<std::string, std::size_t> by_name;
  for (std::uint32_t i = 0; i < 3; ++i) {
    std::size_t place = particles.size();
    if (free_places.empty()) {
      particles.emplace_back();
    } else {
      place = free_places.back();
      free_places.pop_back();
    }
    particles[place] = {0.5 * i, 0};
    by_name["particle " + std::to_string(tick % 20 * 3 + i)] = place;
  }
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (particles[i].age > 9) continue;
    particles[i].height += 0.125;
    if (++particles[i].age > 9) free_places.push_back(i);
    game.units[i % gallery::unit_count].velocity += 1e-3 * particles[i].height;
  }
  if (const auto found = by_name.find("particle 7"); found != by_name.end())
    game.units[0].score += static_cast<std::int64_t>(found->second);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("pools", argc, argv, rules);
}
