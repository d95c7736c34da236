// Plug-ins with save and load: recorded, restored, verified in parts; what forgets, refuses or crashes is named.
// SPDX-License-Identifier: MIT
//
// tests/cli/saving_plugin.cpp is the plug-in.
#ifdef TICKTRUE_SAVING_PLUGIN

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

struct SavingRun {
  TemporaryFolder folder;
  std::string trace = folder.file("x.ttr");

  ChildResult run(const std::string& fault, const std::vector<std::string>& words) const {
    ChildCommand command;
    command.argv = {TICKTRUE_TOOL};
    command.argv.insert(command.argv.end(), words.begin(), words.end());
    for (const char* word : {"--plugin", TICKTRUE_SAVING_PLUGIN, "--plugin-timeout", "2"})
      command.argv.emplace_back(word);
    command.environment = {{"SAVING_PLUGIN", fault}, {"SAVING_PLUGIN_LOADS", folder.file("loads")}};
    command.limits.time_s = 60;
    return verifier::run_child(command);
  }
  ChildResult record(const std::string& fault, const std::string& seed = "1",
                     const std::string& detail = "full") const {
    for (const char* rest : {"", ".old"}) std::filesystem::remove(trace + rest);
    return run(fault, {"record", seed, "--ticks", "60", "--checkpoint-interval", "10", "--detail", detail, "--force",
                       "-o", trace});
  }
  /// The one report of `verify --json`.
  nlohmann::json verify(const std::string& fault, std::vector<std::string> words, int exit_code) const {
    words.insert(words.begin(), {"verify", trace, "--json"});
    const ChildResult result = run(fault, words);
    INFO(result.output + result.message);
    CHECK(result.end.exit_status == exit_code);
    nlohmann::json json = nlohmann::json::parse(result.output, nullptr, false);
    if (!json.is_object()) FAIL("no JSON");
    return json;
  }
};

}  // namespace

TEST_CASE("a plug-in with saves: restore, -j, --from and --to match for every seed",
          "[cli][plugin_saves][equivalence]") {
  const SavingRun saving;
  const std::vector<std::vector<std::string>> ways = {
      {"--mode", "restore"}, {"--mode", "restore", "--to-end"}, {"-j", "1"}, {"-j", "2"}, {"-j", "5"},
      {"--from", "25"},      {"--from", "25", "--to", "37"}};
  for (const std::string seed : {"1", "77", "1234567"})
    for (const std::string detail : {"cells", "full"}) {
      const ChildResult recorded = saving.record("", seed, detail);
      INFO(recorded.message);
      REQUIRE(recorded.end.exit_status == 0);
      for (const std::vector<std::string>& way : ways) {
        CAPTURE(seed, detail, way);
        const nlohmann::json report = saving.verify("", way, 0);
        CHECK(report["verdict"] == "match");
        const bool is_part = way[0] == "--from";
        CHECK(report["ticks_compared"] == (!is_part ? 60 : way.size() == 2 ? 35 : 13));
      }
    }
}

TEST_CASE("a trace with saves is verified in order, and nothing is loaded, whatever -j says",
          "[cli][plugin_saves][analytic]") {
  const SavingRun saving;
  REQUIRE(saving.record("").end.exit_status == 0);
  for (const std::string jobs : {"1", "2", "3"}) {
    CAPTURE(jobs);
    std::filesystem::remove(saving.folder.file("loads"));
    saving.verify("", {"-j", jobs}, 0);
    CHECK(!std::filesystem::exists(saving.folder.file("loads")));
  }
  saving.verify("", {"--mode", "restore"}, 0);
  CHECK(std::filesystem::exists(saving.folder.file("loads")));
}

