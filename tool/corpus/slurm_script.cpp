// Size and text of the script.
// SPDX-License-Identifier: MIT
#include "tool/corpus/slurm_script.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/count_text.h"
#include "verifier/report/report.h"

namespace ticktrue::tool {
namespace {

constexpr double seconds_of_minute = 60;
constexpr double reserve_factor = 3;  // nodes differ, and a task may do the work of others that ended
constexpr double limit_min_minutes = 10;
constexpr int restart_count_max = 3;

std::string words_text(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += " " + verifier::shell_word(word);
  return text;
}

}  // namespace

SlurmSize slurm_size(const std::vector<double>& costs, const SlurmJob& job) {
  SlurmSize size;
  size.work_s = std::accumulate(costs.begin(), costs.end(), 0.0);
  const auto cpu_count = static_cast<double>(std::max<std::uint64_t>(1, job.cpu_count));
  const double minutes = size.work_s / seconds_of_minute / cpu_count;
  const double wanted = std::ceil(minutes / static_cast<double>(std::max<std::uint64_t>(1, job.task_minutes)));
  const auto open_count =
      static_cast<std::uint64_t>(std::count_if(costs.begin(), costs.end(), [](double cost_s) { return cost_s > 0; }));
  const std::uint64_t task_count_max = std::max<std::uint64_t>(1, std::min(job.task_count_max, open_count));
  size.task_count = wanted >= static_cast<double>(task_count_max)
                        ? task_count_max
                        : std::max<std::uint64_t>(1, static_cast<std::uint64_t>(wanted));
  // The first run of a long trace has nothing to cut it by: a task may have it alone.
  const double longest = costs.empty() ? 0 : *std::max_element(costs.begin(), costs.end()) / seconds_of_minute;
  const double limit = reserve_factor * (minutes / static_cast<double>(size.task_count) + longest);
  size.limit_minutes = static_cast<std::uint64_t>(std::ceil(std::max(limit_min_minutes, limit)));
  return size;
}

std::string slurm_script(const SlurmJob& job, const SlurmSize& size) {
  const std::string sbatch_words = job.sbatch_words.empty() ? "" : " " + job.sbatch_words;
  const std::string cpus = std::to_string(job.cpu_count);
  std::string text = "#!/bin/sh\n";
  text += "# A corpus of traces for ticktrue: " + std::to_string(std::llround(size.work_s)) + " s of work in " +
          count_text(size.task_count, "task") + " with " + count_text(job.cpu_count, "processor") + " each.\n";
  text +=
      "#   sh SCRIPT          submits the array of workers, and a report that waits for all of them\n"
      "#   sh SCRIPT worker   one worker, with or without Slurm\n"
      "#   sh SCRIPT report   the report alone\n"
      "# Any number of workers may run, join or end: each takes what no other has.\n"
      "set -u\n";
  text += "tool=${TICKTRUE:-" + verifier::shell_word(job.tool) + "}\n";
  text += "store=" + verifier::shell_word(job.store) + "\n\n";
  const std::string enter = job.folder.empty() ? "" : "  cd " + verifier::shell_word(job.folder) + " || exit 2\n";
  text += "submit() {\n";
  text += "  array=$(sbatch --parsable --job-name=ticktrue --array=1-" + std::to_string(size.task_count) +
          " --cpus-per-task=" + cpus + " --time=" + std::to_string(size.limit_minutes) +
          " --requeue --open-mode=append --output=ticktrue-%A-%a.txt" + sbatch_words + " \"$0\" worker) || exit 2\n";
  text += "  array=${array%%;*}\n";
  text += "  sbatch --job-name=ticktrue-report --dependency=\"afterany:$array\" --cpus-per-task=" + cpus +
          " --output=\"ticktrue-$array-report.txt\"" + sbatch_words + " \"$0\" report || exit 2\n";
  text += "}\n\n";
  text += "worker() {\n" + enter;
  text += "  \"$tool\" corpus verify" + words_text(job.traces) +
          " --cache \"$store\" --claim -j \"${SLURM_CPUS_PER_TASK:-" + cpus + "}\"" + words_text(job.verify_words) +
          "\n";
  text += "  code=$?\n";
  text +=
      "  # These say what is in the traces, and no other run changes that. What is left is the machine's: 2 (a full "
      "disk,\n"
      "  # a file that cannot be read) and signals.\n"
      "  case $code in 0 | 1 | 3 | 4 | 5 | 6) exit \"$code\" ;; esac\n";
  text += "  if [ -n \"${SLURM_JOB_ID:-}\" ] && [ \"${SLURM_RESTART_COUNT:-0}\" -lt " +
          std::to_string(restart_count_max) + " ]; then\n";
  text +=
      "    echo \"exit code $code: the task is queued again\" >&2\n"
      "    # The last task of an array has the number of the array: by that alone, all tasks would be queued again.\n"
      "    id=$SLURM_JOB_ID\n"
      "    [ -z \"${SLURM_ARRAY_TASK_ID:-}\" ] || id=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID\n"
      "    scontrol requeue \"$id\" && sleep 60\n"
      "  fi\n"
      "  exit \"$code\"\n"
      "}\n\n";
  text += "report() {\n" + enter;
  text += "  exec \"$tool\" corpus report \"$store\"" + words_text(job.traces) + words_text(job.report_words) + "\n";
  text += "}\n\n";
  text +=
      "case ${1:-submit} in\n"
      "submit | worker | report) \"${1:-submit}\" ;;\n"
      "*)\n"
      "  echo \"usage: sh $0 [submit | worker | report]\" >&2\n"
      "  exit 2\n"
      "  ;;\n"
      "esac\n";
  return text;
}

}  // namespace ticktrue::tool
