// Measures the cost of a mark in nanoseconds, and of 1,000 marks as a share of a tick of 1 ms.
// SPDX-License-Identifier: MIT
//
//   bench_marks [MARKS]     1,000 marks of five names in each of 2,000 recorded ticks unless told; the best tick counts
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "include/ticktrue.h"

namespace {

constexpr int tick_count = 2'000;
constexpr double tick_us = 1'000;  // the tick of which the share is taken

struct Best {
  double marks_us = 1e9;
  double tick_us = 1e9;  // begin_tick, marks and end_tick
};

double since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
}

/// `flags`: with or without TICKTRUE_MARKS.
Best record(const std::string& path, std::uint32_t flags, std::uint64_t mark_count) {
  static const char* const names[] = {"rand", "libm.sin", "spawn", "path.find", "shuffle"};
  std::uint64_t state = 0;
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = TICKTRUE_RECORD;
  options.path = path.c_str();
  options.name = "bench";
  options.detail = TICKTRUE_DETAIL_ROOT;
  options.flags = TICKTRUE_OVERWRITE | TICKTRUE_NO_SYNC | TICKTRUE_QUIET | flags;
  ticktrue_session* session = ticktrue_open(&options);
  ticktrue_column(session, "world", "state", &state, TICKTRUE_U64, 1, 1, 0);
  Best best;
  for (int tick = 0; tick < tick_count; ++tick) {
    const auto begin = std::chrono::steady_clock::now();
    ticktrue_begin_tick(session, nullptr);
    const auto first = std::chrono::steady_clock::now();
    for (std::uint64_t i = 0; i < mark_count; ++i) ticktrue_mark(session, names[i % 5], state + i);
    best.marks_us = std::min(best.marks_us, since(first));
    ++state;
    ticktrue_end_tick(session);
    best.tick_us = std::min(best.tick_us, since(begin));
  }
  ticktrue_close(session);
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  const std::uint64_t mark_count = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1'000;
  if (mark_count == 0) return 2;
  const std::string path = "bench_marks.ttr";
  const Best on = record(path, TICKTRUE_MARKS, mark_count);
  const Best without = record(path, TICKTRUE_MARKS, 0);
  std::remove(path.c_str());
  std::printf("%.2f ns a mark\n", 1'000 * on.marks_us / static_cast<double>(mark_count));
  std::printf("%llu marks a tick: %.1f us with what is written, %.2f %% of a tick of 1 ms\n",
              static_cast<unsigned long long>(mark_count), on.tick_us - without.tick_us,
              100 * (on.tick_us - without.tick_us) / tick_us);
  return 0;
}
