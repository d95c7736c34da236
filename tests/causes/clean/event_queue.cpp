// Clean: a queue of events by time and number, in which no two are equal.
// SPDX-License-Identifier: MIT
#include <queue>
#include <vector>

#include "tests/causes/game.h"

namespace {

struct Event {
  std::uint64_t tick;
  std::uint32_t number;
  bool operator<(const Event& other) const { return tick != other.tick ? tick > other.tick : number > other.number; }
};

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  static std::priority_queue<Event> queue;
  static std::uint32_t number = 0;
  for (int i = 0; i < 5; ++i, ++number) queue.push({tick + number * number % 11, number});
  while (!queue.empty() && queue.top().tick <= tick) {
    game.units[queue.top().number % gallery::unit_count].score += static_cast<std::int64_t>(queue.size());
    queue.pop();
  }
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("event_queue", argc, argv, rules);
}
