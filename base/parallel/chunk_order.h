// Runs chunks one at a time in another order, so that a dependency on the order shows in every run.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <vector>

#include "base/parallel/parallel.h"

namespace ticktrue {

class ChunkOrder final : public ChunkRunner {
 public:
  explicit ChunkOrder(bool reversed, unsigned width = 4) : reversed_(reversed), width_(width) {}

  /// Runs chunks backwards if reversed; otherwise chunks of odd index first.
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
  /// If reversed, runs each line as early as its dependencies allow; otherwise one line after another, as late as
  /// possible.
  void run_lines(const Lines& lines, LineWork work, const void* context) override {
    ++line_run_count;
    if (!reversed_) return ChunkRunner::run_lines(lines, work, context);
    std::vector<std::size_t> done(lines.line_count, 0);
    while (done.back() < lines.step_count)
      for (std::size_t line = lines.line_count; line-- > 0;) {
        const std::size_t needed = std::min(done[line] + lines.lag, lines.step_count);
        if (done[line] == lines.step_count || (line > 0 && done[line - 1] < needed)) continue;
        work(context, line, done[line]++);
      }
  }
  unsigned width() const override { return width_; }

  std::size_t run_count = 0;
  std::size_t line_run_count = 0;

 private:
  bool reversed_;
  unsigned width_;
};

}  // namespace ticktrue
