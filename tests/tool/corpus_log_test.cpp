// The history of a trace, and the script for a cluster.
// SPDX-License-Identifier: MIT
#include <cstdint>
#include <string>
#include <vector>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "tool/corpus/slurm_script.h"
#include "tool/corpus/trace_log.h"
#include "verifier/runs/child.h"

namespace ticktrue::test {
namespace {

using tool::SlurmJob;
using tool::SlurmSize;
using tool::TraceLog;
using verifier::HistoryRow;
using verifier::TraceHistory;

HistoryRow log_row(const std::string& commit, const std::string& verdict, const std::string& mode = "replay") {
  HistoryRow row;
  row.commit = commit;
  row.verdict = verdict;
  row.mode = mode;
  return row;
}

TraceLog log_of_rows(std::vector<HistoryRow> rows) {
  TraceHistory history;
  history.rows = std::move(rows);
  return tool::log_of(std::move(history), "replay");
}

SlurmJob plain_job() {
  SlurmJob job;
  job.tool = "/opt/tick true/ticktrue";
  job.traces = {"/data/it's a corpus"};
  job.store = "/data/verdicts";
  job.cpu_count = 4;
  return job;
}

}  // namespace

TEST_CASE("corpus log: the first build with other bits is named, with the last match before it",
          "[verifier][corpus][log][analytic]") {
  const TraceLog log = log_of_rows({log_row("a", "match"), log_row("b", "match"), log_row("x", "diverged", "twice"),
                                    log_row("c", "diverged"), log_row("d", "match"), log_row("e", "diverged")});
  REQUIRE(log.rows.size() == 5);
  REQUIRE(log.changed);
  CHECK(log.rows[*log.changed].commit == "c");
  REQUIRE(log.last_match);
  CHECK(log.rows[*log.last_match].commit == "b");

  const TraceLog unchanged = log_of_rows({log_row("a", "match"), log_row("b", "not_comparable")});
  CHECK(!unchanged.changed);
  CHECK(unchanged.last_match == std::size_t{0});
  const TraceLog always = log_of_rows({log_row("a", "diverged"), log_row("b", "match")});
  CHECK(always.changed == std::size_t{0});
  CHECK(!always.last_match);
}

TEST_CASE("corpus log: times are those of the calendar", "[verifier][corpus][log][analytic]") {
  CHECK(tool::time_text(0) == "1970-01-01 00:00:00");
  CHECK(tool::time_text(951'827'696) == "2000-02-29 12:34:56");
}

TEST_CASE("corpus slurm: the array is sized by cost", "[verifier][corpus][slurm][analytic]") {
  SlurmJob job = plain_job();
  // Two hours for one processor are half an hour for four, or three tasks of ten minutes.
  const std::vector<double> hours(7200, 1.0);
  SlurmSize size = tool::slurm_size(hours, job);
  CHECK(size.work_s == 7200);
  CHECK(size.task_count == 3);
  CHECK(size.limit_minutes > 30);
  CHECK(size.limit_minutes < 35);
  job.task_count_max = 2;
  CHECK(tool::slurm_size(hours, job).task_count == 2);
  CHECK(tool::slurm_size({1e6}, plain_job()).task_count == 1);
  CHECK(tool::slurm_size({}, plain_job()).task_count == 1);
  CHECK(tool::slurm_size({0, 0}, plain_job()).limit_minutes == 10);
}

TEST_CASE("corpus slurm: the script is one for any POSIX shell, whatever the names are",
          "[verifier][corpus][slurm][analytic]") {
  const TemporaryFolder folder;
  const std::string script = folder.file("job.sh");
  const std::string text = tool::slurm_script(plain_job(), SlurmSize{16, 30, 1234});
  write_file(script, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  verifier::ChildCommand command;
  command.argv = {"sh", "-n", script};
  const verifier::ChildResult result = verifier::run_child(command);
  INFO(result.message);
  CHECK(result.end.exit_status == 0);
  CHECK(contains(text, "--array=1-16 --cpus-per-task=4 --time=30"));
  CHECK_FALSE(contains(text, "requeue \"$SLURM_JOB_ID\""));  // the last task would requeue the whole array
  CHECK(contains(text, "id=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID\n"));
  CHECK(contains(text, "tool=${TICKTRUE:-'/opt/tick true/ticktrue'}"));
  CHECK(contains(text, R"('/data/it'\''s a corpus')"));
}

}  // namespace ticktrue::test
