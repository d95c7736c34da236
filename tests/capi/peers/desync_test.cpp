// Roots of ticks, and the messages that locate a desync: large states, small packets, lost states, forged bytes.
// SPDX-License-Identifier: MIT
#include <cstdint>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "base/hash.h"
#include "include/ticktrue.h"
#include "replay/trace_reader.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

using ticktrue::Bytes;
using ticktrue::test::contains;
using ticktrue::test::TracePath;

namespace {

/// Many rows with ids, so that not all of them go into a message.
struct Herd {
  struct Sheep {
    std::uint32_t id = 0;
    float wool = 0;
    double place[2] = {0, 0};
  };
  std::vector<Sheep> sheep;
  std::uint32_t grass = 1;

  explicit Herd(std::size_t count) : sheep(count) {
    for (std::size_t i = 0; i < count; ++i) sheep[i].id = static_cast<std::uint32_t>(2 * i);
  }
  void step() {
    for (Sheep& one : sheep) {
      grass = grass * 1664525u + 1013904223u;
      one.wool += static_cast<float>(grass >> 24) / 256.0f;
      one.place[grass % 2] += 0.125;
    }
  }
  void show(ticktrue_session* session, bool is_keyed) {
    const ticktrue_member members[] = {TICKTRUE_MEMBER(Sheep, id, TICKTRUE_U32),
                                       TICKTRUE_MEMBER(Sheep, wool, TICKTRUE_F32),
                                       TICKTRUE_MEMBER(Sheep, place, TICKTRUE_F64)};
    ticktrue_column(session, "world", "grass", &grass, TICKTRUE_U32, 1, 1, 0);
    const std::uint32_t table = ticktrue_table(session, "sheep", sizeof(Sheep), members, 3);
    if (is_keyed) ticktrue_key(session, "sheep", 1);
    ticktrue_rows(session, table, sheep.data(), static_cast<std::uint32_t>(sheep.size()));
  }
};

struct HerdSide {
  Herd herd;
  ticktrue_session* session = nullptr;
  std::uint32_t table = 1;

  HerdSide(std::uint32_t player, std::size_t count, bool is_keyed, std::uint64_t peer_bytes = 0) : herd(count) {
    ticktrue_options options = {};
    options.struct_size = sizeof options;
    options.mode = TICKTRUE_LIVE;
    options.name = "herd";
    options.flags = TICKTRUE_QUIET;
    options.player = player;
    options.peer_bytes = peer_bytes;
    session = ticktrue_open(&options);
    herd.show(session, is_keyed);
  }
  HerdSide(const HerdSide&) = delete;
  ~HerdSide() { ticktrue_close(session); }
  template <typename Change>
  void run(Change change) {
    CHECK(ticktrue_begin_tick(session, nullptr) == TICKTRUE_OK);
    herd.step();
    change(herd);
    ticktrue_rows(session, table, herd.sheep.data(), static_cast<std::uint32_t>(herd.sheep.size()));
    const int status = ticktrue_end_tick(session);
    CAPTURE(ticktrue_message(session));
    REQUIRE(status == TICKTRUE_OK);
  }
  std::uint64_t root(std::uint64_t tick) {
    std::uint64_t value = 0;
    REQUIRE(ticktrue_root(session, tick, &value) == TICKTRUE_OK);
    return value;
  }
};

void no_change(Herd&) {}

/// Messages go back and forth, each side one at a time, some of them lost. Returns how many steps it took.
int exchange_messages(HerdSide& a, std::uint32_t number_a, HerdSide& b, std::uint32_t number_b, std::size_t size,
                      double loss = 0) {
  std::mt19937 random(7);
  int quiet = 0;
  for (int step = 1; step < 20000; ++step) {
    std::vector<std::uint8_t> to_b(size), to_a(size);
    to_b.resize(ticktrue_desync_message(a.session, number_b, to_b.data(), size));
    to_a.resize(ticktrue_desync_message(b.session, number_a, to_a.data(), size));
    const auto arrives = [&] { return static_cast<double>(random() % 1000) / 1000 >= loss; };
    if (!to_b.empty() && arrives()) {
      const int status = ticktrue_desync_receive(b.session, number_a, to_b.data(), to_b.size());
      CHECK((status == TICKTRUE_OK || status == TICKTRUE_DIVERGED));
    }
    if (!to_a.empty() && arrives()) {
      const int status = ticktrue_desync_receive(a.session, number_b, to_a.data(), to_a.size());
      CHECK((status == TICKTRUE_OK || status == TICKTRUE_DIVERGED));
    }
    quiet = to_a.empty() && to_b.empty() ? quiet + 1 : 0;
    if (quiet > 3) return -1;
    if (step > 8 && step % 16 != 0 && quiet == 0) continue;  // a report compares whole states
    int whole_a = 0, whole_b = 0;
    ticktrue_desync_report(a.session, &whole_a);
    ticktrue_desync_report(b.session, &whole_b);
    if (whole_a != 0 && whole_b != 0) return step;
  }
  return -1;
}

std::string herd_report(const HerdSide& side) {
  return ticktrue_desync_report(side.session, nullptr);
}

}  // namespace

