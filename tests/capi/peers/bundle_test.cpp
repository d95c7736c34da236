// Bundles: what each player writes after a desync is read back as its session told it, and runs again.
// SPDX-License-Identifier: MIT
#include "verifier/peers/bundle.h"

#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "replay/format/peer.h"
#include "replay/trace_reader.h"
#include "replay/trace_writer.h"
#include "tests/capi/peers/live_match.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/peers/peer_rows.h"

namespace {

using namespace ticktrue;
using namespace ticktrue::test;

MatchOptions flip_options(std::uint64_t seed, const TracePath& place) {
  std::mt19937_64 random(seed);
  MatchOptions options;
  options.seed = seed;
  options.player_count = 2 + static_cast<std::uint32_t>(seed % 3);
  options.rolls_back = random() % 2 == 0;
  options.keeps = static_cast<Keeps>(seed / 3 % 3);
  options.has_saves = random() % 4 != 0;
  options.has_other_builds = true;
  options.folder = place("");
  options.fault = {Fault::flip,
                   static_cast<std::uint32_t>(random() % options.player_count),
                   1 + random() % 35,
                   static_cast<std::size_t>(random() % 6),
                   static_cast<std::size_t>(random() % unit_count),
                   static_cast<unsigned>(random() % 23)};
  return options;
}

/// Runs the ticks of a bundle again, as the program of its recorder.
int run_again(const std::string& path, const PlantedFault& fault, bool has_saves, std::string& report) {
  LiveGame game(0);
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = TICKTRUE_VERIFY;
  options.path = path.c_str();
  options.name = "live-game";
  options.version = 1;
  options.flags = TICKTRUE_QUIET;
  if (has_saves) {
    options.save = save_game;
    options.load = load_game;
    options.user = &game;
  }
  ticktrue_session* session = ticktrue_open(&options);
  std::size_t size = 0;
  const void* setup = ticktrue_setup(session, &size);
  std::uint64_t seed = 0;
  if (size == sizeof seed) std::memcpy(&seed, setup, size);
  game = LiveGame(seed);
  game.show(session);
  for (;;) {
    std::array<std::uint8_t, match_player_max> inputs{};
    if (ticktrue_input(session, inputs.data(), inputs.size()) != TICKTRUE_OK) break;
    if (ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK) break;
    const std::uint64_t tick = game.tick;
    game.step(inputs, fault);
    if (fault.kind == Fault::flip && tick == fault.tick) game.flip(fault);
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
  }
  const int code = ticktrue_finish(session);
  report = std::string(ticktrue_report(session)) + ticktrue_message(session);
  ticktrue_close(session);
  return code;
}

/// The text of a bundle, as the tool prints it.
std::string text_of_bundle(const std::string& path, std::uint64_t& first_tick, std::size_t& warnings) {
  auto reader = replay::TraceReader::open(path);
  REQUIRE(reader);
  const auto bundle = verifier::Bundle::read(*reader);
  REQUIRE(bundle);
  REQUIRE(bundle->has_value());
  first_tick = reader->first_tick();
  warnings = (**bundle).warnings().size();
  return verifier::desync_text(reader->setup().schema, (**bundle).finding());
}

std::string play_for_bundle(const MatchOptions& options, const std::string& path, std::uint32_t player = 0) {
  Match match(options);
  REQUIRE(match.play());
  CHECK(ticktrue_bundle(match.players[player]->session(), path.c_str()) == TICKTRUE_OK);
  return match.players[player]->report();
}

}  // namespace

