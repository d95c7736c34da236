// A match of several players in one process: games, sessions, and a network with a virtual clock, loss and reordering.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "include/ticktrue.h"

namespace ticktrue::test {

inline constexpr std::size_t unit_count = 6;
inline constexpr std::size_t match_player_max = 4;

/// The mistake of one side.
enum class Fault { none, flip, fused, unordered, missing_input, unsaved, clock };

struct PlantedFault {
  Fault kind = Fault::none;
  std::uint32_t player = 0;
  std::uint64_t tick = 0;
  std::size_t column = 0;  // of a flip
  std::size_t row = 0;
  unsigned bit = 0;
};

struct Unit {
  float place[2] = {0, 0};
  float speed[2] = {0, 0};
  std::int32_t hits = 0;
  std::uint32_t cooldown = 0;
};

/// A game with few rules and many floats.
struct LiveGame {
  std::array<Unit, unit_count> units{};
  std::uint64_t random = 1;
  float centre = 0;
  std::uint64_t tick = 0;

  explicit LiveGame(std::uint64_t seed = 1) : random(seed * 2 + 1) {
    for (std::size_t i = 0; i < unit_count; ++i) {
      units[i].place[0] = static_cast<float>(next() % 1000) / 37.0f;
      units[i].place[1] = static_cast<float>(next() % 1000) / 41.0f;
    }
  }
  std::uint64_t next() {
    random = random * 6364136223846793005ull + 1442695040888963407ull;
    return random >> 33;
  }
  void step(const std::array<std::uint8_t, match_player_max>& inputs, const PlantedFault& fault) {
    const bool is_now = tick >= fault.tick;
    centre = 0;
    for (std::size_t i = 0; i < unit_count; ++i)
      centre += units[is_now && fault.kind == Fault::unordered ? unit_count - 1 - i : i].place[0];
    for (std::size_t i = 0; i < unit_count; ++i) {
      Unit& unit = units[i];
      const std::uint8_t input = inputs[i % match_player_max];
      for (int lane = 0; lane < 2; ++lane) {
        unit.speed[lane] += static_cast<float>(((input >> (2 * lane)) & 3) - 1) * 0.1f - 0.001f * centre;
        if (is_now && fault.kind == Fault::fused)
          unit.place[lane] = std::fma(unit.speed[lane], 0.016666f, unit.place[lane]);
        else
          unit.place[lane] += unit.speed[lane] * 0.016666f;
      }
      if (unit.cooldown > 0) --unit.cooldown;
      if ((input & 16) != 0 && unit.cooldown == 0) {
        unit.cooldown = 7;
        unit.hits += static_cast<std::int32_t>(1 + next() % 3);
      }
    }
    ++tick;
  }
  /// Flips one bit of a value after the tick has run.
  void flip(const PlantedFault& fault) {
    Unit& unit = units[fault.row % unit_count];
    const std::uint32_t bit = std::uint32_t{1} << (fault.bit % 23);  // of a float: of its mantissa, it stays finite
    const auto turn = [bit](auto& value) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, &value, sizeof bits);
      bits ^= bit;
      std::memcpy(&value, &bits, sizeof bits);
    };
    switch (fault.column % 6) {
      case 0:
        return turn(unit.place[0]);
      case 1:
        return turn(unit.place[1]);
      case 2:
        return turn(unit.speed[0]);
      case 3:
        return turn(unit.speed[1]);
      case 4:
        return turn(unit.hits);
      default:
        return turn(unit.cooldown);
    }
  }
  void show(ticktrue_session* session) {
    const ticktrue_member members[] = {
        TICKTRUE_MEMBER(Unit, place, TICKTRUE_F32), TICKTRUE_MEMBER(Unit, speed, TICKTRUE_F32),
        TICKTRUE_MEMBER(Unit, hits, TICKTRUE_I32), TICKTRUE_MEMBER(Unit, cooldown, TICKTRUE_U32)};
    ticktrue_column(session, "world", "random", &random, TICKTRUE_U64, 1, 1, 0);
    ticktrue_rows(session, ticktrue_table(session, "units", sizeof(Unit), members, 4), units.data(), unit_count);
  }
};