TEST_CASE("the roots of the last 4,096 confirmed ticks are those of the trace", "[capi][peers]") {
  const TracePath path;
  const std::string file = path("roots.ttr");
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = TICKTRUE_RECORD;
  options.path = file.c_str();
  options.name = "roots";
  options.detail = TICKTRUE_DETAIL_ROOT;
  options.rollback_max = 8;
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC;
  std::uint32_t value = 1;
  ticktrue_session* session = ticktrue_open(&options);
  ticktrue_column(session, "world", "value", &value, TICKTRUE_U32, 1, 1, 0);
  std::uint64_t root = 17;
  constexpr std::uint64_t tick_count = 4'500;
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    ticktrue_begin_tick(session, nullptr);
    value = value * 3 + 1;
    ticktrue_end_tick(session);
    CHECK(ticktrue_root(session, tick, &root) == TICKTRUE_END);  // not confirmed
    if (tick % 5 != 4) continue;
    ticktrue_confirm(session, tick + 1);
    CHECK(ticktrue_root(session, tick, &root) == TICKTRUE_OK);
  }
  CHECK(ticktrue_root(session, tick_count - 4'096, &root) == TICKTRUE_OK);
  root = 17;
  CHECK(ticktrue_root(session, tick_count - 4'097, &root) == TICKTRUE_END);
  CHECK(ticktrue_root(session, tick_count, &root) == TICKTRUE_END);
  CHECK(root == 17);
  CHECK(ticktrue_root(nullptr, 0, &root) == TICKTRUE_END);
  CHECK(ticktrue_finish(session) == 0);
  auto reader = ticktrue::replay::TraceReader::open(file);
  REQUIRE(reader.has_value());
  std::uint64_t compared = 0;
  for (;;) {
    const auto& item = reader->next();
    if (std::holds_alternative<ticktrue::replay::CheckpointRecord>(item)) continue;
    const auto* record = std::get_if<ticktrue::replay::TickRecord>(&item);
    if (record == nullptr) break;
    if (ticktrue_root(session, record->tick, &root) != TICKTRUE_OK) continue;
    CHECK(root == record->root_hash);
    ++compared;
  }
  CHECK(compared == 4'096);
  ticktrue_close(session);
}

TEST_CASE("roots of peers are compared whatever arrives first", "[capi][peers]") {
  HerdSide side(0, 4, true);
  HerdSide same(1, 4, true);
  for (int tick = 0; tick < 3; ++tick) same.run(no_change);
  CHECK(ticktrue_peer_root(side.session, 1, 2, same.root(2)) == TICKTRUE_OK);  // before its tick is done here
  CHECK(ticktrue_peer_root(side.session, 1, 90'000, 1) == TICKTRUE_OK);        // too far ahead: left out
  CHECK(ticktrue_peer_root(side.session, 1, ~std::uint64_t{0}, 1) == TICKTRUE_OK);
  for (int tick = 0; tick < 3; ++tick) side.run(no_change);
  CHECK(ticktrue_peer_root(side.session, 1, 0, same.root(0)) == TICKTRUE_OK);
  CHECK(ticktrue_peer_root(side.session, 1, 0, same.root(0)) == TICKTRUE_OK);
  CHECK(ticktrue_peer_root(side.session, 1, 0, 5) == TICKTRUE_OK);  // the first one counts
  CHECK(ticktrue_peer_root(side.session, 2, 4, 5) == TICKTRUE_OK);
  CHECK(herd_report(side).empty());
  CHECK(ticktrue_peer_root(side.session, 2, 3, 5) == TICKTRUE_OK);
  side.run(no_change);
  CHECK(ticktrue_peer_root(side.session, 1, 1, same.root(1)) == TICKTRUE_DIVERGED);  // known since tick 3
  CHECK(ticktrue_status(side.session) == TICKTRUE_OK);
  side.run(no_change);
  CHECK(contains(herd_report(side), "desync  herd  tick 3\n"));
  CHECK(ticktrue_peer_root(side.session, 2, 1, 6) == TICKTRUE_DIVERGED);
  CHECK(contains(herd_report(side), "desync  herd  tick 1\n"));
  CHECK(contains(herd_report(side), "who     players 0, 1 agree; player 2 is the odd one out\n"));
  CHECK(contains(herd_report(side), "missing player 2: its state is not known yet\n"));
  CHECK(ticktrue_finish(side.session) == 1);
  const std::string text = ticktrue_report(side.session);
  CAPTURE(text);
  CHECK(contains(text, "live  herd  5 ticks (0.083 s)\n"));
  CHECK(contains(text, "player 1: 3 ticks compared, the same up to tick 2, 1 root came again with another value\n"));
  CHECK(contains(text, "player 2: 2 ticks compared, other from tick 1 on\n"));
  const std::string json = ticktrue_report_json(side.session);
  CHECK(contains(json, "\"schema\":\"ticktrue.live/1\""));
  CHECK(contains(json, "\"tick\":1,\"agreed\":null,\"complete\":false"));
  CHECK(contains(json, "\"odd\":[2]"));
}

TEST_CASE("an old root does not displace one that waits for its tick", "[capi][peers]") {
  HerdSide side(0, 1, true);
  for (int tick = 0; tick < 10; ++tick) side.run(no_change);
  CHECK(ticktrue_peer_root(side.session, 1, 4'100, 5) == TICKTRUE_OK);  // another one than here
  CHECK(ticktrue_peer_root(side.session, 1, 4, side.root(4)) == TICKTRUE_OK);
  for (int tick = 10; tick < 4'101; ++tick) side.run(no_change);
  CHECK(contains(herd_report(side), "desync  herd  tick 4100\n"));
}

TEST_CASE("two round trips locate a desync of a small state", "[capi][peers]") {
  HerdSide a(0, 20, true), b(3, 20, true);
  for (int tick = 0; tick < 4; ++tick) {
    a.run(no_change);
    b.run([&](Herd& herd) { herd.sheep[7].wool += tick == 2 ? 1.0f : 0.0f; });
    ticktrue_peer_root(a.session, 3, static_cast<std::uint64_t>(tick), b.root(static_cast<std::uint64_t>(tick)));
  }
  CHECK(herd_report(b).empty());
  CHECK(exchange_messages(a, 0, b, 3, 1200) <= 4);  // messages each way
  CAPTURE(herd_report(a));
  CHECK(contains(herd_report(a), "desync  herd  tick 2\n"));
  CHECK(contains(herd_report(a), "column  sheep.wool        row 7 (id 14)\n"));
  CHECK(herd_report(a) == herd_report(b));
  for (int i = 0; i < 2; ++i) exchange_messages(a, 0, b, 3, 1200);  // the last answers
  CHECK(ticktrue_desync_message(a.session, 3, Bytes(1200).data(), 1200) == 0);
  CHECK(ticktrue_desync_message(b.session, 0, Bytes(1200).data(), 1200) == 0);
}

TEST_CASE("rows of a large state are found by cells, in packets of any size", "[capi][peers]") {
  for (const bool is_keyed : {true, false})
    for (const std::size_t size : {std::size_t{256}, std::size_t{1200}, std::size_t{60'000}}) {
      CAPTURE(is_keyed, size);
      HerdSide a(0, 12'000, is_keyed), b(1, 12'000, is_keyed);
      a.run(no_change);
      b.run([](Herd& herd) {
        herd.sheep[11'000].place[1] += 0.5;
        herd.sheep[3].wool += 1.0f;
      });
      CHECK(ticktrue_peer_root(b.session, 0, 0, a.root(0)) == TICKTRUE_DIVERGED);
      CHECK(exchange_messages(a, 0, b, 1, size, size == 1200 ? 0.2 : 0.0) > 0);
      CAPTURE(herd_report(a));
      CHECK(herd_report(a) == herd_report(b));
      CHECK(contains(herd_report(a), is_keyed ? "sheep.wool        row 3 (id 6)\n" : "sheep.wool        row 3\n"));
      CHECK(contains(herd_report(a), is_keyed ? "sheep.place       row 11000 (id 22000), lane 1\n"
                                              : "sheep.place       row 11000, lane 1\n"));
      CHECK_FALSE(contains(herd_report(a), "more "));
    }
}

TEST_CASE("a row that one side lacks is named by its key", "[capi][peers]") {
  for (const std::size_t count : {std::size_t{12}, std::size_t{9'000}}) {
    HerdSide a(0, count, true), b(1, count, true);
    a.run(no_change);
    b.run([](Herd& herd) { herd.sheep.erase(herd.sheep.begin() + 5); });
    ticktrue_peer_root(a.session, 1, 0, b.root(0));
    CHECK(exchange_messages(a, 0, b, 1, 1200) > 0);
    CAPTURE(count, herd_report(a));
    CHECK(herd_report(a) == herd_report(b));
    CHECK(contains(herd_report(a), "column  sheep.id          row 5 (id 10)\n"));
    CHECK(contains(herd_report(a), "player 0: 0000000a (10).  player 1: no such row\n"));
  }
}

TEST_CASE("where all of a large state differs, the first rows are sent", "[capi][peers]") {
  HerdSide a(0, 60'000, false), b(1, 60'000, false);
  a.run(no_change);
  b.run([](Herd& herd) {
    for (Herd::Sheep& one : herd.sheep) one.wool += 1.0f;
  });
  ticktrue_peer_root(a.session, 1, 0, b.root(0));
  CHECK(exchange_messages(a, 0, b, 1, 60'000) > 0);
  CAPTURE(herd_report(a));
  CHECK(herd_report(a) == herd_report(b));
  CHECK(contains(herd_report(a), "column  sheep.wool        row 0\n"));
  CHECK(contains(herd_report(a), "more    at least "));
}

TEST_CASE("a state that is kept no more is told, and the tick is still named", "[capi][peers]") {
  HerdSide a(0, 6, true), b(1, 6, true, 1);  // 1 byte: the newest state alone
  for (int tick = 0; tick < 5; ++tick) {
    a.run(no_change);
    b.run([&](Herd& herd) { herd.grass += tick == 1 ? 1u : 0u; });
  }
  for (std::uint64_t tick = 0; tick < 5; ++tick) ticktrue_peer_root(a.session, 1, tick, b.root(tick));
  CHECK(exchange_messages(a, 0, b, 1, 1200) == -1);
  CAPTURE(herd_report(a));
  CHECK(contains(herd_report(a), "desync  herd  tick 1\n"));
  CHECK(contains(herd_report(a), "player 1: keeps the state of this tick no more (peer_bytes of the options)\n"));
  CHECK(ticktrue_desync_message(a.session, 1, Bytes(300).data(), 300) == 0);
}

TEST_CASE("forged and damaged messages are refused or read, never a crash", "[capi][peers][corruption]") {
  std::mt19937 random(11);
  HerdSide a(0, 20, true), b(1, 20, true);
  a.run(no_change);
  b.run([](Herd& herd) { herd.sheep[3].wool += 1.0f; });
  ticktrue_peer_root(b.session, 0, 0, a.root(0));
  std::vector<Bytes> seen;
  for (int i = 0; i < 12; ++i) {
    Bytes message(1200);
    message.resize(ticktrue_desync_message(b.session, 0, message.data(), message.size()));
    if (message.empty()) break;
    seen.push_back(message);
    ticktrue_desync_receive(a.session, 1, message.data(), message.size());
    Bytes answer(1200);
    answer.resize(ticktrue_desync_message(a.session, 1, answer.data(), answer.size()));
    if (!answer.empty()) ticktrue_desync_receive(b.session, 0, answer.data(), answer.size());
  }
  REQUIRE(seen.size() >= 2);
  int refused = 0;
  for (int run = 0; run < 6'000; ++run) {
    // A fresh side every 50 runs: it still reads the documents of forged parts.
    static HerdSide* fresh = nullptr;
    if (run % 50 == 0) {
      delete fresh;
      fresh = new HerdSide(0, 20, true);
      fresh->run(no_change);
    }
    Bytes bytes = seen[random() % seen.size()];
    for (auto changes = 1 + random() % 3; changes > 0; --changes) {
      const std::size_t at = run % 3 == 0 ? random() % bytes.size() : 28 + random() % (bytes.size() - 36);
      bytes[at] = static_cast<std::uint8_t>(run % 2 == 0 ? random() : (random() % 2 == 0 ? 0xff : 0));
    }
    if (run % 7 == 0) bytes.resize(random() % bytes.size());
    if (run % 5 != 0 && bytes.size() > 8) {
      const std::uint64_t sum = ticktrue::hash64(ticktrue::ByteView(bytes).first(bytes.size() - 8));
      for (std::size_t i = 0; i < 8; ++i) bytes[bytes.size() - 8 + i] = static_cast<std::uint8_t>(sum >> (8 * i));
    }
    const int status = ticktrue_desync_receive(fresh->session, 1, bytes.data(), bytes.size());
    refused += status == TICKTRUE_REFUSED ? 1 : 0;
    if (status == TICKTRUE_FAILED || ticktrue_status(fresh->session) != TICKTRUE_OK)
      FAIL(ticktrue_message(fresh->session));
    int is_complete = 0;
    ticktrue_desync_report(fresh->session, &is_complete);
    Bytes answer(1200);
    ticktrue_desync_message(fresh->session, 1, answer.data(), answer.size());
    if (run == 5'999) delete fresh;
  }
  CHECK(refused > 3'000);
}

TEST_CASE("a message that is no other player's changes nothing", "[capi][peers][corruption]") {
  HerdSide a(0, 4, true), b(1, 4, true), other(1, 4, false);
  for (HerdSide* side : {&a, &b, &other}) side->run([&](Herd& herd) { herd.grass += side == &a ? 0u : 1u; });
  ticktrue_peer_root(b.session, 0, 0, a.root(0));
  ticktrue_peer_root(other.session, 0, 0, a.root(0));
  Bytes message(1200);
  message.resize(ticktrue_desync_message(b.session, 0, message.data(), message.size()));
  CHECK(ticktrue_desync_receive(a.session, 2, message.data(), message.size()) == TICKTRUE_REFUSED);
  CHECK(ticktrue_desync_receive(b.session, 0, message.data(), message.size()) == TICKTRUE_REFUSED);
  CHECK(ticktrue_desync_receive(a.session, 1, nullptr, 5) == TICKTRUE_REFUSED);
  message.resize(1200);
  message.resize(ticktrue_desync_message(other.session, 0, message.data(), message.size()));
  CHECK(ticktrue_desync_receive(a.session, 1, message.data(), message.size()) == TICKTRUE_REFUSED);  // other columns
  CHECK(herd_report(a).empty());
}

TEST_CASE("a recorded live game keeps its bytes, and its report has the desync", "[capi][peers]") {
  const TracePath path;
  const auto record = [&](const std::string& name, bool is_live) {
    const std::string file = path(name);
    std::string record_word = "--record", program = "game";
    std::string words = file;
    char* const arguments[] = {program.data(), record_word.data(), words.data(), nullptr};
    ticktrue_options options = {};
    options.struct_size = sizeof options;
    options.mode = TICKTRUE_LIVE;
    options.name = "herd";
    options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC;
    ticktrue_session* session = ticktrue_open_arguments(&options, 3, arguments);
    Herd herd(5);
    herd.show(session, true);
    if (is_live) CHECK(ticktrue_hello(session, nullptr, 0) > 0);
    for (std::uint64_t tick = 0; tick < 6; ++tick) {
      ticktrue_begin_tick(session, nullptr);
      herd.step();
      ticktrue_end_tick(session);
      if (is_live) ticktrue_peer_root(session, 4, tick, tick + 1);
    }
    const int code = ticktrue_finish(session);
    const std::string text = ticktrue_report(session), json = ticktrue_report_json(session);
    CAPTURE(text, json, ticktrue_message(session));
    CHECK(code == (is_live ? 1 : 0));
    CHECK(contains(text, "recorded  " + file));
    CHECK(contains(text, "desync  herd  tick 0\n") == is_live);
    CHECK(contains(text, "player 4: 1 tick compared, other from tick 0 on") == is_live);
    CHECK(contains(json, "\"desync\": {\"schema\":\"ticktrue.desync/2\"") == is_live);
    ticktrue_close(session);
    return path.bytes(name);
  };
  CHECK(record("plain.ttr", false) == record("live.ttr", true));
}

TEST_CASE("without words on the command line a live program has a live session", "[capi][peers]") {
  char program[] = "game";
  char* const arguments[] = {program, nullptr};
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = TICKTRUE_LIVE;
  options.name = "herd";
  options.flags = TICKTRUE_QUIET;
  ticktrue_session* session = ticktrue_open_arguments(&options, 1, arguments);
  REQUIRE(session != nullptr);
  CHECK(ticktrue_status(session) == TICKTRUE_OK);
  CHECK(ticktrue_close(session) == 0);
}

TEST_CASE("wrong calls about other players are told", "[capi][peers]") {
  const auto message_of = [](auto call) {
    HerdSide side(2, 3, true);
    side.run(no_change);
    call(side.session);
    CHECK(ticktrue_status(side.session) == TICKTRUE_FAILED);
    return std::string(ticktrue_message(side.session));
  };
  CHECK(contains(message_of([](auto* s) { ticktrue_peer_root(s, 2, 0, 1); }),
                 "peer_root: player: found 2, expected another one than this, which is 2"));
  CHECK(contains(message_of([](auto* s) { ticktrue_peer_root(s, 255, 0, 1); }), "found 255, expected"));
  CHECK(contains(message_of([](auto* s) {
                   char small[255];
                   ticktrue_desync_message(s, 1, small, sizeof small);
                 }),
                 "desync_message: size: found 255 bytes, expected at least 256"));
  CHECK(contains(message_of([](auto* s) { ticktrue_root(s, 0, nullptr); }), "root: found null"));
  CHECK(contains(message_of([](auto* s) {
                   static const std::uint8_t value = 0;
                   ticktrue_column(s, "late", "value", &value, TICKTRUE_U8, 1, 1, 0);
                 }),
                 "late"));
  const auto refused = [](auto change) {
    ticktrue_options options = {};
    options.struct_size = sizeof options;
    options.mode = TICKTRUE_LIVE;
    options.name = "herd";
    options.flags = TICKTRUE_QUIET;
    change(options);
    ticktrue_session* session = ticktrue_open(&options);
    const std::string message = ticktrue_message(session);
    CHECK(ticktrue_close(session) == 2);
    return message;
  };
  CHECK(contains(refused([](auto& o) { o.path = "x.ttr"; }), "options: path: found a file name in a live session"));
  CHECK(contains(refused([](auto& o) { o.player = 255; }), "options: player: found 255, expected at most 254"));
  CHECK(contains(refused([](auto& o) { o.reserved = 1; }), "options: reserved: found 1"));
  CHECK(contains(refused([](auto& o) { o.mode = 4; }), "expected TICKTRUE_RECORD, TICKTRUE_VERIFY or TICKTRUE_LIVE"));
  CHECK(contains(refused([](auto& o) {
                   o.sync_test = 1;
                   o.save = [](void*, void*, std::size_t) { return std::size_t{1}; };
                   o.load = [](void*, const void*, std::size_t) { return 0; };
                 }),
                 "options: sync_test: found it in a live session"));
  // Without a session, every call does nothing.
  CHECK(ticktrue_hello(nullptr, nullptr, 0) == 0);
  CHECK(ticktrue_hello_check(nullptr, 1, nullptr, 0, nullptr, 0) == TICKTRUE_OK);
  CHECK(ticktrue_peer_root(nullptr, 1, 0, 0) == TICKTRUE_OK);
  CHECK(ticktrue_desync_message(nullptr, 1, nullptr, 0) == 0);
  CHECK(ticktrue_desync_receive(nullptr, 1, nullptr, 0) == TICKTRUE_OK);
  CHECK(std::string(ticktrue_desync_report(nullptr, nullptr)).empty());
}