TEST_CASE("a plug-in that forgets a variable in load is state_incomplete with tick, table and column",
          "[cli][plugin_saves][analytic]") {
  const SavingRun saving;
  REQUIRE(saving.record("").end.exit_status == 0);
  for (const char* jobs : {"1", "2", "5"})
    CHECK(saving.verify("forgets", {"-j", jobs}, 0)["verdict"] == "match");  // nothing is loaded
  const std::vector<std::vector<std::string>> ways = {{"--mode", "restore"}, {"--mode", "restore", "--to-end"}};
  for (const std::vector<std::string>& way : ways) {
    CAPTURE(way);
    const nlohmann::json report = saving.verify("forgets", way, 1);
    CHECK(report["verdict"] == "state_incomplete");
    CHECK(report["checkpoint"] == 10);
    CHECK(contains(report["reason"].get<std::string>(), "the run from the save of tick 10 does not"));
    CHECK(report["divergence"]["tick"] == 10);
    CHECK(report["divergence"]["table"] == "units");
    CHECK(!report["divergence"]["columns"].empty());
    CHECK(contains(report["divergence"]["columns"].dump(), "\"x\""));
  }
  const nlohmann::json report = saving.verify("leaves", {"--mode", "restore"}, 1);
  CHECK(report["verdict"] == "state_incomplete");
  CHECK(report["divergence"]["stage"] == "load");
  CHECK(report["divergence"]["tick"] == 0);
  CHECK(report["divergence"]["columns"].dump() == "[\"hits\"]");
  CHECK(saving.verify("leaves", {"--from", "25"}, 1)["checkpoint"] == 20);
}

TEST_CASE("a plug-in whose load refuses a save is told with the save, its size and what load returned",
          "[cli][plugin_saves][corruption]") {
  struct Row {
    const char* recorded_with;
    const char* fault;
    const char* text;
  };
  const Row rows[] = {
      {"", "refuses", "load callback: tick 20: returned 3 for a save of "},
      {"short", "", "load callback: tick 20: returned 2 for a save of "},
      {"", "load:throw", "load callback: tick 20: found an exception that left it: no disk"},
  };
  const SavingRun saving;
  for (const Row& row : rows) {
    CAPTURE(row.recorded_with, row.fault);
    REQUIRE(saving.record(row.recorded_with).end.exit_status == 0);
    const nlohmann::json report = saving.verify(row.fault, {"--from", "25"}, 1);
    CHECK(report["verdict"] == "state_incomplete");
    CHECK(contains(report["reason"].get<std::string>(), "save at tick 20 is refused: plug-in "));
    CHECK(contains(report["reason"].get<std::string>(), row.text));
    CHECK(report["divergence"]["stage"] == "load");
    CHECK(saving.verify(row.fault, {"-j", "1"}, 0)["verdict"] == "match");
  }
}

TEST_CASE("a plug-in that ends its process or hangs in save or load is told with the tick",
          "[cli][plugin_saves][corruption]") {
  struct Row {
    const char* act;
    const char* text;
  };
  const Row rows[] = {
      {"crash", "crashed with SIGSEGV in "}, {"exit", "ended the process with exit code 0 in "}, {"hang", "hangs in "}};
  const SavingRun saving;
  for (const Row& row : rows) {
    CAPTURE(row.act);
    const ChildResult recorded = saving.record(std::string("save:") + row.act);
    INFO(recorded.message);
    CHECK(recorded.end.exit_status == 1);
    CHECK(contains(recorded.message, std::string(row.text) + "save, after 0 ticks"));
    REQUIRE(saving.record("").end.exit_status == 0);
    for (const std::vector<std::string>& way :
         std::vector<std::vector<std::string>>{{"--from", "25"}, {"--mode", "restore"}}) {
      CAPTURE(way);
      const nlohmann::json report = saving.verify(std::string("load:") + row.act, way, 1);
      CHECK(report["verdict"] == "diverged");
      const char* tick = way[0] == "--from" ? "20" : "0";
      CHECK(contains(report["reason"].get<std::string>(), std::string(row.text) + "load of the save of tick " + tick));
    }
  }
}

