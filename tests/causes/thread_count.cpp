// Cause: a sum is divided among as many threads as the machine has processors. The order of float additions differs.
// SPDX-License-Identifier: MIT
#include <thread>
#include <vector>

#include "tests/causes/game.h"

namespace {

double wind(std::uint64_t tick, unsigned part_count) {
  std::vector<double> sums(part_count);
  std::vector<std::thread> threads;
  for (unsigned part = 0; part < part_count; ++part)
    threads.emplace_back([&, part] {
      for (unsigned i = part; i < 1000; i += part_count) sums[part] += 1.0 / (1.0 + i + static_cast<double>(tick));
    });
  for (std::thread& thread : threads) thread.join();
  double sum = 0;
  for (const double part : sums) sum += part;
  return sum;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick % 16 != 9) return;
  const unsigned processors = std::thread::hardware_concurrency();
  game.units[6].velocity += wind(tick, is_mended ? 4 : (processors > 0 ? processors : 1));
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("thread_count", argc, argv, rules);
}
