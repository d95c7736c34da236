// Programs that each forget one variable in their save: `planted NAME --record FILE`.
// SPDX-License-Identifier: MIT
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <list>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <unordered_map>

#include "tests/unsaved/game.h"

extern "C" int raise_level(int by);

int combo_global = 0;
static std::uint32_t lcg_state = 1;
static std::mt19937 twister_global{7};
static std::vector<std::int32_t> pushed_values;
static std::vector<std::int32_t> free_slots{3, 1, 2};
static std::deque<std::uint32_t> pending_events;
static std::map<int, int> visits_map;
static std::unordered_map<int, int> cost_map;
static std::set<int> seen_set;
static std::list<int> turn_list{1, 2, 3, 4, 5, 6, 7};
static std::string log_text;
static thread_local int streak_of_thread = 0;
static bool is_sum_cached = false;
static std::int32_t cached_sum = 0;
static std::normal_distribution<double> spread_values{0, 50};

namespace {
struct Settings {
  int unused = 3;
  int difficulty = 1;
} file_settings;

struct Spawner {
  static int next_id;
  int spawn() { return next_id++; }
};
int Spawner::next_id = 100;

struct Rng {
  char name[24] = "loot";
  std::mt19937 engine{9};
};
struct Ai {
  int kind = 4;
  std::unique_ptr<std::int32_t> cooldown = std::make_unique<std::int32_t>(0);
  int target = 0;
  float accumulated = 0;
  bool is_paused = false;
};

__attribute__((noinline)) Rng* make_rng() {
  return new Rng;
}
__attribute__((noinline)) Ai* make_ai() {
  return new Ai;
}
__attribute__((noinline)) int* make_table() {
  return static_cast<int*>(std::calloc(64, sizeof(int)));
}
Rng* rng_heap = nullptr;
Ai* ai_heap = nullptr;
int* table_heap = nullptr;

__attribute__((noinline)) int count_calls() {
  static int calls_of_spawn = 0;
  return ++calls_of_spawn;
}

/// Each program also has variables that differ without harm.
int frames_shown = 0;
char last_message[64];

void noise(const Game& game) {
  ++frames_shown;
  std::snprintf(last_message, sizeof last_message, "tick %u", static_cast<unsigned>(game.tick));
}

using Step = void (*)(Game&, int);
struct Plant {
  const char* name;
  Step step;
};

const Plant plants[] = {
    {"global", [](Game& g, int) { g.x[0] += ++combo_global % 7; }},
    {"file_static",
     [](Game& g, int) { g.x[0] += static_cast<int>((lcg_state = lcg_state * 1664525u + 1013904223u) >> 28); }},
    {"function_static", [](Game& g, int) { g.x[2] += count_calls() % 7 == 0 ? 5 : 1; }},
    {"class_static",
     [](Game& g, int button) {
       if (button) g.x[3] = Spawner().spawn();
     }},
    {"struct_member",
     [](Game& g, int button) {
       file_settings.difficulty += button;
       g.x[1] += file_settings.difficulty;
     }},
    {"twister_global", [](Game& g, int) { g.x[1] += static_cast<int>(twister_global() % 9); }},
    {"twister_heap", [](Game& g, int) { g.x[1] += static_cast<int>(rng_heap->engine() % 9); }},
    {"rand", [](Game& g, int) { g.x[1] += std::rand() % 9; }},
    {"distribution",
     [](Game& g, int) {
       std::minstd_rand source(g.tick + 1);
       g.x[0] += static_cast<int>(spread_values(source));
     }},
    {"heap_pointer",
     [](Game& g, int button) {
       if (*ai_heap->cooldown > 0)
         --*ai_heap->cooldown;
       else if (button)
         *ai_heap->cooldown = 4, ++g.x[1];
     }},
    {"heap_member",
     [](Game& g, int button) {
       g.x[static_cast<std::size_t>(ai_heap->target)] -= 2;
       if (button) ai_heap->target = (ai_heap->target + 1) % 4;
     }},
    {"heap_float",
     [](Game& g, int) {
       for (ai_heap->accumulated += 0.7f; ai_heap->accumulated >= 1; ai_heap->accumulated -= 1) ++g.x[0];
     }},
    {"heap_bool",
     [](Game& g, int button) {
       if (button) ai_heap->is_paused = !ai_heap->is_paused;
       if (!ai_heap->is_paused) ++g.x[3];
     }},
    {"calloc_table", [](Game& g, int) { g.x[0] += table_heap[g.tick % 5]++; }},
    {"vector_growth",
     [](Game& g, int button) {
       if (button) pushed_values.push_back(g.x[0] % 10);
       g.x[0] += static_cast<int>(pushed_values.size());
     }},
    {"vector_order",
     [](Game& g, int) {
       const int slot = free_slots.back();
       g.x[static_cast<std::size_t>(slot)] += 6;
       free_slots.pop_back();
       free_slots.insert(free_slots.begin(), slot);
     }},
    {"deque",
     [](Game& g, int button) {
       if (button) pending_events.push_back(g.tick + 3);
       while (!pending_events.empty() && pending_events.front() <= g.tick) g.x[0] += 4, pending_events.pop_front();
     }},
    {"map", [](Game& g, int) { g.x[0] += ++visits_map[g.x[1]++ % 40] % 4; }},
    {"unordered_map", [](Game& g, int) { g.x[0] += ++cost_map[g.x[1]++ % 3] % 4; }},
    {"set",
     [](Game& g, int) {
       if (seen_set.insert(g.x[1]++ % 90).second) ++g.x[0];
     }},
    {"list",
     [](Game& g, int) {
       g.x[0] += turn_list.front();
       turn_list.push_back(turn_list.front());
       turn_list.pop_front();
     }},
    {"string",
     [](Game& g, int) {
       log_text += '.';
       if (log_text.size() > 40) log_text.clear(), g.x[3] += 2;
       g.x[2] += static_cast<int>(log_text.size());
     }},
    {"thread_local",
     [](Game& g, int button) {
       streak_of_thread = (streak_of_thread + button) % 9;
       g.x[2] += streak_of_thread;
     }},
    {"module", [](Game& g, int button) { g.x[2] += raise_level(button); }},
    {"cache",
     [](Game& g, int button) {
       if (!is_sum_cached) cached_sum = g.x[0] + g.x[1];
       is_sum_cached = button == 0;
       g.x[3] += cached_sum % 5;
       ++g.x[0];
     }},
};

int play_local(Game& game, int argc, char** argv) {
  volatile int local_wave = 0;
  return play(game, argc, argv, true, [&](int button) {
    noise(game);
    local_wave = local_wave + button;
    game.x[0] += local_wave;
  });
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  rng_heap = make_rng();
  ai_heap = make_ai();
  table_heap = make_table();
  static Game game;
  if (std::strcmp(argv[1], "local") == 0) return play_local(game, argc, argv);
  for (const Plant& plant : plants)
    if (std::strcmp(argv[1], plant.name) == 0)
      return play(game, argc, argv, true, [&](int button) {
        noise(game);
        plant.step(game, button);
      });
  return 2;
}
