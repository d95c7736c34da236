// Splits ranges into chunks. Any thread may run a chunk, in any order, with the same result.
// SPDX-License-Identifier: MIT
//
// A chunk writes nothing that another chunk reads or writes. Lists from chunks are concatenated in the order of the
// chunks. The result therefore depends neither on the number of threads nor on the size of the chunks.
#pragma once

#include <cstddef>

namespace ticktrue {

/// Elements begin..end-1 of a range; `index` counts the chunks of the range.
struct Chunk {
  std::size_t index;
  std::size_t begin;
  std::size_t end;
};

/// Lines of steps with dependencies (a wavefront). Step s of a line runs after the steps before s of this line. It also
/// runs after the steps before s + lag of the previous line.
struct Lines {
  std::size_t line_count;
  std::size_t step_count;  // of each line
  std::size_t lag;
};

/// Runs chunks, for example on the threads of base/parallel/workers.h.
class ChunkRunner {
 public:
  using Work = void (*)(const void* context, const Chunk& chunk);
  using LineWork = void (*)(const void* context, std::size_t line, std::size_t step);

  virtual ~ChunkRunner() = default;
  /// Calls work(context, chunk) once for each chunk of `count` elements, and returns when all chunks are done. The last
  /// chunk may be shorter than `chunk_size`. Requires: chunk_size > 0; no run within a run.
  virtual void run(std::size_t count, std::size_t chunk_size, Work work, const void* context) = 0;
  /// Calls work(context, line, step) once for each step, and returns when all steps are done. Requires: no run within a
  /// run.
  virtual void run_lines(const Lines& lines, LineWork work, const void* context) {
    for (std::size_t line = 0; line < lines.line_count; ++line)
      for (std::size_t step = 0; step < lines.step_count; ++step) work(context, line, step);
  }
  /// The number of chunks that can run at once.
  virtual unsigned width() const = 0;
};

/// The execution of a simulation's loops: by a runner, or without a runner each loop as a single chunk.
struct Parallel {
  ChunkRunner* runner = nullptr;
  std::size_t chunk_size_forced = 0;  // for tests: every loop in chunks of this size; 0: chosen for speed

  /// Elements per chunk for a range of `count`. `least`: the smallest number worth giving to another thread, about one
  /// microsecond of work. `step`: the chunk size is a multiple of it, such as a whole batch or a cache line.
  std::size_t chunk_size(std::size_t count, std::size_t least, std::size_t step = 8) const {
    const std::size_t whole = count > 0 ? count : 1;
    if (runner == nullptr) return whole;
    if (chunk_size_forced > 0) return chunk_size_forced;
    if (count < 2 * least) return whole;
    const std::size_t wanted = std::size_t{chunks_per_thread} * runner->width();
    std::size_t chunks = count / least < wanted ? count / least : wanted;
    if (chunks > runner->width()) chunks -= chunks % runner->width();  // the same number for each thread
    const std::size_t size = (count + chunks - 1) / chunks;
    return (size + step - 1) / step * step;
  }
  static std::size_t chunk_count(std::size_t count, std::size_t chunk_size) {
    return (count + chunk_size - 1) / chunk_size;
  }
  /// An upper bound on the number of chunks of a range of up to `count` elements.
  std::size_t chunk_count_max(std::size_t count) const {
    if (runner == nullptr) return 1;
    if (chunk_size_forced > 0) return chunk_count(count, chunk_size_forced) + 1;
    return std::size_t{chunks_per_thread} * runner->width() + 1;
  }

  /// Calls body(chunk) for each chunk. A single chunk runs on the calling thread, at the cost of a call.
  template <typename Body>
  void for_chunks(std::size_t count, std::size_t size, const Body& body) const {
    if (count == 0) return;
    if (size >= count) {
      body(Chunk{0, 0, count});
      return;
    }
    runner->run(
        count, size, [](const void* context, const Chunk& chunk) { (*static_cast<const Body*>(context))(chunk); },
        &body);
  }

  /// Calls body(line, step) for each step. Without a runner the lines run one after another.
  template <typename Body>
  void for_lines(const Lines& lines, const Body& body) const {
    if (runner != nullptr) {
      runner->run_lines(
          lines,
          [](const void* context, std::size_t line, std::size_t step) {
            (*static_cast<const Body*>(context))(line, step);
          },
          &body);
      return;
    }
    for (std::size_t line = 0; line < lines.line_count; ++line)
      for (std::size_t step = 0; step < lines.step_count; ++step) body(line, step);
  }

 private:
  static constexpr unsigned chunks_per_thread = 8;
};

}  // namespace ticktrue
