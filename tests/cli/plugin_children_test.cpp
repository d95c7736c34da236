// Plug-ins with child tables, and plug-ins whose ticks run twice: recorded, verified, brought back, told as texts.
// SPDX-License-Identifier: MIT
//
// tests/cli/child_plugin.cpp and tests/cli/saving_plugin.cpp are the plug-ins.
#ifdef TICKTRUE_CHILD_PLUGIN

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "replay/trace_reader.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/runs/child.h"

namespace ticktrue::test {
namespace {

/// Runs the tool with one of the two plug-ins; `fault` is for either.
struct ChildPluginRun {
  std::string library = TICKTRUE_CHILD_PLUGIN;
  TemporaryFolder folder;
  std::string trace = folder.file("x.ttr");

  verifier::ChildResult run(const std::string& fault, const std::vector<std::string>& words) const {
    verifier::ChildCommand command;
    command.argv = {TICKTRUE_TOOL};
    command.argv.insert(command.argv.end(), words.begin(), words.end());
    for (const std::string& word :
         {std::string("--plugin"), library, std::string("--plugin-timeout"), std::string("2")})
      command.argv.push_back(word);
    command.environment = {{"CHILD_PLUGIN", fault}, {"SAVING_PLUGIN", fault}};
    command.limits.time_s = 60;
    return verifier::run_child(command);
  }
  verifier::ChildResult record(const std::string& fault, const std::string& detail = "full") const {
    for (const char* rest : {"", ".old"}) std::filesystem::remove(trace + rest);
    return run(fault, {"record", "1", "--ticks", "60", "--checkpoint-interval", "10", "--detail", detail, "-o", trace});
  }
  nlohmann::json verify(const std::string& fault, std::vector<std::string> words, int exit_code) const {
    words.insert(words.begin(), {"verify", trace, "--json"});
    const verifier::ChildResult result = run(fault, words);
    INFO(result.output + result.message);
    CHECK(result.end.exit_status == exit_code);
    nlohmann::json json = nlohmann::json::parse(result.output, nullptr, false);
    if (!json.is_object()) FAIL("no JSON");
    return json;
  }
};

}  // namespace

TEST_CASE("a plug-in with child tables is recorded, verified and restored in every detail",
          "[cli][plugin_children][equivalence]") {
  const ChildPluginRun plugin;
  const std::vector<std::vector<std::string>> ways = {
      {}, {"--mode", "restore"}, {"--mode", "twice"}, {"--from", "25", "--to", "37"}, {"--sync-test", "4"}};
  for (const char* detail : {"root", "cells", "full"}) {
    CAPTURE(detail);
    const verifier::ChildResult recorded = plugin.record("", detail);
    INFO(recorded.message);
    REQUIRE(recorded.end.exit_status == 0);
    for (const std::vector<std::string>& way : ways) {
      CAPTURE(way);
      CHECK(plugin.verify("", way, 0)["verdict"] == "match");
    }
  }
  auto reader = replay::TraceReader::open(plugin.trace);
  REQUIRE(reader);
  std::string names;
  for (const TableSchema& table : reader->setup().schema.tables)
    names += table.name + ":" + std::to_string(static_cast<int>(table.form)) + " ";
  CHECK(names == "world:0 squads:0 squads.name:3 squads.flag:2 squads.members:1 squads.members.label:3 ");
}

TEST_CASE("a plug-in whose text differs is red with the text, its owner and both values",
          "[cli][plugin_children][injection]") {
  const ChildPluginRun plugin;
  REQUIRE(plugin.record("").end.exit_status == 0);
  const verifier::ChildResult red = plugin.run("other", {"verify", plugin.trace});
  INFO(red.output);
  CHECK(red.end.exit_status == 1);
  CHECK(contains(red.output, "tick 25 of 60"));
  CHECK(contains(red.output, "  text    squads[1].name  (id 5)\n"));
  CHECK(contains(red.output, "expected \"squad 5 the Bold\".  got \"squad 5 the Brave\".  differs at character 13"));
  for (const std::vector<std::string>& way :
       std::vector<std::vector<std::string>>{{"--mode", "restore"}, {"--sync-test", "1"}}) {
    CAPTURE(way);
    const nlohmann::json report = plugin.verify("forgets", way, 1);
    CHECK(report["verdict"] == "state_incomplete");
    CHECK(report["divergence"]["stage"] == "load");
    CHECK(report["divergence"]["contents"][0]["place"] == "squads[1].name");
    CHECK(report["divergence"]["contents"][0]["got"] == "squad 5");
  }
  const verifier::ChildResult shown = plugin.run("", {"replay", plugin.trace, "--ticks", "30..30"});
  INFO(shown.output);
  CHECK(contains(shown.output, "\n  squads[1].name  \"squad 5 the Bold\"\n"));
  CHECK(contains(shown.output, "\n  squads[0].flag  1e 1e 1e 1e 1e 1e 1e 1e 1e 1e 1e 1e 1e 1e 1e 1e ...\n"));
  const verifier::ChildResult lines =
      plugin.run("", {"replay", plugin.trace, "--ticks", "30..30", "--format", "jsonl"});
  const nlohmann::json tables = nlohmann::json::parse(lines.output).at("tables");
  CHECK(tables.at("squads.name").at(1).at("text") == "squad 5 the Bold");
  CHECK(tables.at("squads.flag").at(0).at("bytes").get<std::string>().size() == 2 * 32);
}

TEST_CASE("without saves, a plug-in with child tables is only observed", "[cli][plugin_children][analytic]") {
  const ChildPluginRun plugin;
  REQUIRE(plugin.record("no saves").end.exit_status == 0);
  CHECK(plugin.verify("no saves", {}, 0)["verdict"] == "match");
  CHECK(plugin.verify("no saves", {"--from", "25"}, 0)["verdict"] == "match");
  CHECK(plugin.verify("no saves", {"--mode", "restore"}, 5)["verdict"] == "not_comparable");
  CHECK(plugin.verify("no saves", {"--sync-test", "5"}, 5)["verdict"] == "not_comparable");
  // The plug-in of today saves: its ticks run twice, though the trace has no saves.
  CHECK(plugin.verify("", {"--sync-test", "5"}, 0)["verdict"] == "match");
}

TEST_CASE("wrong words of a plug-in about child tables are refused with what was found",
          "[cli][plugin_children][errors]") {
  struct Row {
    const char* fault;
    const char* text;
    int exit_code;
  };
  const Row rows[] = {
      {"orphan", "table squads.name: parent: found no table camps", 2},
      {"shown", "table squads: column morale: found a shown column, expected a judged one", 2},
      {"type", "column rank: bytes in the struct: found 2, expected a multiple of 8 (f64)", 2},
      {"null", "table squads.flag: owner 5: found null, expected the first of 5 bytes", 1},
      {"crash", "crashed with SIGSEGV in a callback of a child table, after tick 7", 1},
  };
  const ChildPluginRun plugin;
  for (const Row& row : rows) {
    CAPTURE(row.fault);
    const verifier::ChildResult result = plugin.record(row.fault);
    INFO(result.message);
    CHECK(result.end.exit_status == row.exit_code);
    CHECK(contains(result.message, row.text));
  }
}

TEST_CASE("the ticks of a plug-in run twice, and what load forgets is told", "[cli][plugin_sync][injection]") {
  ChildPluginRun saving;
  saving.library = TICKTRUE_SAVING_PLUGIN;
  REQUIRE(saving.record("").end.exit_status == 0);
  for (const char* ticks : {"1", "7", "60"}) {
    CAPTURE(ticks);
    const nlohmann::json report = saving.verify("", {"--sync-test", ticks}, 0);
    CHECK(report["verdict"] == "match");
    CHECK(report["ticks_compared"] == 60);
    CHECK(contains(report["notes"].dump(), "sync test: 60 ticks ran twice with the same state"));
    const nlohmann::json red = saving.verify("forgets", {"--sync-test", ticks}, 1);
    CHECK(red["verdict"] == "state_incomplete");
    CHECK(red["divergence"]["table"] == "units");
    CHECK(contains(red["reason"].get<std::string>(), "ended in two states"));
    CHECK(contains(red["again"].dump(), std::string("--sync-test ") + ticks));
  }
  const nlohmann::json leaves = saving.verify("leaves", {"--sync-test", "3"}, 1);
  CHECK(leaves["reason"] == "load does not bring back the state at tick 0");
  CHECK(leaves["divergence"]["columns"].dump() == "[\"hits\"]");
  CHECK(contains(saving.verify("refuses", {"--sync-test", "3"}, 1)["reason"].get<std::string>(),
                 "returned 3 for a save"));
  CHECK(contains(saving.verify("changes", {"--sync-test", "1"}, 1)["reason"].get<std::string>(),
                 "save callback: tick 20: it changes the state"));
  CHECK(saving.verify("never", {"--sync-test", "3"}, 3)["reason"] == "sync test: 61 times there was no save");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"--mode", "restore"}, {"--against-build", TICKTRUE_TOOL}}) {
    std::vector<std::string> all{"verify", saving.trace, "--sync-test", "3"};
    all.insert(all.end(), words.begin(), words.end());
    const verifier::ChildResult refused = saving.run("", all);
    CHECK(refused.end.exit_status == 2);
    CHECK(contains(refused.message, "--sync-test: found " + words[0]));
  }
}

}  // namespace ticktrue::test

#endif
