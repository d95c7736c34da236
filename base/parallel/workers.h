// Threads that wait for chunks: spinning for a moment, then asleep.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "base/parallel/parallel.h"
#include "base/result.h"

namespace ticktrue {

inline constexpr unsigned thread_count_max = 64;

/// A runner of `thread_count` threads, of which the one that calls run() is the first. It never waits for a thread that
/// has not taken a chunk, so that a busy machine costs little; where threads that have taken one are late, it works
/// alone for a while. Chunks are dealt out in equal runs, one per thread, so that a thread meets the same memory again;
/// who is done takes from the others. Null for one thread. Errors: limit; unsupported (a build without threads, or a
/// thread's floating point is not IEEE 754's).
Result<std::unique_ptr<ChunkRunner>> make_workers(unsigned thread_count);

}  // namespace ticktrue
