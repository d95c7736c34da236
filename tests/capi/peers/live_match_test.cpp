// Live matches on a virtual clock: no alarm in clean ones, and every planted fault named alike on all sides.
// SPDX-License-Identifier: MIT
#include "tests/capi/peers/live_match.h"

#include <cstdio>
#include <string>

#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace {

using namespace ticktrue::test;

MatchOptions live_options(std::uint64_t seed) {
  MatchOptions options;
  options.seed = seed;
  options.player_count = 2 + static_cast<std::uint32_t>(seed % 3);
  options.rolls_back = seed / 3 % 2 == 1;
  options.loss = static_cast<double>(seed % 7) * 0.05;
  options.delay_max = 1 + static_cast<std::uint32_t>(seed % 9);
  return options;
}

int match_errors(const Match& match) {
  int count = 0;
  for (const auto& player : match.players) count += player->errors;
  return count;
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::string hex_digits(std::uint64_t bits, std::size_t digits) {
  char text[20];
  std::snprintf(text, sizeof text, "%0*llx", static_cast<int>(digits), static_cast<unsigned long long>(bits));
  return text;
}

void require_played(Match& match) {
  const bool is_played = match.play();
  std::string state = "after " + std::to_string(match.steps()) + " steps:";
  for (const auto& player : match.players) {
    bool is_complete = false;
    player->report(&is_complete);
    state += std::string(player->has_desync ? " desync" : " none") + (is_complete ? " whole" : " in parts") +
             " confirmed " + std::to_string(player->confirmed()) + ",";
  }
  CAPTURE(state, match.players[0]->report());
  REQUIRE(is_played);
  CHECK(match_errors(match) == 0);
}

/// The report that every player has names the first difference that the games themselves show.
void check_named(Match& match, const MatchOptions& options) {
  const std::uint32_t odd = options.fault.player, other = odd == 0 ? 1 : 0;
  Difference expected;
  const bool differs = match.first_difference_of(std::min(odd, other), std::max(odd, other), expected);
  REQUIRE(differs);
  const std::string text = match.players[0]->report();
  CAPTURE(text);
  CHECK(contains(text, "desync  live-game  tick " + std::to_string(expected.tick) + "\n"));
  CHECK(contains(text, "column  " + expected.column));
  CHECK(contains(text, "row " + std::to_string(expected.row)));
  CHECK(contains(text, ": " + hex_digits(expected.a, expected.digits) + " ("));
  CHECK(contains(text, ": " + hex_digits(expected.b, expected.digits) + " ("));
  if (expected.tick > 0) CHECK(contains(text, "agreed  up to tick " + std::to_string(expected.tick - 1) + "\n"));
  if (options.player_count > 2)
    CHECK(contains(text, "player " + std::to_string(odd) + " is the odd one out"));
  else
    CHECK(contains(text, "player 0, player 1 differ, and no majority says which is right"));
  const bool has_other_input = options.fault.kind == Fault::missing_input;
  CHECK(contains(text, "not the same for all: the tick ran with other inputs") == has_other_input);
  for (const auto& player : match.players) CHECK(player->report() == text);
}

}  // namespace

TEST_CASE("1,000 clean matches with loss and reordering raise no alarm", "[capi][peers][determinism]") {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Match match(live_options(seed));
    const bool is_done = match.play();
    if (!is_done || match.is_any_desync() || match_errors(match) != 0) {
      CAPTURE(seed, match.steps(), match_errors(match));
      CHECK(is_done);
      FAIL("an alarm, an error or a match without an end: " << match.players[0]->report());
    }
    for (const auto& player : match.players) {
      CHECK(player->messages == 0);
      CHECK(ticktrue_finish(player->session()) == 0);
      // Each other player, up to the last tick.
      CHECK(occurrences(ticktrue_report(player->session()), ", the same up to tick 39\n") == match.players.size() - 1);
    }
  }
}

TEST_CASE("25 flipped bits are named alike on all sides: tick, column, row and values", "[capi][peers][injection]") {
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    CAPTURE(seed);
    MatchOptions options = live_options(seed * 7 + 3);
    options.fault = {Fault::flip,
                     static_cast<std::uint32_t>(seed % options.player_count),
                     5 + seed,
                     static_cast<std::size_t>(seed),
                     static_cast<std::size_t>(seed * 5 + 1),
                     static_cast<unsigned>(seed * 3)};
    Match match(options);
    require_played(match);
    check_named(match, options);
    CHECK(contains(match.players[0]->report(), "tick " + std::to_string(5 + seed) + "\n"));
  }
}

TEST_CASE("25 faults of a program are named alike on all sides", "[capi][peers][injection]") {
  for (const Fault kind : {Fault::fused, Fault::unordered, Fault::missing_input, Fault::unsaved, Fault::clock})
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      CAPTURE(static_cast<int>(kind), seed);
      MatchOptions options = live_options(seed * 5 + 1);
      options.rolls_back = options.rolls_back || kind == Fault::unsaved;
      options.tick_count = 80;
      if (kind == Fault::unsaved) options.delay_max = 9;
      options.fault.kind = kind;
      options.fault.player = static_cast<std::uint32_t>((seed + 1) % options.player_count);
      options.fault.tick = 4 + 3 * seed;
      Match match(options);
      require_played(match);
      check_named(match, options);
    }
}
