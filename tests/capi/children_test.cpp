// Child tables behind the C interface and its C++ layer: what is recorded, what reports say of it, what is refused.
// SPDX-License-Identifier: MIT
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <ticktrue.hpp>
#include <variant>
#include <vector>

#include "base/state/child_tables.h"
#include "replay/trace_reader.h"
#include "tests/capi/cpp_options.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue_example {

struct Item {
  std::uint16_t kind = 0;
  std::uint32_t index = 0;  // a name that every list has
  std::string label;
};
TICKTRUE_COLUMNS(Item, kind, index, label)

struct Place {
  float x = 0, y = 0;
};

struct Hero {
  std::uint32_t id = 0;
  std::string name;
  std::array<char, 8> title{};
  std::vector<std::uint8_t> picture;
  std::vector<Item> inventory;
  std::vector<Place> path;
  std::vector<std::string> tags;
  std::vector<std::vector<std::uint32_t>> grid;
};
TICKTRUE_COLUMNS(Hero, key(id), name, text(title), picture, inventory, path, tags, grid)

struct Note {
  std::uint8_t kind = 0;
  std::string text;
};
TICKTRUE_COLUMNS(Note, kind, text)

}  // namespace ticktrue_example

namespace ticktrue::test {
namespace {

using ticktrue_example::Hero;
using ticktrue_example::Item;
using ticktrue_example::Note;

struct Played {
  int exit_code = 0;
  std::string report, json, message;
};

/// Heroes that come, go and change; `disturb` is called in each tick.
Played play(const ticktrue::Options& options, const std::function<void(int, std::vector<Hero>&)>& disturb = {}) {
  std::mt19937 random(7);
  std::vector<Hero> heroes;
  ticktrue::Session session(options);
  session.table("heroes", heroes);
  const auto text = [&](std::size_t size_max) {
    std::string made(random() % (size_max + 1), ' ');
    for (char& c : made) c = static_cast<char>('a' + random() % 26);
    return made;
  };
  for (int tick = 0; tick < 40; ++tick) {
    if (!session.begin_tick()) break;
    if (tick % 4 == 0) heroes.emplace_back().id = static_cast<std::uint32_t>(3 * tick + 1);
    if (tick % 9 == 8) heroes.erase(heroes.begin());
    for (Hero& hero : heroes) {
      if (random() % 3 == 0) hero.name = text(45);
      std::snprintf(hero.title.data(), hero.title.size(), "%s", text(12).c_str());
      hero.picture.assign(random() % 700, static_cast<std::uint8_t>(tick));
      hero.inventory.resize(random() % 4);
      for (Item& item : hero.inventory) item = {static_cast<std::uint16_t>(random() % 50), tick + 1u, text(30)};
      hero.path.push_back({static_cast<float>(tick), 0.5f});
      hero.tags.assign(random() % 3, text(5));
      hero.grid.assign(random() % 3, std::vector<std::uint32_t>(random() % 3, 9));
    }
    if (disturb) disturb(tick, heroes);
    if (!session.end_tick()) break;
  }
  // A verification that has run every tick says so at the begin of the next.
  session.begin_tick();
  Played played;
  played.message = session.error();
  if (session.handle() != nullptr) {
    played.exit_code = ticktrue_finish(session.handle());
    played.report = ticktrue_report(session.handle());
    played.json = ticktrue_report_json(session.handle());
  }
  return played;
}

TEST_CASE("members that are texts and lists are recorded and compared with no further line",
          "[capi][children][columns]") {
  const TracePath path;
  const std::string file = path("x.ttr");
  for (const int detail : {TICKTRUE_DETAIL_ROOT, TICKTRUE_DETAIL_CELLS, TICKTRUE_DETAIL_FULL}) {
    CAPTURE(detail);
    ticktrue::Options recording = cpp_options(file, TICKTRUE_RECORD, detail);
    recording.flags |= TICKTRUE_OVERWRITE;
    const Played recorded = play(recording);
    CAPTURE(recorded.message);
    REQUIRE(recorded.exit_code == 0);
    const Played same = play(cpp_options(file, TICKTRUE_VERIFY));
    CAPTURE(same.report);
    CHECK(same.exit_code == 0);
    CHECK(contains(same.report, "40 of 40"));

    const std::vector<std::function<void(Hero&)>> changes{
        [](Hero& hero) { hero.name += "!"; },          [](Hero& hero) { hero.title[0] = '?'; },
        [](Hero& hero) { hero.picture.push_back(1); }, [](Hero& hero) { hero.inventory.push_back({}); },
        [](Hero& hero) { hero.path.pop_back(); },      [](Hero& hero) { hero.tags.emplace_back(); },
        [](Hero& hero) { hero.grid.push_back({1}); },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
      CAPTURE(i);
      const Played other = play(cpp_options(file, TICKTRUE_VERIFY), [&](int tick, std::vector<Hero>& heroes) {
        if (tick == 21) changes[i](heroes.at(1));
      });
      CAPTURE(other.report);
      CHECK(other.exit_code == 1);
      CHECK(contains(other.report, "tick 21 of 40"));
    }
  }
  auto reader = replay::TraceReader::open(file);
  REQUIRE(reader);
  const StateSchema& schema = reader->setup().schema;
  std::string names;
  for (const TableSchema& table : schema.tables)
    names += table.name + ":" + std::to_string(static_cast<int>(table.form)) + " ";
  CHECK(names ==
        "heroes:0 heroes.name:3 heroes.title:3 heroes.picture:2 heroes.inventory:1 heroes.inventory.label:3 "
        "heroes.path:1 heroes.tags:1 heroes.tags.value:3 heroes.grid:1 heroes.grid.value:1 ");
  CHECK(schema.tables[4].columns[3].name == "value.index");
  CHECK(schema.tables[6].columns[2].lane_count == 2);
}

TEST_CASE("reports put texts, bytes and lists together", "[capi][children][injection]") {
  const TracePath path;
  const std::string file = path("x.ttr");
  const auto set = [](int tick, std::vector<Hero>& heroes, const std::function<void(Hero&)>& change) {
    if (tick != 5) return;
    heroes.resize(4);
    for (std::size_t i = 0; i < heroes.size(); ++i) heroes[i].id = static_cast<std::uint32_t>(i);
    Hero& hero = heroes[3];
    hero.name = "bop";
    hero.picture.assign(500, 7);
    hero.inventory = {{1, 2, "axe"}, {3, 4, "a rope of 20 m, and some more of it"}, {5, 6, ""}};
    hero.grid = {{1, 2}, {3}};
    change(hero);
  };
  REQUIRE(play(cpp_options(file, TICKTRUE_RECORD), [&](int tick, std::vector<Hero>& heroes) {
            set(tick, heroes, [](Hero&) {});
          }).exit_code == 0);
  struct Case {
    std::function<void(Hero&)> change;
    std::vector<std::string> lines;
  };
  const std::vector<Case> cases{
      {[](Hero& hero) { hero.name = "bob"; },
       {"text    heroes[3].name  (id 3)", "value   expected \"bop\".  got \"bob\".  differs at character 2\n"}},
      {[](Hero& hero) { hero.name.clear(); }, {"expected \"bop\".  got \"\".  differs at character 0; 3 and 0 bytes"}},
      {[](Hero& hero) { hero.picture[321] = 0xab; },
       {"bytes   heroes[3].picture  (id 3)", "got ab 07 07", "differs at byte 321 of 500"}},
      {[](Hero& hero) { hero.inventory[1].label[25] = '\x1b'; },
       {"heroes[3].inventory[1].label", "\\x1b", "differs at character 25"}},
      {[](Hero& hero) { hero.inventory[1].kind = 4; },
       {"column  heroes.inventory.kind  heroes[3].inventory[1]", "expected 0003 (3).  got 0004 (4)"}},
      {[](Hero& hero) { hero.inventory.pop_back(); },
       {"column  heroes.inventory.owner  heroes[3].inventory[2]", "got no such row"}},
      {[](Hero& hero) { hero.grid[1][0] = 8; }, {"heroes[3].grid[1].value[0]", "expected 00000003 (3)"}},
      {[](Hero& hero) { hero.name = "::error::b\"p\n\x1b[2J\xff##[warning]"; },
       {"\\\"p\\n\\x1b[2J\\xff#\\u0023[warning]"}},
      {[](Hero& hero) { hero.name = std::string(400, 'n') + "\xc3\xa4" + std::string(400, 'm'); },
       {"got \"" + std::string(40, 'n') + "\"...", "3 and 802 bytes"}},
  };
  for (const Case& one : cases) {
    const Played other = play(cpp_options(file, TICKTRUE_VERIFY),
                              [&](int tick, std::vector<Hero>& heroes) { set(tick, heroes, one.change); });
    CAPTURE(other.report);
    CHECK(other.exit_code == 1);
    CHECK(other.report.find('\x1b') == std::string::npos);
    for (const std::string& line : one.lines) {
      CAPTURE(line);
      CHECK(contains(other.report, line));
    }
    CHECK(nlohmann::json::parse(other.json, nullptr, false).is_object());
  }
  const Played other = play(cpp_options(file, TICKTRUE_VERIFY), [&](int tick, std::vector<Hero>& heroes) {
    set(tick, heroes, [](Hero& hero) { hero.name = "bob"; });
  });
  const auto json = nlohmann::json::parse(other.json);
  const auto& contents = json["divergence"]["contents"];
  REQUIRE(contents.size() == 1);
  CHECK(contents[0]["place"] == "heroes[3].name");
  CHECK(contents[0]["expected"] == "bop");
  CHECK(contents[0]["got"] == "bob");
  CHECK(contents[0]["character"] == 2);
  CHECK(contents[0]["id"] == 3);
  CHECK(json["divergence"]["lane_count"] == 0);
}

TEST_CASE("the words of C++ and those of C record the same bytes", "[capi][children][columns][equivalence]") {
  const TracePath path;
  const auto step = [](int tick, std::vector<Note>& notes) {
    if (tick % 3 == 0) notes.push_back({static_cast<std::uint8_t>(tick), {}});
    for (Note& note : notes) note.text += "tick " + std::to_string(tick) + " ";
  };
  {
    std::vector<Note> notes;
    ticktrue::Session session(cpp_options(path("cpp.ttr"), TICKTRUE_RECORD));
    session.table("notes", notes);
    for (int tick = 0; tick < 20; ++tick) {
      session.begin_tick();
      step(tick, notes);
      session.end_tick();
    }
    REQUIRE(session.close() == 0);
  }
  const std::string file = path("c.ttr");
  const ticktrue::Options options = cpp_options(file, TICKTRUE_RECORD);
  ticktrue_session* session = ticktrue_open(&options);
  std::vector<Note> notes;
  const ticktrue_member kind = TICKTRUE_MEMBER(Note, kind, TICKTRUE_U8);
  const std::uint32_t table = ticktrue_table(session, "notes", sizeof(Note), &kind, 1);
  const ticktrue_elements text = [](void* user, const void* owner, std::uint32_t row, std::size_t* count) {
    const Note& note = (*static_cast<const std::vector<Note>*>(user))[row];
    CHECK(owner == &note);
    *count = note.text.size();
    return static_cast<const void*>(note.text.data());
  };
  ticktrue_text(session, "notes.text", "notes", text, &notes);
  for (int tick = 0; tick < 20; ++tick) {
    ticktrue_begin_tick(session, nullptr);
    step(tick, notes);
    ticktrue_rows(session, table, notes.data(), static_cast<std::uint32_t>(notes.size()));
    ticktrue_end_tick(session);
  }
  CHECK(std::string(ticktrue_message(session)).empty());
  REQUIRE(ticktrue_close(session) == 0);
  CHECK(path.bytes("c.ttr") == path.bytes("cpp.ttr"));
}

/// What a session says that registers a child in a wrong way.
std::string refusal(const std::string& file, const std::function<void(ticktrue_session*)>& call) {
  const ticktrue::Options options = cpp_options(file, TICKTRUE_RECORD);
  ticktrue_session* session = ticktrue_open(&options);
  const std::uint32_t values[] = {4, 9};
  const ticktrue_elements none = [](void*, const void*, std::uint32_t, std::size_t*) -> const void* { return nullptr; };
  ticktrue_column(session, "units", "id", values, TICKTRUE_U32, 1, 2, 0);
  ticktrue_text(session, "units.name", "units", none, nullptr);
  call(session);
  ticktrue_begin_tick(session, nullptr);
  ticktrue_end_tick(session);
  std::string message = ticktrue_message(session);
  const int exit_code = ticktrue_close(session);
  CHECK((exit_code == 2) == !message.empty());
  return message;
}

TEST_CASE("wrong words about children are refused with what was found", "[capi][children][errors]") {
  const TracePath path;
  const std::string file = path("x.ttr");
  static const auto none = [](void*, const void*, std::uint32_t, std::size_t*) -> const void* { return nullptr; };
  const ticktrue_member shown{"glow", TICKTRUE_F32 | TICKTRUE_SHOWN, 1, 0, 4};
  const ticktrue_member owner{"owner", TICKTRUE_U32, 1, 0, 4};
  struct Case {
    std::function<void(ticktrue_session*)> call;
    std::string message;
  };
  const std::vector<Case> cases{
      {[](auto* s) { ticktrue_text(s, "x", "none", none, nullptr); }, "table x: parent: found no table none"},
      {[](auto* s) { ticktrue_text(s, "x", "units.name", none, nullptr); }, "parent: found the pieces of units.name"},
      {[](auto* s) { ticktrue_bytes(s, "x", "units", nullptr, nullptr); }, "elements: found null, expected a callback"},
      {[&](auto* s) { ticktrue_child(s, "x", "units", none, nullptr, 4, &shown, 1); },
       "found a shown column in a child"},
      {[&](auto* s) { ticktrue_child(s, "x", "units", none, nullptr, 4, &owner, 1); },
       "a name that every child table has"},
      {[&](auto* s) { ticktrue_child(s, "x", "units", none, nullptr, 2, &owner, 1); }, "inside the 2 bytes of a row"},
      {[&](auto* s) { ticktrue_child(s, "x", "units", none, nullptr, 4, nullptr, 1); }, "members: found null"},
      {[](auto* s) { ticktrue_bytes(s, "units.name", "units", none, nullptr); }, "another parent, form or members"},
      {[](auto* s) { ticktrue_text(s, "", "units", none, nullptr); }, "name: found 0 bytes"},
      {[](auto* s) { ticktrue_key(s, "units.name", 1); }, "found a child table, whose key is owner and index"},
      {[](auto* s) { ticktrue_rows(s, 1, nullptr, 0); }, "found a child, whose elements a callback gives"},
      {[](auto* s) { ticktrue_column(s, "units.name", "x", nullptr, TICKTRUE_U8, 1, 0, 0); }, "found a child table"},
      {[](auto* s) { ticktrue_reference(s, "units.name", "size", "units"); }, "that every child table has"},
      {[](auto* s) {
         const ticktrue_elements null = [](void*, const void*, std::uint32_t row, std::size_t* count) -> const void* {
           *count = row;
           return nullptr;
         };
         ticktrue_text(s, "units.name", "units", null, nullptr);
       },
       "table units.name: owner 1: found null, expected the first of 1 bytes"},
      {[](auto* s) {
         const ticktrue_elements huge = [](void*, const void*, std::uint32_t, std::size_t* count) -> const void* {
           *count = SIZE_MAX;
           return "x";
         };
         ticktrue_text(s, "units.name", "units", huge, nullptr);
       },
       "with which the table grows beyond"},
      {[](auto* s) {
         const ticktrue_elements calls = [](void* user, const void* row, std::uint32_t, std::size_t*) -> const void* {
           CHECK(row == nullptr);  // the columns of the parent are registered one by one
           ticktrue_end_tick(static_cast<ticktrue_session*>(user));
           return nullptr;
         };
         ticktrue_text(s, "units.name", "units", calls, s);
       },
       "end_tick: found a call from inside a callback that gives elements"},
  };
  CHECK(refusal(file, [](ticktrue_session*) {}).empty());
  std::remove(file.c_str());
  for (const Case& one : cases) {
    CAPTURE(one.message);
    const std::string message = refusal(file, one.call);
    CAPTURE(message);
    CHECK(contains(message, one.message));
    std::remove(file.c_str());
  }
}

TEST_CASE("a callback may be registered again, a new child behind the first tick is refused",
          "[capi][children][errors]") {
  const TracePath path;
  const std::string file = path("x.ttr");
  const ticktrue::Options options = cpp_options(file, TICKTRUE_RECORD);
  ticktrue_session* session = ticktrue_open(&options);
  const std::uint8_t value = 1;
  const ticktrue_elements text = [](void* user, const void*, std::uint32_t, std::size_t* count) -> const void* {
    *count = std::strlen(static_cast<const char*>(user));
    return user;
  };
  char first[] = "first", second[] = "second";
  ticktrue_column(session, "t", "value", &value, TICKTRUE_U8, 1, 1, 0);
  ticktrue_text(session, "t.text", "t", text, first);
  CHECK(ticktrue_begin_tick(session, nullptr) == TICKTRUE_OK);
  CHECK(ticktrue_text(session, "t.text", "t", text, second) == TICKTRUE_OK);
  CHECK(ticktrue_end_tick(session) == TICKTRUE_OK);
  CHECK(ticktrue_text(session, "t.more", "t", text, second) == TICKTRUE_FAILED);
  CHECK(contains(ticktrue_message(session), "found a new table after the first tick"));
  ticktrue_close(session);
}

std::string save_notes(const std::vector<Note>& notes) {
  std::string bytes = "N";
  for (const Note& note : notes) bytes += static_cast<char>(note.kind) + note.text + '\0';
  return bytes;
}

bool load_notes(std::vector<Note>& notes, std::span<const std::byte> bytes, bool forgets) {
  notes.clear();
  for (std::size_t at = 1; at < bytes.size();) {
    Note& note = notes.emplace_back();
    note.kind = static_cast<std::uint8_t>(bytes[at++]);
    for (; at < bytes.size() && bytes[at] != std::byte{0}; ++at) note.text += static_cast<char>(bytes[at]);
    ++at;
    if (forgets) note.text = "lost";
  }
  return true;
}

TEST_CASE("a sync test names the text that load does not bring back", "[capi][children][saves][injection]") {
  const TracePath path;
  const auto run = [&](const std::string& name, auto load) {
    std::vector<Note> notes;
    const std::string file = path(name);
    ticktrue::Options options = cpp_options(file, TICKTRUE_RECORD);
    options.sync_test = 3;
    options.saves(
        notes, [](const std::vector<Note>& all) { return save_notes(all); }, load);
    ticktrue::Session session(options);
    session.table("notes", notes);
    while (session.tick() < 12 && ticktrue_status(session.handle()) == TICKTRUE_OK) {
      session.begin_tick();
      if (session.tick() % 2 == 0) notes.push_back({1, "note " + std::to_string(session.tick())});
      session.end_tick();
    }
    CHECK(std::string(session.error()) == "");
    ticktrue_finish(session.handle());
    return std::string(ticktrue_report(session.handle()));
  };
  const std::string good = run("good.ttr", [](std::vector<Note>& notes, std::span<const std::byte> bytes) {
    return load_notes(notes, bytes, false);
  });
  CAPTURE(good);
  CHECK(contains(good, "ran twice with the same state"));
  const std::string bad = run("bad.ttr", [](std::vector<Note>& notes, std::span<const std::byte> bytes) {
    return load_notes(notes, bytes, true);
  });
  CAPTURE(bad);
  CHECK(contains(bad, "notes[0].text"));
  CHECK(contains(bad, "got \"lost\""));
}

}  // namespace
}  // namespace ticktrue::test
