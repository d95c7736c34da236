// One tick in full detail, as lines another build reads.
// SPDX-License-Identifier: MIT
#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"
#include "verifier/compare/stage_states.h"

namespace ticktrue::test {
namespace {

Result<verifier::StageStates> states_of(ByteView trace, const SimulationInfo& info, std::uint64_t tick) {
  replay::TraceReader reader = open_trace(trace);
  verifier::ReaderSource source(reader);
  return verifier::stage_states(source, info, tick);
}

TEST_CASE("stage_states: the states of a tick are those that a full trace stores", "[verifier][against][equivalence]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 100), 50, 8);
  const ReadTrace all = read_all(trace);
  for (const std::uint64_t tick : {0u, 7u, 8u, 23u, 49u}) {
    CAPTURE(tick);
    const auto states = states_of(trace, toy_info, tick);
    REQUIRE(states);
    CHECK(states->as_recorded);
    CHECK(states->start_tick == tick / 8 * 8);
    REQUIRE(states->states.size() == 4);  // before the tick, and after each of three stages
    CHECK(states->states[0].stage.empty());
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(states->states[i + 1].stage == ToySimulation::stages()[i]);
      CHECK(states->states[i + 1].root_hash == all.ticks[tick].stage_hashes[i]);
    }
    CHECK(states->states[3].image == *all.ticks[tick].image);
    if (tick > 0) CHECK(states->states[0].image == *all.ticks[tick - 1].image);
  }
  CHECK(!states_of(trace, toy_info, 50));
}

TEST_CASE("stage_states: an injected fault shows first after its stage", "[verifier][against][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 50, 8);
  injected = {37, ToySimulation::force_stage, [](ToySimulation& toy) { toy.bodies[1].velocity[1] += 1; }};
  const auto right = states_of(trace, toy_info, 37);
  const auto wrong = states_of(trace, faulty_info, 37);
  REQUIRE(right);
  REQUIRE(wrong);
  CHECK(right->states[0].image == wrong->states[0].image);
  CHECK(right->states[1].image == wrong->states[1].image);
  CHECK(right->states[2].image != wrong->states[2].image);
}

TEST_CASE("stage_states: lines are read back as they were, and others are refused", "[verifier][against][corruption]") {
  const auto states = states_of(toy_trace_with(toy_setup(6), 50, 8), toy_info, 20);
  REQUIRE(states);
  const std::string lines = verifier::stage_states_lines(*states);
  const auto again = verifier::parse_stage_states(lines);
  REQUIRE(again);
  CHECK(again->tick == 20);
  CHECK(again->start_tick == 16);
  REQUIRE(again->states.size() == states->states.size());
  for (std::size_t i = 0; i < states->states.size(); ++i) {
    CHECK(again->states[i].stage == states->states[i].stage);
    CHECK(again->states[i].root_hash == states->states[i].root_hash);
    CHECK(again->states[i].image == states->states[i].image);
  }
  for (std::size_t size = 0; size + 1 < lines.size(); size += 31) {
    CAPTURE(size);
    CHECK(!verifier::parse_stage_states(std::string_view(lines).substr(0, size)));
  }
  for (const char* wrong : {"", "\n", "{}", "[]", "null\n", "{\"schema\":\"ticktrue.stages/2\"}",
                            "{\"schema\":\"ticktrue.stages/1\",\"tick\":-1}"}) {
    CAPTURE(wrong);
    CHECK(!verifier::parse_stage_states(wrong));
  }
}

}  // namespace
}  // namespace ticktrue::test
