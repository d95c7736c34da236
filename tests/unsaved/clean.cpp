// Programs whose save is complete, with many harmless differences after a load: `clean NAME --record FILE`.
// SPDX-License-Identifier: MIT
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>

#include "tests/unsaved/game.h"

namespace {

struct Particle {
  char kind;  // followed by padding
  double value;
};

std::map<int, int> square_cache;
std::unordered_map<int, double> root_cache;
std::vector<std::string> log_lines;
std::deque<Particle> particles;
std::unique_ptr<Particle> last_particle;
int frames_shown = 0, restarts = 0;
Game history[16];
double time_shown = 0;
std::uint64_t allocations = 0;
std::vector<std::int32_t> scratch;

int square(int n) {
  auto [at, is_new] = square_cache.try_emplace(n, 0);
  if (is_new) at->second = n * n;
  return at->second;
}

using Step = void (*)(Game&, int);
struct Program {
  const char* name;
  Step step;
  bool has_saves = true;
};

const Program programs[] = {
    {"plain", [](Game& g, int button) { g.x[0] += button; }},
    {"pure_cache", [](Game& g, int) { g.x[0] += square(g.x[1]++ % 50) % 11; }},
    {"pure_hash_cache",
     [](Game& g, int) {
       auto [at, is_new] = root_cache.try_emplace(g.x[1] % 30, 0.0);
       if (is_new) at->second = std::sqrt(static_cast<double>(g.x[1] % 30));
       g.x[0] += static_cast<int>(at->second), ++g.x[1];
     }},
    {"allocations",
     [](Game& g, int button) {
       std::vector<std::unique_ptr<Particle>> made;
       for (int i = 0; i < 50 + button; ++i)
         made.push_back(std::make_unique<Particle>(Particle{1, static_cast<double>(i)}));
       allocations += made.size();
       g.x[2] += static_cast<int>(made.back()->value);
     }},
    {"log_buffer",
     [](Game& g, int button) {
       log_lines.push_back("tick " + std::to_string(g.tick) + " of a game with a long line in its log");
       if (log_lines.size() > 20) log_lines.erase(log_lines.begin());
       g.x[1] += button;
     }},
    {"frames",
     [](Game& g, int button) {
       ++frames_shown;
       time_shown += 1.0 / 60;
       g.x[0] += 1 + button;
     }},
    {"containers",
     [](Game& g, int) {
       std::map<int, int> sorted;
       for (int v : g.x) sorted[v] = v;
       g.x.push_back(sorted.begin()->second);
       if (g.x.size() > 30) g.x.erase(g.x.begin(), g.x.begin() + 26);
       g.x[0] += 3;
       g.show();
     }},
    {"scratch",
     [](Game& g, int) {
       scratch.assign(g.x.rbegin(), g.x.rend());
       scratch.push_back(static_cast<int>(g.tick));
       g.x[0] += scratch[0] % 3;
     }},
    {"particles",
     [](Game& g, int button) {
       particles.push_back({2, 0.5 * g.tick});
       if (particles.size() > 9) particles.pop_front();
       last_particle = std::make_unique<Particle>(particles.back());
       g.x[1] += 2 - button;
     }},
    {"history",
     [](Game& g, int button) {
       history[g.tick % 16] = g;
       g.x[2] += button * 3;
       ++restarts;
     }},
    {"printing",
     [](Game& g, int button) {
       std::printf("tick %u\n", static_cast<unsigned>(g.tick));
       g.x[3] += button;
     }},
    {"large_blocks",
     [](Game& g, int) {
       std::vector<char> large(3 << 20, static_cast<char>(g.tick));
       g.x[0] += large[99] % 3;
     }},
    // Programs that cannot be examined.
    {"without_saves", [](Game& g, int button) { g.x[0] += button; }, false},
    {"threads",
     [](Game& g, int button) {
       static std::thread waits([] { ::pause(); });
       if (g.tick == 149) waits.detach();
       g.x[0] += button;
     }},
    {"crash",
     [](Game& g, int button) {
       if (g.tick == 20 && std::getenv("TICKTRUE_UNSAVED") != nullptr) std::abort();
       g.x[0] += button;
     }},
    {"hang",
     [](Game& g, int button) {
       if (g.tick == 20 && std::getenv("TICKTRUE_UNSAVED") != nullptr) ::pause();
       g.x[0] += button;
     }},
    {"diverges", [](Game& g, int button) { g.x[0] += button + (std::getenv("TICKTRUE_UNSAVED") != nullptr); }},
    // A save that lacks `turns`. From the third process on, ticks end differently, so one copy does not repeat another.
    {"instances",
     [](Game& g, int button) {
       static const int file = ::memfd_create("instances", 0);
       static pid_t process = 0;
       static bool is_late = false;
       static int turns = 0;
       if (std::exchange(process, ::getpid()) != ::getpid())
         is_late = ::write(file, "x", 1) == 1 && ::lseek(file, 0, SEEK_CUR) > 2;
       g.x[0] += button + ++turns % 3 + (is_late ? 1 : 0);
     }},
    {"forks",
     [](Game& g, int button) {
       if (g.tick == 3 && ::fork() == 0) ::_exit(0);
       g.x[0] += button;
     }},
};

}  // namespace

int main(int argc, char** argv) {
  static Game game;
  for (const Program& program : programs)
    if (argc > 1 && std::strcmp(argv[1], program.name) == 0)
      return play(game, argc, argv, program.has_saves, [&](int button) { program.step(game, button); });
  return 2;
}
