// Changed rules of a game, and flipped bits of a memory: no report names a pitfall for them.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "tests/pitfalls/pitfall.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "verifier/report/likely_causes.h"

namespace ticktrue::test {
namespace {

using pitfalls::Game;
using pitfalls::Machine;
using pitfalls::Unit;
using verifier::Report;

using Change = std::function<void(std::vector<Unit>& units, std::uint64_t tick)>;
const Change* change = nullptr;

/// Units bounce between walls, push each other, and score.
class Arena : public Game {
 public:
  Arena() : Game(8) {}

 private:
  void rules(float dt) override {
    for (Unit& unit : units) {
      unit.velocity -= 0.1F * unit.velocity * dt;
      if (unit.position < 0 || unit.position > 8) {
        unit.velocity = -0.9F * unit.velocity;
        unit.position = std::clamp(unit.position, 0.0F, 8.0F);
        unit.score += 3;
      }
    }
    for (std::size_t i = 1; i < units.size(); ++i)
      if (std::abs(units[i].position - units[i - 1].position) < 0.2F) units[i].velocity += 0.05F;
    if (pitfalls::machine == Machine::other) (*change)(units, tick());
  }
};

Report report_of(const Change& of, const Bytes& trace) {
  change = &of;
  pitfalls::machine = Machine::other;
  const SimulationInfo info{"arena", 1, pitfalls::make_game<Arena>};
  auto reader = replay::TraceReader::open_bytes(trace, "arena.ttr");
  REQUIRE(reader);
  verifier::VerifyOptions options;
  options.simulation = &info;
  return verifier::verify(*reader, options);
}

Bytes recorded() {
  pitfalls::machine = Machine::recorder;
  const auto simulation = pitfalls::make_game<Arena>({});
  replay::TraceSetup setup;
  setup.simulation = "arena";
  setup.physics_version = 1;
  setup.dt = 0.015625;
  setup.schema = *(*simulation)->state().schema;
  setup.detail = replay::Detail::full;
  setup.full_last = 239;
  setup.checkpoint_interval = 60;
  replay::NoInputs source(setup.dt);
  replay::RecordOptions options;
  options.tick_count = 240;
  options.writer = plain_writer();
  const TemporaryFolder folder;
  REQUIRE(replay::record(**simulation, source, folder.file("arena.ttr"), setup, {}, options));
  return read_file(folder.file("arena.ttr"));
}

/// Changes of a rule, intended or not.
const std::vector<Change> rules{
    [](auto& units, auto) { units[3].velocity *= 0.999F; },
    [](auto& units, auto tick) { units[0].score += tick == 30; },
    [](auto& units, auto) {
      for (Unit& unit : units) unit.velocity -= 0.001F;
    },
    [](auto& units, auto tick) {
      if (tick % 50 == 49) units[5].position = 4;
    },
    [](auto& units, auto) { units[7].score = std::max(units[7].score, 1); },
    [](auto& units, auto tick) {
      if (tick == 77) units[2].velocity = 0;
    },
    [](auto& units, auto) {
      for (Unit& unit : units) unit.velocity = std::clamp(unit.velocity, -1.5F, 1.5F);
    },
    [](auto& units, auto tick) { units[6].position += tick > 100 ? 0.01F : 0; },
    [](auto& units, auto) {
      for (Unit& unit : units) unit.score = unit.score / 2 * 2;
    },
    [](auto& units, auto tick) {
      if (tick == 12) units[1].velocity *= 2;
    },
    [](auto& units, auto tick) {
      if (tick == 40) units[4].score -= 10;
    },
    [](auto& units, auto) {
      for (Unit& unit : units)
        if (unit.position > 6.2F) unit.position = 6.2F;
    },
    [](auto& units, auto tick) {
      if (tick == 90) units[0].position = units[1].position;
    },
    [](auto& units, auto) {
      for (Unit& unit : units)
        if (unit.score > 2) unit.score = 2;
    },
    [](auto& units, auto tick) { units[3].score += static_cast<std::int32_t>(tick % 7 == 6); },
    [](auto& units, auto) { units[2].velocity += 1e-5F; },
    [](auto& units, auto tick) {
      if (tick == 150)
        for (Unit& unit : units) unit.velocity = -0.5F * unit.velocity;
    },
    [](auto& units, auto tick) {
      if (tick == 60) units[6].score *= 2, units[6].score += 1;
    },
    [](auto& units, auto) {
      for (Unit& unit : units) unit.position = std::max(unit.position, 0.05F);
    },
    [](auto& units, auto tick) {
      if (tick == 33) units[5].velocity += 0.25F, units[5].score = 9;
    },
};

TEST_CASE("of forty other changes at most two get a cause", "[verifier][pitfalls][causes]") {
  const Bytes trace = recorded();
  std::vector<std::string> named;
  std::size_t red_count = 0;
  const auto judge = [&](const Change& of) {
    const Report report = report_of(of, trace);
    if (!report.divergence) return;
    ++red_count;
    if (!verifier::likely_causes(report).empty()) named.push_back(verifier::report_text(report));
  };
  for (const Change& of : rules) judge(of);
  std::mt19937 random(20261125);
  for (int i = 0; i < 20; ++i) {
    const std::uint64_t tick = random() % 200;
    const auto unit = static_cast<std::uint32_t>(random() % 8), column = static_cast<std::uint32_t>(random() % 3),
               bit = static_cast<std::uint32_t>(random() % 32);
    judge([=](std::vector<Unit>& units, std::uint64_t now) {
      if (now != tick) return;
      const auto flip = [bit](auto& value) {
        value = __builtin_bit_cast(std::decay_t<decltype(value)>, __builtin_bit_cast(std::uint32_t, value) ^ 1U << bit);
      };
      if (column == 0) flip(units[unit].position);
      if (column == 1) flip(units[unit].velocity);
      if (column == 2) flip(units[unit].score);
    });
  }
  CAPTURE(named);
  CHECK(red_count == 40);
  CHECK(named.size() <= 2);
}

}  // namespace
}  // namespace ticktrue::test
