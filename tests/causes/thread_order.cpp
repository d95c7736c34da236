// Cause: threads append to one list, and the first one moves first.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick % 6 != 5) return;
  std::mutex lock;
  std::vector<std::uint32_t> arrived;
  const auto has_arrived = [&](std::uint32_t count_before) {
    const std::lock_guard<std::mutex> guard(lock);
    return arrived.size() > count_before;
  };
  std::vector<std::thread> threads;
  for (std::uint32_t i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      const std::lock_guard<std::mutex> guard(lock);
      arrived.push_back(i);
    });
    // The next thread starts after this one is done, or after about 27 ms. A loaded machine seldom takes
    // that long, and thread_start waits for up to 50 ms.
    for (int wait = 0; wait < 25 && !has_arrived(i); ++wait) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  for (std::thread& thread : threads) thread.join();
  if (is_mended) std::sort(arrived.begin(), arrived.end());
  for (std::size_t i = 0; i < arrived.size(); ++i) game.units[arrived[i]].score += static_cast<std::int64_t>(i);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("thread_order", argc, argv, rules);
}
