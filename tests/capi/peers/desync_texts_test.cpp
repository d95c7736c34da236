// A desync in texts, strings of bytes and lists: the report has them whole, on every side and in the bundle.
// SPDX-License-Identifier: MIT
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <ticktrue.hpp>
#include <utility>
#include <vector>

#include "replay/trace_reader.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/peers/bundle.h"

namespace ticktrue_example {

struct Page {
  std::uint16_t number = 0;
  std::string line;
};
TICKTRUE_COLUMNS(Page, number, line)

struct Scribe {
  std::uint32_t id = 0;
  std::string name;
  std::vector<std::uint8_t> seal;
  std::vector<Page> pages;
};
TICKTRUE_COLUMNS(Scribe, key(id), name, seal, pages)

}  // namespace ticktrue_example

namespace ticktrue::test {
namespace {

using ticktrue_example::Scribe;
using Scribes = std::vector<Scribe>;
using ScribeChange = std::function<void(Scribes&)>;

constexpr std::uint32_t scribe_tick_count = 6;
constexpr std::uint32_t scribe_fault_tick = 3;

/// One player in memory.
struct ScribePlayer {
  Scribes scribes;
  std::unique_ptr<ticktrue::Session> session;

  explicit ScribePlayer(std::uint32_t number) {
    for (std::uint32_t id : {4u, 9u, 12u}) {
      Scribe& one = scribes.emplace_back();
      one.id = id;
      one.name = "Cleo the Rich, number " + std::to_string(id) + ", first of her name and keeper of the seal";
      one.seal.assign(500, 7);
      one.pages = {{1, "a line"}, {2, "another line"}};
    }
    ticktrue::Options options("scribes", nullptr);
    options.mode = TICKTRUE_LIVE;
    options.flags = TICKTRUE_QUIET | TICKTRUE_JSON;
    options.player = number;
    session = std::make_unique<ticktrue::Session>(options);
    session->table("scribes", scribes);
  }
  void run(const ScribeChange& change) {
    for (std::uint32_t tick = 0; tick < scribe_tick_count; ++tick) {
      REQUIRE(session->begin_tick());
      for (Scribe& one : scribes) one.pages[0].number = static_cast<std::uint16_t>(tick);
      if (tick == scribe_fault_tick && change) change(scribes);
      REQUIRE(session->end_tick());
    }
  }
};

/// A match in which each player may have a change of its own. All have the same report, which is returned; the bundle
/// of each player has it too. `json`: becomes the object of the desync.
std::string scribe_report(const std::vector<ScribeChange>& changes, nlohmann::json& json) {
  std::deque<ScribePlayer> players;
  const auto count = static_cast<std::uint32_t>(changes.size());
  for (std::uint32_t p = 0; p < count; ++p) players.emplace_back(p).run(changes[p]);
  for (std::uint32_t to = 0; to < count; ++to)
    for (std::uint32_t from = 0; from < count; ++from)
      for (std::uint64_t tick = 0; from != to && tick < scribe_tick_count; ++tick) {
        std::uint64_t root = 0;
        REQUIRE(ticktrue_root(players[from].session->handle(), tick, &root) == TICKTRUE_OK);
        ticktrue_peer_root(players[to].session->handle(), from, tick, root);
      }
  for (int round = 0; round < 20; ++round)
    for (std::uint32_t from = 0; from < count; ++from)
      for (std::uint32_t to = 0; to < count; ++to) {
        if (from == to) continue;
        std::vector<std::uint8_t> message(1'200);
        message.resize(ticktrue_desync_message(players[from].session->handle(), to, message.data(), message.size()));
        if (!message.empty())
          CHECK(ticktrue_desync_receive(players[to].session->handle(), from, message.data(), message.size()) ==
                TICKTRUE_DIVERGED);
      }
  const TracePath place;
  std::string first;
  for (std::uint32_t p = 0; p < count; ++p) {
    CAPTURE(p);
    ticktrue_session* session = players[p].session->handle();
    int is_complete = 0;
    const std::string text = ticktrue_desync_report(session, &is_complete);
    CHECK(is_complete == 1);
    if (p == 0) first = text;
    CHECK(text == first);
    const std::string file = place("b" + std::to_string(p) + ".ttr");
    REQUIRE(ticktrue_bundle(session, file.c_str()) == TICKTRUE_OK);
    auto reader = replay::TraceReader::open(file);
    REQUIRE(reader);
    const auto bundle = verifier::Bundle::read(*reader);
    REQUIRE((bundle && *bundle));
    CHECK((**bundle).text(reader->setup().schema) == first);
    CHECK(ticktrue_finish(session) == 1);
    json = nlohmann::json::parse(ticktrue_report_json(session)).at("desync");
  }
  return first;
}

}  // namespace

TEST_CASE("a desync in a text, in bytes or in a list names it whole, on every side",
          "[capi][peers][children][injection]") {
  struct Case {
    ScribeChange change;
    std::vector<std::string> lines;
    std::string kind;  // of the first content; empty: none
  };
  const std::vector<Case> cases{
      {[](Scribes& all) { all[1].name[2] = 'd'; },
       {"  text    scribes[1].name  (id 9)\n",
        "  value   player 0: \"Cleo the Rich, number 9, first of her name\"....  player 1: \"Cldo the Rich, ",
        "differs at character 2\n"},
       "text"},
      {[](Scribes& all) { all[1].name += '!'; },
       {"  text    scribes[1].name  (id 9)\n", "of the seal\".  player 1: ", "of the seal!\".  differs at character ",
        " bytes\n"},
       "text"},
      {[](Scribes& all) { all[2].name.clear(); },
       {"  text    scribes[2].name  (id 12)\n", "player 1: \"\".  differs at character 0; ", " and 0 bytes\n"},
       "text"},
      {[](Scribes& all) { all[0].name[1] = '\xff'; },
       {"  value   player 0: \"Cleo", "player 1: \"C\\xffeo", "differs at character 1\n"},
       "text"},
      {[](Scribes& all) { all[2].seal[301] = 0xab; },
       {"  bytes   scribes[2].seal  (id 12)\n", "player 0: 07 07 ", "player 1: ab 07 ", "differs at byte 301 of 500\n"},
       "bytes"},
      {[](Scribes& all) { all[1].pages[1].line = "other"; },
       {"  text    scribes[1].pages[1].line  (id 9)\n",
        "  value   player 0: \"another line\".  player 1: \"other\".  differs at character 0; 12 and 5 bytes\n"},
       "text"},
      {[](Scribes& all) { all[1].pages[1].number = 77; },
       {"  column  scribes.pages.number scribes[1].pages[1]\n", "player 1: 004d (77)"},
       ""},
      {[](Scribes& all) { all.erase(all.begin() + 1); },
       {"  column  scribes.id        row 1 (id 9)\n", "  text    scribes[1].name  (id 9)\n", "player 1: no such row"},
       "text"},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    CAPTURE(i);
    nlohmann::json json;
    const std::string report = scribe_report({{}, cases[i].change}, json);
    CAPTURE(report, json.dump(2));
    for (const std::string& line : cases[i].lines) CHECK(contains(report, line));
    for (const char* column : {".bytes ", ".size ", ".name.", ".line.", ".seal."}) CHECK(!contains(report, column));
    CHECK(json.contains("contents") == !cases[i].kind.empty());
    if (cases[i].kind.empty()) continue;
    const nlohmann::json& content = json.at("contents").at(0);
    CHECK(content.at("kind") == cases[i].kind);
    CHECK(content.at("values").size() == 2);
    CHECK(contains(report, content.at("place").get<std::string>() + "  (id "));
  }
}

TEST_CASE("of three players, the report of a text groups those that agree", "[capi][peers][children][injection]") {
  nlohmann::json json;
  const ScribeChange second = [](Scribes& all) { all[0].name[3] = '0'; };
  const ScribeChange third = [](Scribes& all) { all[0].name[1] = '1'; };
  std::string report = scribe_report({{}, {}, third}, json);
  CAPTURE(report);
  CHECK(contains(report, "players 0, 1 agree; player 2 is the odd one out"));
  CHECK(contains(report, "  value   players 0, 1: \"Cleo"));
  CHECK(contains(report, ".  player 2: \"C1eo"));
  CHECK(json.at("contents").at(0).at("values").at(1).at("value").get<std::string>().substr(0, 4) == "Cleo");
  // The first byte at which not all agree, whoever differs there.
  report = scribe_report({{}, second, third}, json);
  CHECK(contains(report, "player 0: \"Cleo"));
  CHECK(contains(report, ".  player 1: \"Cle0"));
  CHECK(contains(report, ".  player 2: \"C1eo"));
  CHECK(contains(report, "differs at character 1\n"));
  CHECK(json.at("content_count") == 1);
  CHECK(json.at("differing") == 0);
}

TEST_CASE("more texts than a report shows are counted", "[capi][peers][children][injection]") {
  nlohmann::json json;
  const auto grow = [](Scribes& all, const char* line) {
    for (Scribe& one : all)
      for (std::uint16_t n = 0; n < 5; ++n) one.pages.push_back({n, line});
  };
  const std::string report = scribe_report(
      {[&](Scribes& all) { grow(all, "to the left"); }, [&](Scribes& all) { grow(all, "to the right"); }}, json);
  CAPTURE(report);
  CHECK(contains(report, "  more    15 texts differ\n"));
  CHECK(json.at("content_count") == 15);
  CHECK(json.at("contents").size() == 8);
}

}  // namespace ticktrue::test
