// Plug-ins that end their process, print, hang and fork. Exit code 0 never hides undone work, and output is complete.
// SPDX-License-Identifier: MIT
//
// tests/cli/rude_plugin.cpp is the plug-in.
#ifdef TICKTRUE_RUDE_PLUGIN

#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/runs/child.h"

namespace ticktrue::test {
namespace {

using verifier::ChildCommand;
using verifier::ChildResult;

struct RudeRun {
  TemporaryFolder folder;
  std::string trace = folder.file("x.ttr");
  std::string child = folder.file("child");
  std::string plugin = TICKTRUE_RUDE_PLUGIN;

  ChildResult run(const std::string& act, const std::vector<std::string>& words) const {
    ChildCommand command;
    command.argv = {TICKTRUE_TOOL};
    command.argv.insert(command.argv.end(), words.begin(), words.end());
    for (const std::string& word : {std::string("--plugin"), plugin, std::string("--plugin-timeout"), std::string("2")})
      command.argv.push_back(word);
    command.environment = {{"RUDE_PLUGIN", act}, {"RUDE_PLUGIN_CHILD", child}};
    command.limits.time_s = 60;
    return verifier::run_child(command);
  }
  ChildResult record(const std::string& act) const {
    return run(act, {"record", "x", "--ticks", "5", "--json", "--force", "-o", trace});
  }
  std::string child_id() const {
    const Bytes bytes = read_file(child);
    const std::string text(bytes.begin(), bytes.end());
    return text.substr(0, text.find('\n'));
  }
};

bool is_running(const std::string& id) {
  return !id.empty() && ::kill(static_cast<pid_t>(std::stol(id)), 0) == 0;
}

}  // namespace

TEST_CASE("a plug-in that ends the process is told with the place, and is never exit code 0",
          "[cli][plugin_process][corruption]") {
  struct Row {
    const char* act;
    const char* text;
  };
  const Row rows[] = {
      {"load:exit", "ended the process with exit code 0 while it was loaded"},
      {"load:_exit", "ended the process with exit code 0 while it was loaded"},
      {"load:abort", "crashed with SIGABRT while it was loaded"},
      {"create:exit", "ended the process with exit code 0 in create"},
      {"create:_exit", "ended the process with exit code 0 in create"},
      {"step:exit", "ended the process with exit code 0 in step of tick 2"},
      {"step:exit3", "ended the process with exit code 3 in step of tick 2"},
      {"step:_exit", "ended the process with exit code 0 in step of tick 2"},
      {"step:quick_exit", "ended the process with exit code 0 in step of tick 2"},
      {"step:abort", "crashed with SIGABRT in step of tick 2"},
      {"step:crash", "crashed with SIGSEGV in step of tick 2"},
      {"step:signal", "crashed with signal 10 in step of tick 2"},
      {"step:thread_exit", "ended the process with exit code 0 "},
      {"step:thread_stays", "ended the main thread "},
      {"step:hang", "hangs in step of tick 2: found no end after 2 s (--plugin-timeout)"},
      {"destroy:exit", "ended the process with exit code 0 in destroy"},
  };
  const RudeRun rude;
  for (const Row& row : rows) {
    CAPTURE(row.act);
#ifndef __linux__
    if (std::string(row.act) == "step:thread_stays" || std::string(row.act) == "step:signal") continue;
#endif
    std::filesystem::remove(rude.trace);
    std::filesystem::remove(rude.trace + ".old");
    const ChildResult result = rude.record(row.act);
    INFO(result.message);
    CHECK(result.end.how == verifier::ChildEnd::How::exited);
    CHECK(result.end.exit_status == 1);
    CHECK(contains(result.message, "ticktrue: error: plug-in "));
    CHECK(contains(result.message, row.text));
  }
}

TEST_CASE("a plug-in that ends the process while a trace is verified gives no match",
          "[cli][plugin_process][corruption]") {
  const RudeRun rude;
  REQUIRE(rude.record("").end.exit_status == 0);
  REQUIRE(rude.run("", {"verify", rude.trace}).end.exit_status == 0);
  for (const std::string act : {"exit", "_exit", "quick_exit", "thread_exit"}) {
    CAPTURE(act);
    const ChildResult result = rude.run("step:" + act, {"verify", rude.trace, "--json"});
    INFO(result.output + result.message);
    CHECK(result.end.exit_status == 1);
    const auto json = nlohmann::json::parse(result.output, nullptr, false);
    REQUIRE(json.is_object());
    CHECK(json["verdict"] == "diverged");
    CHECK(contains(json["reason"].get<std::string>(), "ended the process with exit code 0"));
  }
}

TEST_CASE("a plug-in that changes the exit code when it is unloaded is told", "[cli][plugin_process][corruption]") {
  const RudeRun rude;
  // The tool refuses with exit code 2, and the plug-in changes the exit code to 0.
  const ChildResult result = rude.run("unload:_exit", {"record", "x", "-o", rude.trace});
  INFO(result.message);
  CHECK(result.end.exit_status == 1);
  CHECK(contains(result.message, "--ticks: found none"));
  CHECK(contains(result.message, "ended the process with exit code 0 while it was unloaded"));
  const ChildResult hanging = rude.run("unload:hang", {"record", "x", "--ticks", "5", "-o", rude.trace});
  CHECK(hanging.end.exit_status == 1);
  CHECK(contains(hanging.message, "hangs while it was unloaded"));
}

TEST_CASE("what a plug-in prints is not in the tool's output", "[cli][plugin_process][analytic]") {
  const RudeRun rude;
  for (const std::string place : {"load", "create", "step", "destroy", "unload"}) {
    CAPTURE(place);
    const ChildResult result = rude.record(place + ":print");
    INFO(result.output + result.message);
    CHECK(result.end.exit_status == 0);
    const auto json = nlohmann::json::parse(result.output, nullptr, false);
    REQUIRE(json.is_object());
    CHECK(json["ticks"] == 5);
    CHECK(contains(result.message, "{\"not\": \"ours\"}"));
  }
  const ChildResult verified = rude.run("step:print", {"verify", rude.trace, "--json"});
  CHECK(verified.end.exit_status == 0);
  CHECK(nlohmann::json::parse(verified.output, nullptr, false).is_object());
  CHECK(contains(verified.message, "{\"not\": \"ours\"}"));
}

TEST_CASE("a plug-in that prints a gigabyte is shown in part, and the rest is counted",
          "[cli][plugin_process][analytic]") {
  const RudeRun rude;
  ChildCommand command;
  command.argv = {TICKTRUE_TOOL,        "record",           "x", "--ticks", "5", "--json", "-o", rude.trace, "--plugin",
                  TICKTRUE_RUDE_PLUGIN, "--plugin-timeout", "60"};
  command.environment = {{"RUDE_PLUGIN", "step:flood"}};
  command.limits.time_s = 120;
  command.limits.message_size_max = 1u << 20;
  const ChildResult result = verifier::run_child(command);
  CHECK(result.end.exit_status == 0);
  CHECK(nlohmann::json::parse(result.output, nullptr, false).is_object());
  CHECK(result.message.size() + result.message_dropped_size < 66'000);
  CHECK(contains(result.message, ": 1073676288 more bytes that it printed are not shown"));
}

TEST_CASE("processes that a plug-in forks are ended with the command, those that left its group are named",
          "[cli][plugin_process][analytic]") {
  const RudeRun rude;
  const ChildResult forked = rude.record("step:fork");
  INFO(forked.message);
  CHECK(forked.end.exit_status == 0);
  CHECK_FALSE(is_running(rude.child_id()));
  CHECK_FALSE(contains(forked.message, "left running"));
#ifdef __linux__
  std::filesystem::remove(rude.child);
  const ChildResult left = rude.record("step:setsid");
  INFO(left.message);
  CHECK(left.end.exit_status == 0);
  CHECK(is_running(rude.child_id()));
  CHECK(
      contains(left.message, "left running, outside of the process group of the command: process " + rude.child_id()));
  ::kill(static_cast<pid_t>(std::stol(rude.child_id())), SIGKILL);
#endif
}

TEST_CASE("a verdict by a plug-in is stored, its crash is not, and another library verifies anew",
          "[cli][plugin_process][corpus][analytic]") {
  namespace fs = std::filesystem;
  RudeRun rude;
  REQUIRE(rude.record("").end.exit_status == 0);
  const std::vector<std::string> verify{"corpus", "verify", rude.trace, "--cache", rude.folder.file("store")};
  const ChildResult crashed = rude.run("step:crash", verify);
  CAPTURE(crashed.output, crashed.message);
  SKIP_UNLESS(!contains(crashed.message, "found no digest of the engine"), "this build has no digest of the engine");
  CHECK(crashed.end.exit_status == 1);
  CHECK(contains(crashed.output, "1 trace: 1 diverged; 0 cached, 1 verified"));
  CHECK(contains(rude.run("", verify).output, "1 trace: 1 match; 0 cached, 1 verified"));
  CHECK(contains(rude.run("", verify).output, "1 trace: 1 match; 1 cached, 0 verified"));

  fs::create_directory(rude.folder.file("other"));
  const std::string moved = rude.folder.file("other/" + fs::path(rude.plugin).filename().string());
  fs::copy_file(rude.plugin, moved);
  rude.plugin = moved;
  CHECK(contains(rude.run("", verify).output, "1 trace: 1 match; 1 cached, 0 verified"));
  Bytes bytes = read_file(moved);
  bytes.push_back(0);  // after all loaded sections
  write_file(moved, bytes);
  CHECK(contains(rude.run("", verify).output, "1 trace: 1 match; 0 cached, 1 verified"));

  // A worker with claims forks for each trace, and renews its claim while the child runs.
  std::vector<std::string> claiming = verify;
  claiming.emplace_back("--claim");
  CHECK(contains(rude.run("", claiming).output, "1 trace: 1 match; 1 cached, 0 verified"));
  bytes.push_back(0);
  write_file(moved, bytes);
  const ChildResult crashed_again = rude.run("step:crash", claiming);
  CHECK(crashed_again.end.exit_status == 1);
  CHECK(contains(crashed_again.output, "1 trace: 1 diverged; 0 cached, 1 verified"));
  CHECK(contains(rude.run("", claiming).output, "1 trace: 1 match; 0 cached, 1 verified"));
  CHECK(contains(rude.run("", claiming).output, "1 trace: 1 match; 1 cached, 0 verified"));
}

TEST_CASE("golden add: a row of a plug-in is checked with it, and one that crashes leaves nothing",
          "[cli][plugin_process][golden]") {
  const RudeRun rude;
  const std::string golden = rude.folder.file("golden");
  std::filesystem::create_directory(golden);
  const ChildResult added = rude.run("", {"golden", "add", golden, "setup", "--ticks", "5", "--name", "a"});
  INFO(added.output + added.message);
  CHECK(added.end.exit_status == 0);
  CHECK(contains(added.output, "added  " + golden + "/a.ttr"));
  const std::string manifest = golden + "/MANIFEST.tsv";
  const Bytes before = read_file(manifest);
  CHECK(contains(std::string(before.begin(), before.end()), "a.ttr\tplugin:setup\t-\t5\troot\t"));
  CHECK(contains(rude.run("", {"golden", "check", golden}).output, "1 of 1 golden traces match"));
  ChildCommand without;
  without.argv = {TICKTRUE_TOOL, "golden", "check", golden};
  const ChildResult unknown = verifier::run_child(without);
  CHECK(unknown.end.exit_status == 2);
  CHECK(contains(unknown.message, "found no plug-in, expected --plugin LIB.so"));
  const ChildResult crashed = rude.run("step:crash", {"golden", "add", golden, "setup", "--ticks", "5", "--name", "b"});
  CHECK(crashed.end.exit_status == 1);
  CHECK(!std::filesystem::exists(golden + "/b.ttr"));
  CHECK(read_file(manifest) == before);
}

TEST_CASE("a signal that stops the tool stops the plug-in and what it forked", "[cli][plugin_process][analytic]") {
  const RudeRun rude;
  REQUIRE(rude.record("").end.exit_status == 0);
  for (const std::string signal : {"INT", "TERM", "HUP"}) {
    CAPTURE(signal);
    std::filesystem::remove(rude.child);
    ChildCommand command;
    // The plug-in hangs in the process for one file, which is a grandchild of this test.
    command.argv = {
        "sh",
        "-c",
        "(sleep 1; kill -" + signal + " $$) & exec \"$0\" verify \"$1\" --plugin \"$2\" --plugin-timeout 50",
        TICKTRUE_TOOL,
        rude.trace,
        TICKTRUE_RUDE_PLUGIN};
    command.environment = {{"RUDE_PLUGIN", "step:hang"}};
    command.limits.time_s = 30;
    const ChildResult result = verifier::run_child(command);
    INFO(result.output + result.message);
    CHECK(result.end.how == verifier::ChildEnd::How::killed_by_signal);
    CHECK(result.end.signal == (signal == "INT" ? SIGINT : signal == "TERM" ? SIGTERM : SIGHUP));
    CHECK(result.end.escaped.empty());
    CHECK(result.end.wall_s < 10);
  }
}

}  // namespace ticktrue::test

#endif
