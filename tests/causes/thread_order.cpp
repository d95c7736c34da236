// Cause: threads append to one list, and the first one moves first.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick % 16 != 5) return;
  std::mutex lock;
  std::vector<std::uint32_t> arrived;
  std::vector<std::thread> threads;
  for (std::uint32_t i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      const std::lock_guard<std::mutex> guard(lock);
      arrived.push_back(i);
    });
    // A thread is done long before the next one begins, on a loaded machine, too.
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  for (std::thread& thread : threads) thread.join();
  if (is_mended) std::sort(arrived.begin(), arrived.end());
  for (std::size_t i = 0; i < arrived.size(); ++i) game.units[arrived[i]].score += static_cast<std::int64_t>(i);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("thread_order", argc, argv, rules);
}
