// A script for Slurm: an array of workers that share a corpus by claims, and a report when all have ended.
// SPDX-License-Identifier: MIT
//
// Verified: the script is a POSIX shell script whose parts run without Slurm. Not verified: the words for sbatch, on
// a cluster.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ticktrue::tool {

struct SlurmJob {
  std::string tool;                       // path of the program
  std::vector<std::string> traces;        // absolute paths
  std::string store;                      // absolute path
  std::vector<std::string> verify_words;  // more options of `corpus verify`, and of `corpus report`
  std::vector<std::string> report_words;
  std::string folder;           // absolute: where worker and report run; empty: anywhere
  std::string sbatch_words;     // as they are, behind both calls of sbatch; may be empty
  std::uint64_t cpu_count = 1;  // of a task
  std::uint64_t task_count_max = 1000;
  std::uint64_t task_minutes = 10;  // work that a task should have
};

/// What the cost of a corpus asks for.
struct SlurmSize {
  std::uint64_t task_count = 1;
  std::uint64_t limit_minutes = 1;  // of a task, with a reserve
  double work_s = 0;                // of all tasks, for one processor
};
SlurmSize slurm_size(const std::vector<double>& costs, const SlurmJob& job);

std::string slurm_script(const SlurmJob& job, const SlurmSize& size);

}  // namespace ticktrue::tool
