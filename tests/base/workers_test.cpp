// Workers run each chunk once with any number of threads. Ranges are split as documented. Threads with different
// arithmetic are refused.
// SPDX-License-Identifier: MIT
#include "base/parallel/workers.h"

#include <atomic>
#include <chrono>
#include <vector>

#include "base/build_info.h"
#include "tests/support/catch.h"

namespace ticktrue {
namespace {

bool has_threads() {
  return build_info().has_threads;
}

/// Runs a range and counts how often each element was visited.
std::vector<int> visits(ChunkRunner& runner, std::size_t count, std::size_t chunk_size) {
  std::vector<int> visited(count);
  Parallel{&runner}.for_chunks(count, chunk_size, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) ++visited[i];
  });
  return visited;
}

void pass(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
  }
}

}  // namespace

TEST_CASE("one thread needs no workers, and thread counts out of range are refused", "[base][workers]") {
  CHECK((*make_workers(1)) == nullptr);
  for (const unsigned thread_count : {0u, thread_count_max + 1}) {
    const auto refused = make_workers(thread_count);
    REQUIRE(!refused.has_value());
    CHECK(refused.error().code == ErrorCode::limit);
    CHECK(refused.error().message == "threads: found " + std::to_string(thread_count) + ", expected 1..64");
  }
}

TEST_CASE("a build without threads says so", "[base][workers]") {
  const auto made = make_workers(2);
  CHECK(made.has_value() == has_threads());
  if (!made.has_value()) CHECK(made.error().code == ErrorCode::unsupported);
}

TEST_CASE("every element of a range is visited once, by any number of threads", "[base][workers][determinism]") {
  SKIP_UNLESS(has_threads(), "a build without threads");
  for (const unsigned thread_count : {2u, 3u, 4u, 8u}) {
    const auto workers = *make_workers(thread_count);
    CHECK(workers->width() == thread_count);
    for (int round = 0; round < 20; ++round)
      for (const std::size_t count : {0, 1, 7, 8, 64, 1000, 70000})
        for (const std::size_t chunk_size : {1, 3, 8, 1000}) {
          const std::vector<int> visited = visits(*workers, count, chunk_size);
          CAPTURE(thread_count, count, chunk_size);
          REQUIRE(visited == std::vector<int>(count, 1));
        }
  }
}

TEST_CASE("threads that fell asleep between runs come again", "[base][workers]") {
  SKIP_UNLESS(has_threads(), "a build without threads");
  const auto workers = *make_workers(2);
  static thread_local char here;
  const char* const caller = &here;
  std::atomic<bool> others_came{false};
  const auto work = [&](const Chunk&) {
    if (&here != caller) others_came.store(true);
    pass(std::chrono::microseconds(20));
  };
  for (int pause = 0; pause < 20; ++pause) {
    pass(std::chrono::milliseconds(2));  // long enough for an idle thread to sleep
    others_came.store(false);
    // The other thread is awake in at least one of many runs, even on a busy machine.
    for (int run = 0; run < 20'000 && !others_came.load(); ++run) Parallel{workers.get()}.for_chunks(16, 1, work);
    CAPTURE(pause);
    REQUIRE(others_came.load());
  }
}

TEST_CASE("what chunks write is seen by the caller and by the next run", "[base][workers][determinism]") {
  SKIP_UNLESS(has_threads(), "a build without threads");
  const auto workers = *make_workers(4);
  const Parallel parallel{workers.get()};
  std::vector<std::uint64_t> numbers(500, 1);
  for (int round = 0; round < 3000; ++round)
    parallel.for_chunks(numbers.size(), 16, [&](const Chunk& chunk) {
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) numbers[i] = numbers[i] * 3 + chunk.index;
    });
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    std::uint64_t expected = 1;
    for (int round = 0; round < 3000; ++round) expected = expected * 3 + i / 16;
    REQUIRE(numbers[i] == expected);
  }
}

TEST_CASE("ranges that are too short for two threads are one chunk", "[base][workers]") {
  struct Wide final : ChunkRunner {
    void run(std::size_t, std::size_t, Work, const void*) override {}
    unsigned width() const override { return 2; }
  } runner;
  Parallel parallel;
  CHECK(parallel.chunk_size(1000, 10) == 1000);  // no thread to share with
  CHECK(parallel.chunk_count_max(1000) == 1);
  parallel.runner = &runner;
  CHECK(parallel.chunk_size(0, 10) == 1);
  CHECK(parallel.chunk_size(19, 10) == 19);
  CHECK(parallel.chunk_size(20, 10) == 16);
  for (std::size_t count = 20; count < 5000; ++count) {
    const std::size_t size = parallel.chunk_size(count, 10);
    REQUIRE(size % 8 == 0);
    REQUIRE(Parallel::chunk_count(count, parallel.chunk_size(count, 10, 1)) < parallel.chunk_count_max(count));
    REQUIRE(Parallel::chunk_count(count, size) < parallel.chunk_count_max(count));
  }
  parallel.chunk_size_forced = 3;
  CHECK(parallel.chunk_size(19, 10) == 3);
  CHECK(Parallel::chunk_count(19, 3) == 7);
}

}  // namespace ticktrue
