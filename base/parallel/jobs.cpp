// Threads that take jobs from one counter. The assignment of jobs to threads changes no result.
// SPDX-License-Identifier: MIT
#include "base/parallel/jobs.h"

#include <algorithm>
#include <atomic>
#include <vector>
#ifdef TICKTRUE_HAS_THREADS
#include <thread>
#endif

#include "base/float_behaviour.h"

namespace ticktrue {

#ifdef TICKTRUE_HAS_THREADS

unsigned core_count() {
  return std::max(1u, std::thread::hardware_concurrency());
}

Status run_jobs(std::size_t job_count, unsigned thread_count, const std::function<void(std::size_t)>& job) {
  std::atomic<std::size_t> next{0};
  std::vector<Status> verdicts(std::min<std::size_t>(std::max(1u, thread_count), std::max<std::size_t>(1, job_count)));
  const auto work = [&](Status& verdict) {
    verdict = check_float_behaviour();
    if (!verdict) return;
    for (std::size_t i = next.fetch_add(1); i < job_count; i = next.fetch_add(1)) job(i);
  };
  std::vector<std::thread> threads;
  for (std::size_t i = 1; i < verdicts.size(); ++i) threads.emplace_back(work, std::ref(verdicts[i]));
  work(verdicts[0]);
  for (std::thread& thread : threads) thread.join();
  for (const Status& verdict : verdicts)
    if (!verdict) return verdict;
  return {};
}

#else

unsigned core_count() {
  return 1;
}

Status run_jobs(std::size_t job_count, unsigned, const std::function<void(std::size_t)>& job) {
  const Status verdict = check_float_behaviour();
  for (std::size_t i = 0; verdict && i < job_count; ++i) job(i);
  return verdict;
}

#endif

}  // namespace ticktrue
