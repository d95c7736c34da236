// Running other programs: output, limits, how they end, and what they leave behind.
// SPDX-License-Identifier: MIT
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/runs/child.h"
#include "verifier/runs/child_process.h"

#ifdef TICKTRUE_HAS_FORK

namespace ticktrue::test {
namespace {

using verifier::ChildCommand;
using verifier::ChildEnd;
using verifier::ChildLimits;
using verifier::ChildResult;
using How = ChildEnd::How;

ChildCommand shell(const std::string& script, const ChildLimits& limits = {20, 1u << 20, 64u << 10}) {
  ChildCommand command;
  command.argv = {"sh", "-c", script};
  command.limits = limits;
  return command;
}

ChildResult run_shell(const std::string& script, const ChildLimits& limits = {20, 1u << 20, 64u << 10}) {
  return verifier::run_child(shell(script, limits));
}

/// Whether the process exists and has not ended.
bool is_running(const std::string& id) {
  const Bytes stat = read_file("/proc/" + id + "/stat");
  const std::string text(stat.begin(), stat.end());
  return !text.empty() && !contains(text, ") Z ") && !contains(text, ") X ");
}

std::string first_line_of(const std::string& path) {
  const Bytes bytes = read_file(path);
  const std::string text(bytes.begin(), bytes.end());
  return text.substr(0, text.find('\n'));
}

}  // namespace

TEST_CASE("run_child: output, messages and exit status of a program are taken", "[verifier][runs][analytic]") {
  const ChildResult result = run_shell("cat; echo out; echo message >&2; exit 7");
  CHECK(result.end.how == How::exited);
  CHECK(result.end.exit_status == 7);
  CHECK(result.output == "out\n");
  CHECK(result.message == "message\n");
  CHECK_FALSE(result.finished);
  CHECK(result.end.wall_s > 0);
  CHECK(result.end.wall_s < 20);
  CHECK(verifier::child_failure(result, ChildLimits{}).empty());
}

TEST_CASE("run_child: environment, folder and arguments arrive as given", "[verifier][runs][analytic]") {
  ::setenv("TICKTRUE_TEST_TAKEN_AWAY", "there", 1);
  ChildCommand command;
  command.argv = {"sh", "-c", R"(pwd; echo "$TICKTRUE_TEST_SET|${TICKTRUE_TEST_TAKEN_AWAY-none}|$1|$HOME")", "sh",
                  "a 'b' $c"};
  command.environment = {{"TICKTRUE_TEST_SET", "x=y z"}, {"TICKTRUE_TEST_TAKEN_AWAY", std::nullopt}, {"HOME", "here"}};
  command.cwd = "/";
  const ChildResult result = verifier::run_child(command);
  ::unsetenv("TICKTRUE_TEST_TAKEN_AWAY");
  CHECK(result.output == "/\nx=y z|none|a 'b' $c|here\n");
  command.cwd = "/nosuch/folder";
  const ChildResult refused = verifier::run_child(command);
  CHECK(refused.end.how == How::not_started);
  CHECK(contains(verifier::child_failure(refused, command.limits), "cannot be started: No such file"));
}

TEST_CASE("run_child: of too much output a part is kept and the rest is counted", "[verifier][runs][analytic]") {
  const ChildLimits limits{60, 1000, 2000};
  const ChildResult result =
      run_shell("printf first; head -c 1073741824 /dev/zero; { head -c 300000 /dev/zero; printf last; } >&2", limits);
  CHECK(result.end.how == How::exited);
  CHECK(result.output.size() == 1000);
  CHECK(result.output.substr(0, 5) == "first");
  CHECK(result.output_dropped_size == 1073741824u + 5 - 1000);
  CHECK(result.message.size() == 2000);
  CHECK(result.message.substr(1996) == "last");
  CHECK(verifier::child_failure(result, limits) == "printed 1073741829 bytes, expected at most 1000");
}

TEST_CASE("run_child: what cannot start, crashes or hangs is told", "[verifier][runs][corruption]") {
  const ChildLimits limits{0.3, 1u << 20, 64u << 10};
  const auto failure = [&](const std::vector<std::string>& argv) {
    ChildCommand command;
    command.argv = argv;
    command.limits = limits;
    return verifier::child_failure(verifier::run_child(command), limits);
  };
  CHECK(contains(failure({}), "cannot be started: no program was named"));
  CHECK(contains(failure({"/nosuch/program"}), "cannot be started: No such file"));
  CHECK(contains(failure({"/"}), "cannot be started: "));
  CHECK(contains(failure({"sh", "-c", "kill -SEGV $$"}), "killed by signal 11"));
  CHECK(contains(failure({"sh", "-c", "sleep 60"}), "did not end within 0 s"));
  CHECK(contains(failure({"sh", "-c", "exec >&- 2>&-; sleep 60"}), "did not end within"));
  CHECK(contains(failure({"sh", "-c", "trap '' TERM INT HUP; sleep 60 & wait"}), "did not end within"));
  CHECK(contains(failure({"sh", "-c", "cat /dev/zero"}), "did not end within"));
}

TEST_CASE("run_child: an ignored SIGCHLD does not lose the exit status", "[verifier][runs][regression]") {
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  const ChildResult result = run_shell("exit 7");
  std::signal(SIGCHLD, before);
  CHECK(result.end.exit_status == 7);
}

TEST_CASE("run_child: processes left in the group are ended, those that left it are named",
          "[verifier][runs][analytic]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("child");
  const auto script = [&](const std::string& how) {
    return how + " sh -c 'echo $$ > " + path + "; exec sleep 60' & while ! [ -s " + path + " ]; do sleep 0.01; done";
  };
  const ChildResult grouped = run_shell(script(""));
  CHECK(grouped.end.how == How::exited);
  CHECK(grouped.end.escaped.empty());
  CHECK_FALSE(is_running(first_line_of(path)));
  // It holds the pipes of the run open, and is not waited for.
  CHECK(grouped.end.wall_s < 10);
#ifdef __linux__
  SKIP_UNLESS(std::system("command -v setsid > /dev/null") == 0, "no setsid");
  write_file(path, {});
  const ChildResult left = run_shell(script("setsid"));
  const std::string id = first_line_of(path);
  CHECK(left.end.wall_s < 10);
  CHECK(is_running(id));
  REQUIRE(left.end.escaped.size() == 1);
  CHECK(verifier::escaped_text(left.end.escaped) == "process " + id + " (sleep)");
  CHECK(run_shell("true").end.escaped.empty());  // named once
  ::kill(static_cast<pid_t>(std::stol(id)), SIGKILL);
#endif
}

TEST_CASE("run_child: several at once each get their own output and status", "[verifier][runs][determinism]") {
  std::vector<ChildResult> results(16);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < results.size(); ++i)
    threads.emplace_back(
        [&results, i] { results[i] = run_shell("echo " + std::to_string(i) + "; exit " + std::to_string(i)); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < results.size(); ++i) {
    CAPTURE(i);
    CHECK(results[i].output == std::to_string(i) + "\n");
    CHECK(results[i].end.exit_status == static_cast<int>(i));
    CHECK(results[i].end.escaped.empty());
  }
}

TEST_CASE("run_child: the tool says that it finished, whatever its exit status", "[verifier][runs][analytic]") {
  ChildCommand command;
  command.argv = {TICKTRUE_TOOL, "scenes"};
  const ChildResult done = verifier::run_child(command);
  CHECK(done.finished);
  CHECK(done.end.exit_status == 0);
  command.argv = {TICKTRUE_TOOL, "show", "/nosuch.ttr"};
  const ChildResult refused = verifier::run_child(command);
  CHECK(refused.finished);
  CHECK(refused.end.exit_status == 2);
  // The mark is the tool's own: a program between does not have it for its children.
  CHECK_FALSE(run_shell("exit 0").finished);
}

}  // namespace ticktrue::test

#endif