TEST_CASE("what a plug-in gives that is no save ends the recording with a line that says so",
          "[cli][plugin_saves][corruption]") {
  struct Row {
    const char* fault;
    const char* text;
    int exit_code;
  };
  const Row rows[] = {
      {"nothing", "save callback: tick 0: found 0 bytes, expected at least 1", 2},
      {"grows", "save callback: tick 0: found more bytes than it had asked for", 2},
      {"beyond", "save callback: tick 0: found bytes written behind its buffer", 2},
      {"changes", "save callback: tick 20: it changes the state: hash before ", 2},
      {"save:throw", "save callback: tick 0: found an exception that left it: no disk", 2},
      {"no save", "load: found it without save, expected both or none", 2},
      {"no load", "save: found it without load, expected both or none", 2},
      {"long", "build: found more than 4096 bytes, expected a text", 2},
      {"odd", "3 checkpoints without a save: save returned TICKTRUE_SAVE_FAILED", 0},
  };
  const SavingRun saving;
  for (const Row& row : rows) {
    CAPTURE(row.fault);
    const ChildResult result = saving.record(row.fault);
    INFO(result.message);
    CHECK(result.end.exit_status == row.exit_code);
    CHECK(contains(result.message, row.text));
  }
  // No run begins at a checkpoint without a save.
  CHECK(contains(saving.verify("refuses", {"--from", "35"}, 1)["reason"].get<std::string>(), "save at tick 20"));
  REQUIRE(saving.record("never").end.exit_status == 0);
  CHECK(contains(saving.verify("", {"--mode", "restore"}, 5)["reason"].get<std::string>(), "no checkpoint has a save"));
}

TEST_CASE("replay of a plug-in begins at a save, and shows the states of a run from the start",
          "[cli][plugin_saves][equivalence]") {
  const SavingRun saving;
  REQUIRE(saving.record("").end.exit_status == 0);
  const auto replay = [&](const std::string& fault, const std::string& ticks) {
    return saving.run(fault, {"replay", saving.trace, "--ticks", ticks, "--format", "jsonl"});
  };
  const ChildResult all = replay("", "0..59");
  const ChildResult late = replay("", "47..59");
  REQUIRE(all.end.exit_status == 0);
  REQUIRE(late.end.exit_status == 0);
  REQUIRE(!late.output.empty());
  CHECK(all.output.size() > late.output.size());
  CHECK(all.output.substr(all.output.size() - late.output.size()) == late.output);
  const ChildResult crashed = replay("load:crash", "47..59");
  CHECK(crashed.end.exit_status == 1);
  CHECK(contains(crashed.message, "in load of the save of tick 40"));
  for (const auto& [fault, text] : {std::pair("refuses", "returned 3 for a save of "),
                                    std::pair("leaves", "load does not bring back the state of tick 40")}) {
    const ChildResult refused = replay(fault, "47..59");
    CHECK(refused.end.exit_status == 0);
    CHECK(refused.output == late.output);
    CHECK(contains(refused.message, text));
    CHECK(contains(refused.message, "; played from tick 0"));
  }
}

TEST_CASE("a trace names the library of its plug-in, its build and its saves", "[cli][plugin_saves][report]") {
  const SavingRun saving;
  REQUIRE(saving.record("").end.exit_status == 0);
  const ChildResult shown = saving.run("", {"show", saving.trace});
  INFO(shown.output);
  CHECK(contains(shown.output, std::string("  plug-in     path ") + TICKTRUE_SAVING_PLUGIN + ", build r7 of the test"));
  CHECK(contains(shown.output, "  saves       7, "));
  const ChildResult red = saving.run("forgets", {"verify", saving.trace, "--mode", "restore"});
  INFO(red.output);
  CHECK(contains(red.output, std::string("recorded plug-in ") + TICKTRUE_SAVING_PLUGIN + ", build r7 of the test"));
  CHECK(contains(red.output, std::string("here plug-in ") + TICKTRUE_SAVING_PLUGIN + ", build r7 of the test"));
  CHECK(contains(red.output, "runs from a checkpoint begin with its save, which saving-plugin loads"));
}

TEST_CASE("a plug-in of the interface before saves is recorded and verified as it was", "[cli][plugin_saves][golden]") {
  const SavingRun saving;
  REQUIRE(saving.record("older").end.exit_status == 0);
  CHECK(!contains(saving.run("older", {"show", saving.trace}).output, "saves"));
  CHECK(saving.verify("older", {"-j", "2"}, 0)["stretches"] == saving.verify("older", {"-j", "1"}, 0)["stretches"]);
  CHECK(saving.verify("older", {"--mode", "restore"}, 5)["reason"] ==
        "the state of saving-plugin can only be observed, not loaded");
  // The plug-in of today verifies the older trace, and says what it lacks.
  CHECK(saving.verify("", {}, 0)["verdict"] == "match");
}

}  // namespace ticktrue::test

#endif
