// Clean: clocks are read for measurements and waiting; no clock reaches the state.
// SPDX-License-Identifier: MIT
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <mutex>
#include <thread>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  const auto start = std::chrono::steady_clock::now();
  std::mutex lock;
  std::condition_variable never;
  std::unique_lock<std::mutex> held(lock);
  never.wait_for(held, std::chrono::microseconds(200));
  never.wait_until(held, std::chrono::system_clock::now() + std::chrono::microseconds(100));
  std::this_thread::sleep_for(std::chrono::microseconds(50));
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  if (tick == 59)
    std::printf("last tick: %.3f ms at %lld\n", 1e3 * passed.count(), static_cast<long long>(std::time(nullptr)));
  game.units[tick % 3].score += 1;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("clocks", argc, argv, rules);
}