/// A place and the values of both sides, found by comparing the games themselves.
struct Difference {
  std::uint64_t tick = 0;
  std::string column;
  std::size_t row = 0;
  std::uint64_t a = 0;  // bits
  std::uint64_t b = 0;
  std::size_t digits = 8;  // in hexadecimal
};
inline bool first_difference(const LiveGame& a, const LiveGame& b, Difference& found) {
  const auto differs = [&](const char* column, std::size_t row, const auto& one, const auto& other) {
    if (std::memcmp(&one, &other, sizeof one) == 0) return false;
    found.column = column;
    found.row = row;
    found.digits = 2 * sizeof one;
    found.a = found.b = 0;
    std::memcpy(&found.a, &one, sizeof one);
    std::memcpy(&found.b, &other, sizeof other);
    return true;
  };
  if (differs("world.random", 0, a.random, b.random)) return true;
  for (std::size_t i = 0; i < unit_count; ++i) {
    const Unit &one = a.units[i], &other = b.units[i];
    if (differs("units.place", i, one.place[0], other.place[0]) ||
        differs("units.place", i, one.place[1], other.place[1]) ||
        differs("units.speed", i, one.speed[0], other.speed[0]) ||
        differs("units.speed", i, one.speed[1], other.speed[1]) || differs("units.hits", i, one.hits, other.hits) ||
        differs("units.cooldown", i, one.cooldown, other.cooldown))
      return true;
  }
  return false;
}

/// What a player's session does beside the match.
enum class Keeps { memory, recording, box };

struct MatchOptions {
  std::uint32_t player_count = 2;
  std::uint64_t tick_count = 40;
  std::uint64_t seed = 1;
  bool rolls_back = false;
  double loss = 0.1;
  std::uint32_t delay_max = 4;  // steps of the clock that a packet takes at most
  std::size_t packet_size = 1200;
  std::size_t peer_bytes = 0;
  PlantedFault fault;
  Keeps keeps = Keeps::memory;
  std::string folder;  // of recordings
  bool has_other_builds = false;
  bool has_saves = true;
  std::uint32_t checkpoint_interval = 10;
};

inline std::size_t save_game(void* user, void* buffer, std::size_t size) {
  if (size >= sizeof(LiveGame)) std::memcpy(buffer, user, sizeof(LiveGame));
  return sizeof(LiveGame);
}
inline int load_game(void* user, const void* bytes, std::size_t size) {
  if (size != sizeof(LiveGame)) return 1;
  std::memcpy(user, bytes, size);
  return 0;
}

/// One player of the match.
class MatchPlayer {
 public:
  MatchPlayer(const MatchOptions& options, std::uint32_t number)
      : options_(options), number_(number), game_(options.seed), inputs_(options.player_count) {
    if (options.fault.player == number) fault_ = options.fault;
    ticktrue_options session = {};
    session.struct_size = sizeof session;
    session.mode = TICKTRUE_LIVE;
    session.name = "live-game";
    session.version = 1;
    session.flags = TICKTRUE_QUIET;
    session.setup = &options_.seed;
    session.setup_size = sizeof options_.seed;
    session.rollback_max = options.rolls_back ? 64 : 0;
    session.peer_bytes = options.peer_bytes;
    session.player = number;
    if (options.has_other_builds) session.caller_facts = number % 2 == 0 ? "optimize=speed" : "optimize=no";
    path_ = options.folder + "/player_" + std::to_string(number) + ".ttr";
    if (options.keeps != Keeps::memory) {
      session.mode = TICKTRUE_RECORD;
      session.path = path_.c_str();
      session.checkpoint_interval = options.checkpoint_interval;
      session.box_kib = options.keeps == Keeps::box ? 256 : 0;
      session.flags |= TICKTRUE_NO_SYNC;
    }
    if (options.keeps != Keeps::memory && options.has_saves) {
      session.save = save_game;
      session.load = load_game;
      session.user = &game_;
    }
    session_ = ticktrue_open(&session);
    game_.show(session_);
    for (auto& inputs : inputs_) inputs.assign(delay, 0);  // the first ticks run without
    histories_.push_back(game_);
  }
  MatchPlayer(const MatchPlayer&) = delete;
  ~MatchPlayer() { ticktrue_close(session_); }

