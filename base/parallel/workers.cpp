// The worker threads, and their algorithm for taking chunks.
// SPDX-License-Identifier: MIT
//
// A run distributes its chunks as one share per thread. One atomic word of a share holds the run number and the range
// of remaining chunks; the job is stored next to the word. A thread takes a chunk by advancing the range with
// compare-and-swap. The operation fails if the run has changed since the job was read: a job is not replaced while a
// chunk of its run remains. A sleeping thread can therefore join at any time. The caller waits only for chunks that
// other threads have taken.
#include "base/parallel/workers.h"

#include <string>

#ifdef TICKTRUE_HAS_THREADS
#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "base/float_behaviour.h"
#endif

namespace ticktrue {

#ifdef TICKTRUE_HAS_THREADS

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::microseconds idle_max{200};  // a worker spins for this time before it sleeps
constexpr std::chrono::microseconds late_max{200};  // the caller spins for this time before it sleeps
constexpr unsigned spins_per_clock_check = 32;      // between two reads of the clock
// If the caller waits longer than lost_least, a worker has lost its core. The caller then works alone, with exponential
// backoff: the time alone is a multiple of the wait, and the multiple doubles with each wait. The multiple is reset
// after a time without waits. A core that another program uses then costs a few percent.
constexpr std::chrono::microseconds lost_least{1000};
constexpr int backoff_factor_min = 4;
constexpr int backoff_factor_max = 64;
constexpr int backoff_reset_factor = 4;  // multiple of the time alone after which the backoff is reset

void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

/// Calls done() until it returns true or `limit` has passed. Returns the last result of done().
template <typename Done>
bool spin(std::chrono::microseconds limit, Done done) {
  Clock::time_point end{};
  for (;;) {
    for (unsigned i = 0; i < spins_per_clock_check; ++i) {
      if (done()) return true;
      relax();
    }
    const Clock::time_point now = Clock::now();
    if (end == Clock::time_point{}) end = now + limit;
    if (now >= end) return false;
    if (end - now < limit / 2) std::this_thread::yield();  // there may be more threads than cores
  }
}

// A share: run << 32 | chunks taken so far << 16 | end of the chunks.
constexpr std::size_t chunk_count_max = 0xffff;
struct Share {
  std::uint32_t run;
  std::uint32_t next;
  std::uint32_t end;
};
std::uint64_t packed(Share share) {
  return std::uint64_t{share.run} << 32 | std::uint64_t{share.next} << 16 | share.end;
}
Share unpacked(std::uint64_t word) {
  return {static_cast<std::uint32_t>(word >> 32), static_cast<std::uint32_t>(word >> 16 & 0xffff),
          static_cast<std::uint32_t>(word & 0xffff)};
}

/// A share and the job of its run, in one cache line, so that a waiting thread reads both at once. The job is atomic,
/// since a late thread may read a job that it then does not run.
struct alignas(64) Slot {
  std::atomic<std::uint64_t> share{0};
  std::atomic<std::size_t> count{0};
  std::atomic<std::size_t> chunk_size{1};
  std::atomic<ChunkRunner::Work> work{nullptr};
  std::atomic<const void*> context{nullptr};
};

class Workers final : public ChunkRunner {
 public:
  explicit Workers(unsigned thread_count) : slots_(thread_count), lines_done_(thread_count) {}

