// Worker threads that wait for chunks: they spin for a short time, then sleep.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "base/parallel/parallel.h"
#include "base/result.h"

namespace ticktrue {

inline constexpr unsigned thread_count_max = 64;

/// A runner of `thread_count` threads; the thread that calls run() is the first. The caller never waits for a thread
/// that has not taken a chunk, so that a busy machine costs little. If threads with a taken chunk are late, the caller
/// works alone for a while. Each thread gets an equal share of consecutive chunks, so that it reuses the same memory. A
/// thread that has finished its share takes chunks of other shares. Null for one thread. Errors: limit; unsupported (a
/// build without threads, or a thread whose floating point does not follow IEEE 754).
Result<std::unique_ptr<ChunkRunner>> make_workers(unsigned thread_count);

}  // namespace ticktrue