  static std::uint8_t input_of(std::uint64_t seed, std::uint32_t player, std::uint64_t tick) {
    return static_cast<std::uint8_t>((seed * 31 + player * 7 + tick / 3 + 1) * 2654435761u >> 24);
  }

  /// The bytes for another player: own inputs, roots, and messages about a desync.
  std::vector<std::uint8_t> packet(std::uint32_t to) {
    std::vector<std::uint8_t> bytes;
    const auto put = [&bytes](std::uint64_t value) {
      for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    };
    std::vector<std::uint8_t>& own = inputs_[number_];
    while (own.size() < game_.tick + delay) own.push_back(input_of(options_.seed, number_, own.size()));
    const std::size_t first = own.size() > 40 ? own.size() - 40 : 0;
    put(first);
    put(own.size() - first);
    bytes.insert(bytes.end(), own.begin() + static_cast<std::ptrdiff_t>(first), own.end());
    const std::uint64_t done = confirmed_;
    const std::uint64_t from = done > 8 ? done - 8 : 0;
    put(from);
    put(done - from);
    for (std::uint64_t tick = from; tick < done; ++tick) {
      std::uint64_t root = 0;
      if (ticktrue_root(session_, tick, &root) != TICKTRUE_OK) ++errors;
      put(root);
    }
    std::vector<std::uint8_t> message(options_.packet_size);
    message.resize(ticktrue_desync_message(session_, to, message.data(), message.size()));
    if (!message.empty()) ++messages;
    bytes.insert(bytes.end(), message.begin(), message.end());
    return bytes;
  }

  void take(std::uint32_t from, const std::vector<std::uint8_t>& bytes) {
    std::size_t at = 0;
    const auto get = [&] {
      std::uint64_t value = 0;
      for (int i = 0; i < 8; ++i) value |= std::uint64_t{bytes[at++]} << (8 * i);
      return value;
    };
    std::uint64_t first = get();
    std::uint64_t count = get();
    for (; count > 0; --count, ++first, ++at)
      if (inputs_[from].size() == first) inputs_[from].push_back(bytes[at]);
    std::uint64_t tick = get();
    for (std::uint64_t left = get(); left > 0; --left, ++tick) note(ticktrue_peer_root(session_, from, tick, get()));
    if (at < bytes.size()) note(ticktrue_desync_receive(session_, from, bytes.data() + at, bytes.size() - at));
  }

  /// Runs every tick whose inputs are known or guessed.
  void advance() {
    if (options_.rolls_back) roll_back();
    while (game_.tick < options_.tick_count && can_run()) run();
    if (!options_.rolls_back) confirmed_ = game_.tick;
  }

  bool is_done() const { return confirmed_ == options_.tick_count; }
  std::string report(bool* is_complete = nullptr) {
    int complete = 0;
    std::string text = ticktrue_desync_report(session_, &complete);
    if (is_complete != nullptr) *is_complete = complete != 0;
    return text;
  }
  ticktrue_session* session() { return session_; }
  const std::string& path() const { return path_; }
  /// The game after so many ticks, final.
  const LiveGame& history(std::uint64_t ticks) const { return histories_[static_cast<std::size_t>(ticks)]; }
  std::uint64_t confirmed() const { return confirmed_; }