  ~Workers() override {
    {
      const std::lock_guard<std::mutex> guard(lock_);
      stopping_.store(true, std::memory_order_relaxed);
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  /// Starts the threads. Each thread first checks its floating point settings.
  Status start() {
    for (unsigned i = 1; i < slots_.size(); ++i) {
      try {
        threads_.emplace_back([this, i] { serve(i); });
      } catch (const std::system_error&) {
        return Error{ErrorCode::limit,
                     "threads: found room for " + std::to_string(i) + ", expected " + std::to_string(slots_.size()),
                     "ask for fewer"};
      }
    }
    std::unique_lock<std::mutex> guard(lock_);
    started_.wait(guard, [this] { return verdict_count_ == threads_.size(); });
    return verdict_;
  }

  unsigned width() const override { return static_cast<unsigned>(slots_.size()); }

  void run(std::size_t count, std::size_t chunk_size, Work work, const void* context) override {
    distribute(count, chunk_size, slots_.size(), work, context);
  }

  void run_lines(const Lines& lines, LineWork work, const void* context) override {
    if (lines_done_.size() < lines.line_count) lines_done_ = std::vector<LineProgress>(lines.line_count);
    for (std::size_t line = 0; line < lines.line_count; ++line)
      lines_done_[line].steps.store(0, std::memory_order_relaxed);
    // Each line is a chunk. All lines are in one share, so that threads take lines in order.
    const LineRun all{lines, work, context, lines_done_.data()};
    distribute(
        lines.line_count, 1, 1,
        [](const void* of, const Chunk& chunk) { run_line(*static_cast<const LineRun*>(of), chunk.index); }, &all);
  }

 private:
  struct alignas(64) LineProgress {
    std::atomic<std::size_t> steps{0};  // done
  };
  struct LineRun {
    Lines lines;
    LineWork work;
    const void* context;
    LineProgress* done;  // [line]
  };

  /// Runs chunks. `share_count`: the number of threads that get a share.
  void distribute(std::size_t count, std::size_t chunk_size, std::size_t share_count, Work work, const void* context) {
    const std::size_t chunk_count = Parallel::chunk_count(count, chunk_size);
    if (chunk_count > chunk_count_max || is_alone()) {
      for (std::size_t i = 0; i < chunk_count; ++i) work(context, chunk_of(i, count, chunk_size));
      return;
    }
    done_.store(0, std::memory_order_relaxed);
    ++run_;
    for (std::size_t i = slots_.size(); i-- > 0;) {
      const auto begin = static_cast<std::uint32_t>(chunk_count * std::min(i, share_count) / share_count);
      const auto end = static_cast<std::uint32_t>(chunk_count * std::min(i + 1, share_count) / share_count);
      Slot& slot = slots_[i];
      slot.count.store(count, std::memory_order_relaxed);
      slot.chunk_size.store(chunk_size, std::memory_order_relaxed);
      slot.work.store(work, std::memory_order_relaxed);
      slot.context.store(context, std::memory_order_relaxed);
      slot.share.store(packed({run_, begin, end}), std::memory_order_release);
    }
    if (some_sleep_.load(std::memory_order_relaxed)) {
      const std::lock_guard<std::mutex> guard(lock_);
      some_sleep_.store(false, std::memory_order_relaxed);  // waking takes longer than many runs: requested once
      wake_.notify_all();
    }
    std::size_t by_others = chunk_count;
    for (std::size_t turn = 0; turn < slots_.size(); ++turn) by_others -= take_chunks(slot_of(0, turn));
    if (by_others > 0) wait_for(by_others);
  }

  static void run_line(const LineRun& run, std::size_t line) {
    std::size_t ahead = line == 0 ? run.lines.step_count : 0;  // known finished steps of the line before
    for (std::size_t step = 0; step < run.lines.step_count; ++step) {
      const std::size_t needed = std::min(step + run.lines.lag, run.lines.step_count);
      const auto may_go = [&] {
        if (ahead < needed) ahead = run.done[line - 1].steps.load(std::memory_order_acquire);
        return ahead >= needed;
      };
      while (!spin(late_max, may_go)) {
      }
      run.work(run.context, line, step);
      run.done[line].steps.store(step + 1, std::memory_order_release);
    }
  }

  static Chunk chunk_of(std::size_t index, std::size_t count, std::size_t chunk_size) {
    const std::size_t begin = index * chunk_size;
    return {index, begin, std::min(begin + chunk_size, count)};
  }

  /// The order in which a thread tries the shares: its own share, then the shares after it.
  Slot& slot_of(unsigned self, std::size_t turn) { return slots_[(self + turn) % slots_.size()]; }

  /// Takes chunks of a share until none remains. Returns the number of taken chunks.
  static std::size_t take_chunks(Slot& slot) {
    std::size_t taken = 0;
    std::uint64_t word = slot.share.load(std::memory_order_acquire);
    for (;;) {
      const Share share = unpacked(word);
      if (share.next >= share.end) return taken;
      const std::size_t count = slot.count.load(std::memory_order_relaxed);
      const std::size_t chunk_size = slot.chunk_size.load(std::memory_order_relaxed);
      const Work work = slot.work.load(std::memory_order_relaxed);
      const void* context = slot.context.load(std::memory_order_relaxed);
      const std::uint64_t after = packed({share.run, share.next + 1, share.end});
      if (!slot.share.compare_exchange_weak(word, after, std::memory_order_acq_rel, std::memory_order_acquire))
        continue;
      work(context, chunk_of(share.next, count, chunk_size));
      ++taken;
      word = slot.share.load(std::memory_order_acquire);
    }
  }

  /// Reports the finished chunks of a worker to the caller.
  void report(std::size_t taken) {
    if (taken == 0) return;
    done_.fetch_add(taken);
    if (!caller_waits_.load()) return;
    const std::lock_guard<std::mutex> guard(lock_);
    finished_.notify_all();
  }

  /// Waits until other threads have finished `count` chunks.
  void wait_for(std::size_t count) {
    const auto all_done = [&] { return done_.load(std::memory_order_acquire) == count; };
    if (spin(late_max, all_done)) return;
    const Clock::time_point start = Clock::now();
    {
      std::unique_lock<std::mutex> guard(lock_);
      caller_waits_.store(true);
      finished_.wait(guard, [&] { return done_.load() == count; });
      caller_waits_.store(false);
    }
    const Clock::time_point now = Clock::now();
    if (now - start < lost_least) return;
    backoff_factor_ = now < backoff_reset_ ? std::min(backoff_factor_ * 2, backoff_factor_max) : backoff_factor_min;
    works_alone_ = true;
    alone_end_ = now + (now - start) * backoff_factor_;
    backoff_reset_ = alone_end_ + (now - start) * backoff_factor_ * backoff_reset_factor;
  }

  bool is_alone() {
    if (works_alone_ && Clock::now() >= alone_end_) works_alone_ = false;
    return works_alone_;
  }

  void serve(unsigned self) {
    {
      const Status verdict = check_float_behaviour();
      const std::lock_guard<std::mutex> guard(lock_);
      if (!verdict) verdict_ = verdict;
      ++verdict_count_;
      started_.notify_all();
    }
    std::uint32_t seen = 0;
    const auto has_new_run = [&] {
      return unpacked(slots_[self].share.load(std::memory_order_acquire)).run != seen ||
             stopping_.load(std::memory_order_relaxed);
    };
    for (;;) {
      if (!spin(idle_max, has_new_run)) {
        std::unique_lock<std::mutex> guard(lock_);
        while (!has_new_run()) {
          some_sleep_.store(true, std::memory_order_relaxed);
          wake_.wait(guard);
        }
      }
      if (stopping_.load(std::memory_order_relaxed)) return;
      seen = unpacked(slots_[self].share.load(std::memory_order_acquire)).run;
      // A thread tries its own share first: a check of another share costs as much as a small chunk.
      for (std::size_t turn = 0; turn < slots_.size(); ++turn) report(take_chunks(slot_of(self, turn)));
    }
  }

  std::vector<Slot> slots_;                          // [thread]
  std::vector<LineProgress> lines_done_;             // [line]
  alignas(64) std::atomic<std::size_t> done_{0};     // chunks of the run that other threads have finished
  std::atomic<bool> caller_waits_{false};            // asleep
  alignas(64) std::atomic<bool> some_sleep_{false};  // some worker sleeps and has not been woken
  std::atomic<bool> stopping_{false};

  // For the caller alone.
  std::uint32_t run_ = 0;
  bool works_alone_ = false;
  int backoff_factor_ = backoff_factor_min;
  Clock::time_point alone_end_;
  Clock::time_point backoff_reset_;  // a wait before this time doubles the backoff

  std::mutex lock_;
  std::condition_variable wake_, finished_, started_;
  Status verdict_;
  std::size_t verdict_count_ = 0;
  std::vector<std::thread> threads_;
};

}  // namespace

#endif

Result<std::unique_ptr<ChunkRunner>> make_workers(unsigned thread_count) {
  if (thread_count == 1) return std::unique_ptr<ChunkRunner>();
  if (thread_count < 1 || thread_count > thread_count_max)
    return Error{ErrorCode::limit,
                 "threads: found " + std::to_string(thread_count) + ", expected 1.." + std::to_string(thread_count_max),
                 ""};
#ifdef TICKTRUE_HAS_THREADS
  auto workers = std::make_unique<Workers>(thread_count);
  if (const Status status = workers->start(); !status) return status.error();
  return std::unique_ptr<ChunkRunner>(std::move(workers));
#else
  return Error{ErrorCode::unsupported,
               "threads: found " + std::to_string(thread_count) + ", expected 1: this build has no threads",
               "the results are the same with one"};
#endif
}

}  // namespace ticktrue
