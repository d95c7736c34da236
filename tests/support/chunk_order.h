// Runs chunks one by one in another order than theirs: what depends on their order shows each time, without any luck.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/parallel.h"

namespace ticktrue::test {

class ChunkOrder final : public ChunkRunner {
 public:
  explicit ChunkOrder(bool reversed, unsigned width = 4) : reversed_(reversed), width_(width) {}

  /// Backwards; else those of odd numbers first.
  void run(std::size_t count, std::size_t chunk_size, Work work, const void* context) override {
    ++run_count;
    const std::size_t chunk_count = Parallel::chunk_count(count, chunk_size);
    const std::size_t odd_count = chunk_count / 2;
    for (std::size_t i = 0; i < chunk_count; ++i) {
      const std::size_t odd_first = i < odd_count ? 2 * i + 1 : 2 * (i - odd_count);
      const std::size_t index = reversed_ ? chunk_count - 1 - i : odd_first;
      const std::size_t begin = index * chunk_size;
      const std::size_t end = begin + chunk_size < count ? begin + chunk_size : count;
      work(context, {index, begin, end});
    }
  }
  unsigned width() const override { return width_; }

  std::size_t run_count = 0;

 private:
  bool reversed_;
  unsigned width_;
};

}  // namespace ticktrue::test