  bool has_desync = false;
  int errors = 0;
  int messages = 0;

 private:
  static constexpr std::uint64_t delay = 3;       // ticks from an input to its effect
  static constexpr std::uint64_t ahead_max = 12;  // ticks that run on guesses

  void note(int status) {
    if (status == TICKTRUE_DIVERGED)
      has_desync = true;
    else if (status != TICKTRUE_OK)
      ++errors;
  }
  std::uint64_t known() const {
    std::size_t known = inputs_[0].size();
    for (const auto& inputs : inputs_) known = std::min(known, inputs.size());
    return known;
  }
  bool can_run() const { return options_.rolls_back ? game_.tick < known() + ahead_max : game_.tick < known(); }

  std::array<std::uint8_t, match_player_max> inputs_at(std::uint64_t tick) const {
    std::array<std::uint8_t, match_player_max> inputs{};
    for (std::size_t p = 0; p < inputs_.size(); ++p) {
      const auto& known = inputs_[p];
      inputs[p] = tick < known.size() ? known[static_cast<std::size_t>(tick)] : known.empty() ? 0 : known.back();
    }
    if (fault_.kind == Fault::missing_input && tick == fault_.tick) inputs[(number_ + 1) % inputs_.size()] ^= 0x11;
    return inputs;
  }

  void run() {
    const auto inputs = inputs_at(game_.tick);
    auto given = inputs;
    if (options_.rolls_back) saved_[game_.tick] = {game_, inputs};
    ticktrue_input(session_, given.data(), given.size());
    if (ticktrue_begin_tick(session_, nullptr) != TICKTRUE_OK) ++errors;
    const std::uint64_t tick = game_.tick;
    game_.step(inputs, fault_);
    if (fault_.kind == Fault::flip && tick == fault_.tick) game_.flip(fault_);
    if (fault_.kind == Fault::clock && tick >= fault_.tick)
      game_.units[2].speed[1] += 1e-3f * static_cast<float>(++clock_);
    if (ticktrue_end_tick(session_) != TICKTRUE_OK) ++errors;
    if (!options_.rolls_back) histories_.push_back(game_);
  }

  /// Ticks that ran on wrong guesses run again; then those whose inputs are all known are final.
  void roll_back() {
    const std::uint64_t now = game_.tick, final = std::min<std::uint64_t>(known(), now);
    std::uint64_t wrong = confirmed_;
    while (wrong < final && saved_[wrong].second == inputs_at(wrong)) ++wrong;
    if (wrong < final) {
      const std::uint32_t cooldown = game_.units[1].cooldown;
      game_ = saved_[wrong].first;
      if (fault_.kind == Fault::unsaved && wrong >= fault_.tick) game_.units[1].cooldown = cooldown;
      if (ticktrue_rewind(session_, wrong) != TICKTRUE_OK) ++errors;
      while (game_.tick < now) run();
    }
    saved_[game_.tick].first = game_;
    for (std::uint64_t tick = confirmed_; tick < final; ++tick) histories_.push_back(saved_[tick + 1].first);
    saved_.erase(saved_.begin(), saved_.lower_bound(final));
    confirmed_ = final;
    if (ticktrue_confirm(session_, final) != TICKTRUE_OK) ++errors;
  }

  MatchOptions options_;
  std::uint32_t number_;
  std::string path_;
  LiveGame game_;
  PlantedFault fault_;
  ticktrue_session* session_ = nullptr;
  std::vector<std::vector<std::uint8_t>> inputs_;  // [player][tick]
  std::map<std::uint64_t, std::pair<LiveGame, std::array<std::uint8_t, match_player_max>>> saved_;
  std::vector<LiveGame> histories_;
  std::uint64_t confirmed_ = 0;
  unsigned clock_ = 0;
};

