// Independent jobs on every core, in builds that have threads.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>

#include "base/result.h"

namespace ticktrue {

/// The number of threads that can run at once on this machine; 1 in a build without threads.
unsigned core_count();

/// Calls job(0), job(1), ... job(job_count - 1), each once, on at most `thread_count` threads, and returns when all
/// jobs are done. Each thread first checks its own floating point settings. Errors: those of check_float_behaviour.
Status run_jobs(std::size_t job_count, unsigned thread_count, const std::function<void(std::size_t)>& job);

}  // namespace ticktrue
