// Clean: threads divide fixed parts among themselves, and each writes its result to its own place.
// SPDX-License-Identifier: MIT
#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  if (tick % 4 != 0) return;
  std::mutex lock;
  std::uint32_t next = 0;
  double results[gallery::unit_count] = {};
  const auto work = [&] {
    for (;;) {
      std::uint32_t part = 0;
      {
        const std::lock_guard<std::mutex> guard(lock);
        part = next++;
      }
      if (part >= gallery::unit_count) return;
      for (int i = 1; i < 300; ++i) results[part] += game.units[part].position / i;
    }
  };
  std::vector<std::thread> threads;
  const unsigned count = std::thread::hardware_concurrency() + 1;
  for (unsigned i = 0; i < count; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  for (std::uint32_t part = 0; part < gallery::unit_count; ++part) game.units[part].velocity += 1e-2 * results[part];
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("threads", argc, argv, rules);
}