/// Moves the virtual clock until the match has ended.
class Match {
 public:
  explicit Match(const MatchOptions& options) : options_(options), random_(static_cast<std::uint32_t>(options.seed)) {
    for (std::uint32_t p = 0; p < options.player_count; ++p)
      players.push_back(std::make_unique<MatchPlayer>(options, p));
    exchange_hellos();
  }

  /// True: all ticks are confirmed, and every player that sees a desync has its whole report.
  bool play(std::uint64_t step_max = 2000) {
    for (now_ = 0; now_ < step_max; ++now_) {
      deliver();
      bool is_done = true;
      for (std::uint32_t from = 0; from < players.size(); ++from) {
        players[from]->advance();
        for (std::uint32_t to = 0; to < players.size(); ++to)
          if (to != from) send(from, to);
        bool is_complete = true;
        if (players[from]->has_desync) players[from]->report(&is_complete);
        is_done = is_done && is_complete && players[from]->is_done();
      }
      if (is_done && !is_any_desync() && now_ > quiet_steps_) return true;
      if (is_done && is_any_desync() && all_desync()) return true;
      if (!is_done) quiet_steps_ = now_ + quiet_step_count;
    }
    return false;
  }
  std::uint64_t steps() const { return now_; }
  bool is_any_desync() const {
    return std::any_of(players.begin(), players.end(), [](const auto& player) { return player->has_desync; });
  }
  bool all_desync() const {
    return std::all_of(players.begin(), players.end(), [](const auto& player) { return player->has_desync; });
  }

  /// The first tick whose final states differ between two players.
  bool first_difference_of(std::uint32_t a, std::uint32_t b, Difference& found) const {
    const std::uint64_t ticks = std::min(players[a]->confirmed(), players[b]->confirmed());
    for (found.tick = 0; found.tick < ticks; ++found.tick)
      if (first_difference(players[a]->history(found.tick + 1), players[b]->history(found.tick + 1), found))
        return true;
    return false;
  }

  std::vector<std::unique_ptr<MatchPlayer>> players;

 private:
  void exchange_hellos() {
    for (std::uint32_t a = 0; a < players.size(); ++a)
      for (std::uint32_t b = 0; b < players.size(); ++b) {
        if (a == b) continue;
        std::vector<std::uint8_t> bytes(ticktrue_hello(players[a]->session(), nullptr, 0));
        ticktrue_hello(players[a]->session(), bytes.data(), bytes.size());
        if (ticktrue_hello_check(players[b]->session(), a, bytes.data(), bytes.size(), nullptr, 0) != TICKTRUE_OK)
          ++players[b]->errors;
      }
  }
  double chance() { return static_cast<double>(random_() % 10000) / 10000; }
  void send(std::uint32_t from, std::uint32_t to) {
    const auto bytes = players[from]->packet(to);
    const int copies = chance() < options_.loss ? 0 : chance() < 0.05 ? 2 : 1;
    for (int i = 0; i < copies; ++i)
      flying_.emplace(std::make_tuple(now_ + 1 + random_() % options_.delay_max, sent_++), Packet{from, to, bytes});
  }
  void deliver() {
    while (!flying_.empty() && std::get<0>(flying_.begin()->first) <= now_) {
      const Packet& packet = flying_.begin()->second;
      players[packet.to]->take(packet.from, packet.bytes);
      flying_.erase(flying_.begin());
    }
  }

  struct Packet {
    std::uint32_t from = 0, to = 0;
    std::vector<std::uint8_t> bytes;
  };
  static constexpr std::uint64_t quiet_step_count = 40;  // for the last roots to arrive, in spite of loss
  MatchOptions options_;
  std::mt19937 random_;
  std::uint64_t now_ = 0;
  std::uint64_t sent_ = 0;
  std::uint64_t quiet_steps_ = 0;
  std::map<std::tuple<std::uint64_t, std::uint64_t>, Packet> flying_;
};

}  // namespace ticktrue::test
