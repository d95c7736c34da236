// Heroes with names and inventories in C++20: texts and lists are members like others.
// SPDX-License-Identifier: MIT
//
//   ./inventory --record i.ttr           plays 200 ticks and records them
//   ./inventory --verify i.ttr           plays them again and compares
//   ./inventory --verify i.ttr --fault   spells a name otherwise at tick 120
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <ticktrue.hpp>
#include <utility>
#include <vector>

namespace quest {

struct Item {
  std::uint16_t weight = 0;
  std::string label;
};
TICKTRUE_COLUMNS(Item, weight, label)

struct Hero {
  std::uint32_t id = 0;
  std::int32_t gold = 10;
  std::string name;
  std::vector<Item> inventory;
};
TICKTRUE_COLUMNS(Hero, key(id), gold, name, inventory)

struct Quest {
  std::uint64_t seed = 7;
  std::uint32_t tick = 0;
};
TICKTRUE_COLUMNS(Quest, seed, tick)

class World {
 public:
  Quest quest;
  std::vector<Hero> heroes;  // ids ascend

  void step() {
    if (quest.tick % 40 == 0) enlist();
    Hero& hero = heroes[draw() % heroes.size()];
    Hero& other = heroes[draw() % heroes.size()];
    if (draw() % 3 == 0) {
      hero.inventory.push_back(find());
    } else if (!hero.inventory.empty()) {
      hero.gold += hero.inventory.back().weight;
      other.gold -= hero.inventory.back().weight;
      other.inventory.push_back(std::move(hero.inventory.back()));
      hero.inventory.pop_back();
    }
    if (hero.gold > 25 && hero.name.find(" the ") == std::string::npos) hero.name += " the Rich";
    ++quest.tick;
  }

 private:
  std::uint32_t draw() {
    quest.seed = quest.seed * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint32_t>(quest.seed >> 33);
  }
  void enlist() {
    static constexpr const char* names[] = {"Ada", "Bob", "Cleo", "Dora", "Emil"};
    Hero hero;
    hero.id = quest.tick / 40 + 1;
    hero.name = names[hero.id % 5];
    heroes.push_back(hero);
  }
  Item find() {
    static constexpr const char* kinds[] = {"axe", "lamp", "rope of twenty metres", "map"};
    const std::uint32_t kind = draw() % 4;
    return {static_cast<std::uint16_t>(1 + draw() % 9), kinds[kind]};
  }
};

}  // namespace quest

int main(int argc, char** argv) {
  const bool has_fault = argc > 3 && std::strcmp(argv[argc - 1], "--fault") == 0;
  quest::World world;
  ticktrue::Options options("inventory-example");
  options.detail = TICKTRUE_DETAIL_FULL;
  ticktrue::Session session(argc, argv, options);
  session.table("heroes", world.heroes);
  session.table("quest", world.quest);
  while (world.quest.tick < 200) {
    if (!session.begin_tick()) break;
    world.step();
    if (has_fault && world.quest.tick == 121) world.heroes[1].name[2] = 'd';
    session.end_tick();
  }
  std::printf("%zu heroes, the last is %s\n", world.heroes.size(), world.heroes.back().name.c_str());
  return session.close();
}
