// A small battle in C++20: a struct of 20 members is named once, and its vector grows, shrinks and moves.
// SPDX-License-Identifier: MIT
//
//   ./units --record units.ttr              plays 300 ticks and records them
//   ./units --verify units.ttr              plays the recorded orders again and compares
//   ./units --record sync.ttr --sync-test 5 runs each tick twice, from saves
//   ./units --verify units.ttr --from 200   begins at the last save before tick 200
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <ticktrue.hpp>
#include <vector>

namespace battle {

struct Vec2 {
  float x = 0, y = 0;
};
enum class Team : std::uint8_t { red, blue };
enum class Kind : std::uint8_t { scout, archer, giant };

struct Unit {
  std::uint32_t id = 0;
  Team team = Team::red;
  Kind kind = Kind::scout;
  bool is_moving = false;
  std::uint8_t level = 1;
  std::int16_t hp = 100;
  std::int16_t hp_max = 100;
  std::uint16_t arrows = 20;
  Vec2 pos;                 // m
  Vec2 vel;                 // m/s
  Vec2 goal;                // m
  float cooldown = 0;       // s
  float range = 6;          // m
  double walked = 0;        // m
  double wear[2] = {0, 0};  // of armor and weapon
  std::int32_t gold = 0;    // may be debts
  std::int64_t score = 0;
  std::uint32_t target = 0xffffffff;  // id of another unit
  std::uint64_t seed = 1;
  float glow = 0;  // for the eye alone
};
TICKTRUE_COLUMNS(Unit, key(id), team, kind, is_moving, level, hp, hp_max, arrows, pos, vel, goal, cooldown, range,
                 walked, wear, gold, score, reference(target, "units"), seed, shown(glow))

/// What a player says in a tick.
struct Order {
  std::uint8_t player = 0;
  Vec2 goal;
};
TICKTRUE_COLUMNS(Order, player, goal)

struct Rules {
  std::uint64_t seed = 2026;
  std::uint32_t tick = 0;
  std::uint32_t next_id = 0;
};
TICKTRUE_COLUMNS(Rules, seed, tick, next_id)

std::uint32_t draw(std::uint64_t& seed) {
  seed = seed * 6364136223846793005u + 1442695040888963407u;
  return static_cast<std::uint32_t>(seed >> 33);
}

class World {
 public:
  Rules rules;
  std::vector<Unit> units;  // ids ascend

  void step(const std::vector<Order>& orders, float dt) {
    if (rules.tick % 5 == 0) enlist();
    for (const Order& order : orders)
      for (Unit& unit : units)
        if (static_cast<std::uint8_t>(unit.team) == order.player) unit.goal = order.goal;
    for (Unit& unit : units) walk(unit, dt);
    for (Unit& unit : units) fight(unit, dt);
    units.erase(std::remove_if(units.begin(), units.end(), [](const Unit& unit) { return unit.hp <= 0; }), units.end());
    ++rules.tick;
  }

 private:
  void enlist() {
    Unit unit;
    unit.id = rules.next_id++;
    unit.team = unit.id % 2 == 0 ? Team::red : Team::blue;
    unit.kind = static_cast<Kind>(draw(rules.seed) % 3);
    unit.hp_max = unit.kind == Kind::giant ? 250 : 100;
    unit.hp = unit.hp_max;
    unit.seed = draw(rules.seed);
    unit.pos = {static_cast<float>(draw(rules.seed) % 40), unit.team == Team::red ? 0.0f : 12.0f};
    unit.goal = {20, 6};
    units.push_back(unit);
  }

  static void walk(Unit& unit, float dt) {
    const float x = unit.goal.x - unit.pos.x, y = unit.goal.y - unit.pos.y;
    const float distance = std::sqrt(x * x + y * y);
    unit.is_moving = distance > 1;
    const float speed = unit.kind == Kind::scout ? 8.0f : 4.0f;
    unit.vel = unit.is_moving ? Vec2{x / distance * speed, y / distance * speed} : Vec2{};
    unit.pos = {unit.pos.x + unit.vel.x * dt, unit.pos.y + unit.vel.y * dt};
    unit.walked += static_cast<double>(unit.is_moving ? speed * dt : 0);
    unit.glow = unit.is_moving ? 1 : unit.glow * 0.9f;
  }

  void fight(Unit& unit, float dt) {
    unit.cooldown = std::max(0.0f, unit.cooldown - dt);
    Unit* nearest = nullptr;
    float best = unit.range * unit.range;
    for (Unit& other : units) {
      const float x = other.pos.x - unit.pos.x, y = other.pos.y - unit.pos.y;
      if (other.team == unit.team || other.hp <= 0 || x * x + y * y >= best) continue;
      best = x * x + y * y;
      nearest = &other;
    }
    unit.target = nearest == nullptr ? 0xffffffff : nearest->id;
    if (nearest == nullptr || unit.cooldown > 0 || unit.arrows == 0) return;
    const auto damage = static_cast<std::int16_t>(10 + draw(unit.seed) % 10 + unit.level);
    nearest->hp = static_cast<std::int16_t>(nearest->hp - damage);
    nearest->wear[0] += 0.125;
    unit.wear[1] += 0.0625;
    unit.cooldown = 0.5f;
    unit.score += damage;
    unit.gold += nearest->hp <= 0 ? 50 : -1;
    if (nearest->hp <= 0) ++unit.level;
    --unit.arrows;
  }
};

/// Values one after another, so that they come back in another process.
std::string save(const World& world) {
  std::string bytes(sizeof world.rules + world.units.size() * sizeof(Unit), '\0');
  std::memcpy(bytes.data(), &world.rules, sizeof world.rules);
  if (!world.units.empty())
    std::memcpy(bytes.data() + sizeof world.rules, world.units.data(), world.units.size() * sizeof(Unit));
  return bytes;
}

bool load(World& world, std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof world.rules || (bytes.size() - sizeof world.rules) % sizeof(Unit) != 0) return false;
  std::memcpy(&world.rules, bytes.data(), sizeof world.rules);
  world.units.resize((bytes.size() - sizeof world.rules) / sizeof(Unit));
  if (!world.units.empty())
    std::memcpy(world.units.data(), bytes.data() + sizeof world.rules, world.units.size() * sizeof(Unit));
  return true;
}

}  // namespace battle

int main(int argc, char** argv) {
  using battle::World;
  const bool has_fault = argc > 3 && std::strcmp(argv[argc - 1], "--fault") == 0;
  World world;
  ticktrue::Options options("units-example");
  options.detail = TICKTRUE_DETAIL_FULL;
  options.checkpoint_interval = 60;
  options.saves(
      world, [](const World& w) { return battle::save(w); },
      [](World& w, std::span<const std::byte> bytes) { return battle::load(w, bytes); });
  ticktrue::Session session(argc, argv, options);
  session.table("units", world.units);
  session.table("rules", world.rules);
  while (world.rules.tick < 300) {
    std::vector<battle::Order> orders;
    if (world.rules.tick % 40 == 7)
      orders.push_back(
          {static_cast<std::uint8_t>(world.rules.tick / 40 % 2), {10, static_cast<float>(world.rules.tick) / 10}});
    if (!session.input(orders) || !session.begin_tick()) break;
    if (has_fault && world.rules.tick == 150) world.units[3].hp = static_cast<std::int16_t>(world.units[3].hp - 1);
    world.step(orders, 1.0f / 60);
    session.end_tick();
  }
  std::printf("%zu units of %u\n", world.units.size(), world.rules.next_id);
  return session.close();
}