TEST_CASE("bundles of 2 to 4 players tell what their sessions told, and run again", "[capi][peers][bundle]") {
  std::size_t late = 0, in_memory = 0;
  for (std::uint64_t seed = 0; seed < 36; ++seed) {
    CAPTURE(seed);
    const TracePath place;
    const MatchOptions options = flip_options(seed, place);
    Match match(options);
    REQUIRE(match.play());
    std::string first_text;
    for (std::uint32_t p = 0; p < options.player_count; ++p) {
      CAPTURE(p);
      MatchPlayer& player = *match.players[p];
      const std::string path = place("bundle_" + std::to_string(p) + ".ttr");
      const int status = ticktrue_bundle(player.session(), path.c_str());
      CAPTURE(ticktrue_message(player.session()));
      REQUIRE(status == TICKTRUE_OK);
      std::uint64_t first_tick = 0;
      std::size_t warnings = 0;
      const std::string text = text_of_bundle(path, first_tick, warnings);
      CHECK(text == player.report());
      CHECK(warnings == 0);
      CHECK(contains(text, "desync  live-game  tick " + std::to_string(options.fault.tick) + "\n"));
      CHECK(contains(text, "differs optimize: player 0 speed, player 1 no\n"));
      if (p == 0) first_text = text;
      CHECK(text == first_text);
      CHECK(first_tick <= options.fault.tick);
      late += first_tick > 0 ? 1 : 0;
      in_memory += options.keeps == Keeps::memory ? 1 : 0;
      const bool has_saves = options.keeps != Keeps::memory && options.has_saves;
      if (!has_saves) CHECK(first_tick == 0);
      if (has_saves && options.fault.tick > 12) CHECK(first_tick > 0);
      const PlantedFault fault = options.fault.player == p ? options.fault : PlantedFault();
      std::string report;
      const int code = run_again(path, fault, has_saves, report);
      CAPTURE(report);
      CHECK(code == 0);
      CHECK(contains(report, "match  " + path));
      CHECK(contains(report, "a bundle of several players"));
      // Without its bug, the program of the odd one out does not give its states.
      if (options.fault.player == p) CHECK(run_again(path, PlantedFault(), has_saves, report) == 1);
      CHECK(ticktrue_finish(player.session()) == 1);
      CHECK(contains(ticktrue_report(player.session()), "  note    bundle " + path + ": ticks "));
    }
  }
  CHECK(late > 20);
  CHECK(in_memory > 20);
}

TEST_CASE("a cut or changed bundle is refused, or has the recorded facts", "[capi][peers][bundle][corruption]") {
  const TracePath place;
  MatchOptions options = flip_options(4, place);
  options.player_count = 3;
  options.keeps = Keeps::recording;
  play_for_bundle(options, place("b.ttr"));
  const std::string text = place.bytes("b.ttr");
  const Bytes whole(text.begin(), text.end());
  const auto peers_of = [](ByteView bytes, replay::TraceCondition& condition) {
    condition = replay::TraceCondition::damaged;
    std::vector<replay::PeerRecord> peers;
    auto reader = replay::TraceReader::open_bytes(bytes, "b.ttr");
    if (!reader) return peers;
    while (!std::holds_alternative<std::monostate>(reader->next())) {
    }
    condition = reader->tail().condition;
    peers = reader->tail().peers;
    const auto bundle = verifier::Bundle::read(*reader);
    if (bundle && *bundle) CHECK(!(**bundle).text(reader->setup().schema).empty());
    return peers;
  };
  replay::TraceCondition condition;
  const std::vector<replay::PeerRecord> recorded = peers_of(whole, condition);
  REQUIRE(condition == replay::TraceCondition::complete);
  REQUIRE(recorded.size() == 2);
  const auto require_recorded = [&](ByteView bytes) {
    for (const replay::PeerRecord& peer : peers_of(bytes, condition))
      REQUIRE((peer == recorded[0] || peer == recorded[1]));
    REQUIRE(condition != replay::TraceCondition::complete);
  };
  for (std::size_t size = 0; size < whole.size(); size += 1 + size % 5) {
    CAPTURE(size);
    require_recorded(ByteView(whole).first(size));
  }
  std::mt19937 random(7);
  bool one_is_left = false;
  for (int i = 0; i < 1500; ++i) {
    // Half of the changes in the last part, where the peers stand.
    const std::size_t at = i % 2 == 0 ? random() % whole.size() : whole.size() - 1 - random() % (whole.size() / 3);
    Bytes changed = whole;
    changed[at] ^= static_cast<std::uint8_t>(1u << random() % 8);
    CAPTURE(at);
    require_recorded(changed);
    one_is_left = one_is_left || peers_of(changed, condition).size() == 1;
  }
  CHECK(one_is_left);
  // Recovery copies them.
  const auto recovered = replay::recover_trace(place("b.ttr"), place("again.ttr"), false);
  REQUIRE(recovered);
  const std::string again = place.bytes("again.ttr");
  CHECK(peers_of(Bytes(again.begin(), again.end()), condition) == recorded);
  CHECK(condition == replay::TraceCondition::complete);
}

TEST_CASE("a bundle with rows that do not give the root of their player says so", "[capi][peers][bundle]") {
  const TracePath place;
  MatchOptions options = flip_options(3, place);
  options.keeps = Keeps::recording;
  options.fault.player = 1;
  play_for_bundle(options, place("b.ttr"));
  auto reader = replay::TraceReader::open(place("b.ttr"));
  REQUIRE(reader);
  const auto forge = [&](const std::string& path, const std::function<void(replay::PeerRecord&)>& change) {
    replay::WriterOptions plain;
    plain.allow_third = true;
    plain.sync = false;
    auto writer = replay::TraceWriter::create(path, reader->setup(), reader->facts(), plain);
    REQUIRE(writer);
    reader->rewind();
    const auto& first = std::get<replay::CheckpointRecord>(reader->next());
    if (first.tick > 0) writer->begin_at(first.tick, first.time_s.value_or(0));
    reader->rewind();
    for (;;) {
      const auto& item = reader->next();
      if (std::holds_alternative<std::monostate>(item)) break;
      if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
        REQUIRE(writer->checkpoint_encoded(checkpoint->image, checkpoint->root_hash));
        continue;
      }
      const auto& tick = std::get<replay::TickRecord>(item);
      REQUIRE(writer->begin_tick({tick.dt, tick.inputs}));
      REQUIRE(writer->end_tick_encoded(tick.root_hash, {}, std::nullopt, tick.cells));
    }
    for (replay::PeerRecord peer : reader->tail().peers) {
      change(peer);
      REQUIRE(writer->peer(peer));
    }
    REQUIRE(writer->finish(replay::EndReason::complete, ""));
    auto forged = replay::TraceReader::open(path);
    REQUIRE(forged);
    auto bundle = verifier::Bundle::read(*forged);
    if (!bundle) return bundle.error().message;
    return (**bundle).text(forged->setup().schema);
  };
  CHECK(!contains(forge(place("same.ttr"), [](replay::PeerRecord&) {}), "warning"));
  CHECK(contains(forge(place("value.ttr"), [](replay::PeerRecord& peer) { peer.tables[0].bytes[0] ^= 1; }),
                 "warning player 1: its rows have the hash "));
  CHECK(contains(forge(place("row.ttr"), [](replay::PeerRecord& peer) { peer.tables[0].removed.push_back(70'000); }),
                 "found a row behind the last one"));
  CHECK(contains(forge(place("game.ttr"),
                       [](replay::PeerRecord& peer) {
                         peer.tables.clear();
                         peer.has_state = false;
                         peer.session_identity ^= 1;
                       }),
                 "warning player 1 plays another game"));
  CHECK(contains(forge(place("cells.ttr"),
                       [](replay::PeerRecord& peer) {
                         peer.tables.clear();
                         peer.has_state = false;
                       }),
                 "player 1: its state is not known; by their hashes differ "));
}

TEST_CASE("a bundle that cannot be written is refused, and the session goes on", "[capi][peers][bundle]") {
  const TracePath place;
  MatchOptions options = flip_options(0, place);
  options.keeps = Keeps::recording;
  {
    MatchOptions clean = options;
    clean.fault = {};
    Match match(clean);
    ticktrue_session* session = match.players[0]->session();
    CHECK(ticktrue_bundle(session, place("none.ttr").c_str()) == TICKTRUE_REFUSED);
    CHECK(contains(ticktrue_message(session), "bundle: found no desync"));
    CHECK(ticktrue_status(session) == TICKTRUE_OK);
    CHECK(ticktrue_box_save(session, place("none.ttr").c_str()) == TICKTRUE_REFUSED);
    CHECK(contains(ticktrue_message(session), "box_save: found no black box"));
    REQUIRE(match.play());
    CHECK(ticktrue_finish(session) == 0);
    CHECK(!std::filesystem::exists(place("none.ttr")));
    CHECK(ticktrue_bundle(nullptr, "x.ttr") == TICKTRUE_OK);
    CHECK(ticktrue_box_save(nullptr, "x.ttr") == TICKTRUE_OK);
  }
  for (std::uint32_t p = 0; p < options.player_count; ++p)
    std::filesystem::remove(place("player_" + std::to_string(p) + ".ttr"));
  Match match(options);
  REQUIRE(match.play());
  ticktrue_session* session = match.players[0]->session();
  CHECK(ticktrue_bundle(session, nullptr) == TICKTRUE_REFUSED);
  CHECK(ticktrue_bundle(session, match.players[0]->path().c_str()) == TICKTRUE_REFUSED);
  CHECK(contains(ticktrue_message(session), "is the file that this session records"));
  CHECK(ticktrue_bundle(session, place("no/such/folder.ttr").c_str()) == TICKTRUE_REFUSED);
  std::ofstream(place("there.ttr")) << "x";
  CHECK(ticktrue_bundle(session, place("there.ttr").c_str()) == TICKTRUE_REFUSED);
  CHECK(place.bytes("there.ttr") == "x");
  CHECK(ticktrue_status(session) == TICKTRUE_OK);
  CHECK(ticktrue_bundle(session, place("good.ttr").c_str()) == TICKTRUE_OK);
  CHECK(std::string(ticktrue_message(session)).empty());
  CHECK(ticktrue_finish(session) == 1);
}

TEST_CASE("a bundle names what is not known: a state that is kept no more", "[capi][peers][bundle]") {
  std::size_t lost = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    CAPTURE(seed);
    const TracePath place;
    MatchOptions options = flip_options(seed, place);
    options.player_count = 2;
    options.fault.player = 1;
    options.fault.tick = 20;
    options.peer_bytes = 1;  // one state
    options.keeps = seed % 2 == 0 ? Keeps::recording : Keeps::memory;
    options.delay_max = 9;
    options.loss = 0.4;
    Match match(options);
    match.play(600);  // the report of a lost state never becomes whole
    REQUIRE(match.all_desync());
    ticktrue_session* session = match.players[0]->session();
    const std::string path = place("b.ttr");
    const int status = ticktrue_bundle(session, path.c_str());
    if (options.keeps == Keeps::memory) {
      CHECK(status == TICKTRUE_REFUSED);
      CHECK(contains(ticktrue_message(session), "bundle: found no tick before tick 20, which differs"));
      CHECK(contains(ticktrue_message(session), "raise peer_bytes in the options"));
      continue;
    }
    REQUIRE(status == TICKTRUE_OK);
    std::uint64_t first_tick = 0;
    std::size_t warnings = 0;
    const std::string text = text_of_bundle(path, first_tick, warnings);
    CAPTURE(text);
    CHECK(contains(text, "desync  live-game  tick 20\n"));
    CHECK(contains(text, "agreed  up to tick 19\n"));
    const bool is_lost = contains(match.players[0]->report(), "player 0: keeps the state of this tick no more");
    CHECK(contains(text, "player 0: keeps the state of this tick no more") == is_lost);
    CHECK(contains(text, "column  units.") != is_lost);
    lost += is_lost ? 1 : 0;
  }
  CHECK(lost > 0);
}

TEST_CASE("the black box of a running session is saved as a trace", "[capi][box][bundle]") {
  const TracePath place;
  MatchOptions options;
  options.folder = place("");
  options.keeps = Keeps::box;
  options.tick_count = 60;
  Match match(options);
  ticktrue_session* session = match.players[0]->session();
  CHECK(ticktrue_box_save(session, place("early.ttr").c_str()) == TICKTRUE_REFUSED);
  match.play(25);
  const std::uint64_t ticks = match.players[0]->confirmed();
  REQUIRE(ticks > 5);
  REQUIRE(ticks < options.tick_count);
  CHECK(ticktrue_box_save(session, place("early.ttr").c_str()) == TICKTRUE_OK);
  CHECK(ticktrue_box_save(session, place("early.ttr").c_str()) == TICKTRUE_REFUSED);  // exists
  CHECK(ticktrue_box_save(session, match.players[0]->path().c_str()) == TICKTRUE_REFUSED);
  REQUIRE(match.play());
  CHECK(ticktrue_box_save(session, place("late.ttr").c_str()) == TICKTRUE_OK);
  CHECK(ticktrue_finish(session) == 0);
  CHECK(contains(ticktrue_report(session), "the black box up to tick 59 is in " + place("late.ttr")));
  auto reader = replay::TraceReader::open(place("early.ttr"));
  REQUIRE(reader);
  while (!std::holds_alternative<std::monostate>(reader->next())) {
  }
  REQUIRE(reader->tail().end);
  CHECK(reader->tail().end->reason == replay::EndReason::complete);
  std::string report;
  CHECK(run_again(place("early.ttr"), PlantedFault(), true, report) == 0);
  CHECK(contains(report, "early.ttr  " + std::to_string(ticks) + " of " + std::to_string(ticks) + " ticks compared"));
  CHECK(run_again(place("late.ttr"), PlantedFault(), true, report) == 0);
  CHECK(contains(report, "late.ttr  60 of 60 ticks compared"));
}

TEST_CASE("the rows of a player give its tables again, with keys and without", "[capi][peers][bundle]") {
  std::mt19937 random(3);
  for (int round = 0; round < 400; ++round) {
    StateSchema schema;
    for (int t = 0; t < 3; ++t) {
      TableSchema table;
      table.name = "t" + std::to_string(t);
      table.row_size = 8;
      table.columns.resize(2);
      table.columns[0].name = "id";
      table.columns[0].type = ScalarType::u32;
      table.columns[1].name = "value";
      table.columns[1].type = ScalarType::u32;
      table.columns[1].offset = 4;
      table.key_column_count = static_cast<std::uint8_t>(t == 0 ? 0 : 1);
      schema.tables.push_back(table);
    }
    const auto make = [&] {
      std::vector<Bytes> rows(3);
      for (int t = 0; t < 3; ++t) {
        std::uint32_t id = 0;
        for (auto i = random() % 12; i > 0; --i) {
          id += static_cast<std::uint32_t>(1 + random() % 3);
          ByteWriter row;
          row.u32(id * (round % 2 == 0 ? 1 : 1000));
          row.u32(static_cast<std::uint32_t>(random() % 2));
          rows[static_cast<std::size_t>(t)].insert(rows[static_cast<std::size_t>(t)].end(), row.view().begin(),
                                                   row.view().end());
        }
      }
      return rows;
    };
    const std::vector<Bytes> one = make(), other = make();
    const auto tables = verifier::tables_of(schema, one), of_other = verifier::tables_of(schema, other);
    replay::PeerRecord peer;
    verifier::set_peer_rows(schema, tables, of_other, peer);
    const auto again = verifier::rows_of_peer(schema, tables, peer);
    REQUIRE(again);
    REQUIRE(*again == other);
    CHECK(!peer.is_cut);
    CHECK(verifier::root_of_tables(schema, verifier::tables_of(schema, *again)) ==
          verifier::root_of_tables(schema, of_other));
    replay::PeerRecord same;
    verifier::set_peer_rows(schema, tables, tables, same);
    CHECK(same.tables.empty());
  }
}

TEST_CASE("more rows than a bundle holds are cut, and that is told", "[capi][peers][bundle]") {
  StateSchema schema;
  TableSchema table;
  table.name = "t";
  table.row_size = 32;
  table.columns.resize(1);
  table.columns[0].name = "v";
  table.columns[0].type = ScalarType::u32;
  table.columns[0].lane_count = 8;
  schema.tables.push_back(table);
  const std::vector<Bytes> one{Bytes(32 * 40'000, 1)}, other{Bytes(32 * 40'000, 2)};
  replay::PeerRecord peer;
  verifier::set_peer_rows(schema, verifier::tables_of(schema, one), verifier::tables_of(schema, other), peer);
  CHECK(peer.is_cut);
  CHECK(peer.tables[0].bytes.size() == replay::peer_rows_size_max);
  CHECK(replay::check_peer(peer, "x"));
  const auto again = verifier::rows_of_peer(schema, verifier::tables_of(schema, one), peer);
  REQUIRE(again);
  CHECK((*again)[0].size() == other[0].size());
  CHECK((*again)[0].front() == 2);
  CHECK((*again)[0].back() == 1);
}
