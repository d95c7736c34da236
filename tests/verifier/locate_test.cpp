// Exactness of what a report names: every column and lane of the toy state.
// SPDX-License-Identifier: MIT
#include "verifier/locate/locate.h"

#include <cstring>

#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"
#include "verifier/locate/compare_tick.h"

namespace ticktrue::test {
namespace {

using verifier::Divergence;
using verifier::Report;
using verifier::Verdict;

struct Cell {
  std::size_t table, row, column, lane, offset, size;
};

/// Every lane of the given rows of the toy.
std::vector<Cell> cells(std::size_t row_of_bodies, std::size_t row_of_links) {
  std::vector<Cell> all;
  const StateSchema& schema = ToySimulation::schema();
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    for (std::size_t c = 0; c < schema.tables[t].columns.size(); ++c)
      for (std::size_t lane = 0; lane < schema.tables[t].columns[c].lane_count; ++lane) {
        const Column& column = schema.tables[t].columns[c];
        const std::size_t size = scalar_info(column.type)->size;
        all.push_back({t,
                       t == 1   ? row_of_bodies
                       : t == 2 ? row_of_links
                                : 0,
                       c, lane, column.offset + lane * size, size});
      }
  return all;
}

/// Flips the lowest bit of a lane in the toy's own rows.
void flip(ToySimulation& toy, const Cell& cell) {
  std::uint8_t* row = nullptr;
  if (cell.table == 0) row = reinterpret_cast<std::uint8_t*>(&toy.world);
  if (cell.table == 1) row = reinterpret_cast<std::uint8_t*>(&toy.bodies[cell.row]);
  if (cell.table == 2) row = reinterpret_cast<std::uint8_t*>(&toy.links[cell.row]);
  row[cell.offset + (machine_is_little_endian ? 0 : cell.size - 1)] ^= 1;
}

TEST_CASE("each column and lane of the state changes the root hash", "[verifier][locate][analytic]") {
  for (const Cell& cell : cells(2, 1)) {
    ToySimulation toy(6);
    const std::uint64_t before = root_hash(toy.state());
    flip(toy, cell);
    CAPTURE(cell.table, cell.column, cell.lane);
    CHECK(root_hash(toy.state()) != before);
    flip(toy, cell);
    CHECK(root_hash(toy.state()) == before);
  }
}

TEST_CASE("locate: a fault in any column and lane is named exactly, with its stage", "[verifier][locate][analytic]") {
  const TemporaryFolder folder;
  ToySimulation simulation(6);
  replay::NoInputs source(0.015625);
  replay::RecordOptions options;
  options.tick_count = 12;
  options.writer = plain_writer();
  REQUIRE(replay::record(simulation, source, folder.file("toy.ttr"), full_toy_setup(6, 0, 100), toy_facts, options));
  const Bytes trace = read_file(folder.file("toy.ttr"));
  const StateSchema& schema = ToySimulation::schema();
  for (const Cell& cell : cells(2, 1)) {
    const TableSchema& table = schema.tables[cell.table];
    CAPTURE(table.name, table.columns[cell.column].name, cell.lane);
    injected = {7, ToySimulation::move_stage, [&](ToySimulation& toy) {
                  // tick_count also says when the fault is due: once only.
                  flip(toy, cell);
                }};
    const Report report = verify_bytes(trace, faulty_info);
    REQUIRE(report.verdict == Verdict::diverged);
    const Divergence& divergence = *report.divergence;
    CHECK(divergence.tick == 7);
    CHECK(divergence.stage == "move");
    REQUIRE(divergence.tables.size() == 1);
    CHECK(divergence.tables[0].table == table.name);
    CHECK(divergence.tables[0].columns == std::vector<std::string>{table.columns[cell.column].name});
    REQUIRE(divergence.rows.size() == 1);
    CHECK(divergence.lane_count == 1);
    CHECK(divergence.rows[0].row == cell.row);
    CHECK(divergence.rows[0].lane == cell.lane);
    REQUIRE(divergence.rows[0].expected);
    REQUIRE(divergence.rows[0].got);
    CHECK((*divergence.rows[0].expected ^ *divergence.rows[0].got) == 1);
  }
}

TEST_CASE("locate: a row only one side has is named by its id", "[verifier][locate][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 100), 12, 0);
  injected = {4, ToySimulation::move_stage, [](ToySimulation& toy) { toy.bodies.erase(toy.bodies.begin() + 4); }};
  Report report = verify_bytes(trace, faulty_info);
  REQUIRE(report.divergence);
  REQUIRE(report.divergence->rows.size() == 1);
  CHECK(report.divergence->rows[0].column == "id");
  CHECK(report.divergence->rows[0].id == 4u);
  CHECK(report.divergence->rows[0].expected == 4u);
  CHECK(!report.divergence->rows[0].got);

  injected = {4, ToySimulation::move_stage, [](ToySimulation& toy) {
                ToyBody body;
                body.id = 77;
                toy.bodies.push_back(body);
                toy.bodies[5].hits += 1;
              }};
  report = verify_bytes(trace, faulty_info);
  REQUIRE(report.divergence);
  REQUIRE(report.divergence->rows.size() == 2);
  CHECK(report.divergence->rows[0].name == "toy_5");
  CHECK(report.divergence->rows[1].id == 77u);
  CHECK(!report.divergence->rows[1].expected);
  CHECK(report.divergence->rows[1].name == "toy_77");
}

TEST_CASE("locate: behind a row that is missing here, rows keep their names", "[verifier][locate][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 100), 12, 0);
  injected = {4, ToySimulation::move_stage, [](ToySimulation& toy) {
                toy.bodies.erase(toy.bodies.begin() + 1);
                toy.bodies[3].charge += 1;
              }};
  const Report report = verify_bytes(trace, faulty_info);
  REQUIRE(report.divergence);
  REQUIRE(report.divergence->rows.size() == 2);
  CHECK(report.divergence->rows[0].id == 1u);
  CHECK(report.divergence->rows[1].column == "charge");
  CHECK(report.divergence->rows[1].id == 4u);
  CHECK(report.divergence->rows[1].row == 4);
  CHECK(report.divergence->rows[1].name == "toy_4");
}

TEST_CASE("locate: more lanes than a report lists are counted", "[verifier][locate][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(100, 0, 100), 4, 0);
  injected = {1, ToySimulation::move_stage, [](ToySimulation& toy) {
                for (ToyBody& body : toy.bodies) body.charge += 1;
              }};
  const Report report = verify_bytes(trace, faulty_info);
  REQUIRE(report.divergence);
  CHECK(report.divergence->rows.size() == 64);
  CHECK(report.divergence->lane_count == 100);
}

TEST_CASE("locate: the first stage whose hash differs is named", "[verifier][locate][analytic]") {
  const std::vector<std::string> stages{"a", "b", "c"};
  const std::vector<std::uint64_t> recorded{1, 2, 3};
  const auto stage = [&](std::vector<std::uint64_t> got) {
    Divergence divergence;
    verifier::locate_stage(stages, recorded, got, divergence);
    return divergence;
  };
  CHECK(stage({9, 9, 9}).stage == "a");
  CHECK(stage({1, 9, 3}).stage == "b");
  CHECK(stage({1, 2, 9}).stage == "c");
  CHECK(stage({1, 2}).stage == "c");
  CHECK(contains(stage({1, 2, 9}).stage_note, "b and before agree"));
  CHECK(!stage({1, 2, 3}).stage);
  CHECK(contains(stage({1, 2, 3}).stage_note, "after the last one"));
}

TEST_CASE("locate: between two states, the first is the expected one", "[verifier][locate][analytic]") {
  ToySimulation first(6), second(6);
  second.bodies[2].charge += 5;
  second.refresh();
  const Divergence found = verifier::between_states(first.state(), second.state(), {}, 64);
  CHECK(found.expected_root == root_hash(first.state()));
  CHECK(found.got_root == root_hash(second.state()));
  REQUIRE(found.expected_root != found.got_root);
  REQUIRE(found.rows.size() == 1);
  REQUIRE(found.rows[0].expected);
  REQUIRE(found.rows[0].got);
  CHECK(*found.rows[0].expected == static_cast<std::uint32_t>(first.bodies[2].charge));
  CHECK(*found.rows[0].got == static_cast<std::uint32_t>(second.bodies[2].charge));
}

TEST_CASE("compare: a state given as itself, as tables or as an image is compared with each other form",
          "[verifier][locate][analytic]") {
  ToySimulation first(6), second(6);
  second.bodies[2].charge += 5;
  Bytes images[2], buffers[2];
  std::vector<ImageTable> tables[2];
  const std::vector<std::uint32_t> all{0, 1, 2};
  std::vector<verifier::TickSide> forms[2];  // [state][form]
  const ToySimulation* const states[] = {&first, &second};
  for (std::size_t i = 0; i < 2; ++i) {
    encode_image(states[i]->state(), images[i]);
    tables[i] = canonical_tables(states[i]->state(), buffers[i]);
    forms[i].resize(3);
    forms[i][0].state = &states[i]->state();
    forms[i][1].tables = replay::StoredState{tables[i], all};
    forms[i][2].image = ByteView(images[i]);
  }
  verifier::TickComparer comparer(ToySimulation::schema());
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      CAPTURE(a, b);
      const verifier::TickSide same[] = {forms[0][a], forms[0][b]};
      CHECK_FALSE(comparer.compare(same));
      if (a == 0 && b == 0) continue;  // nobody stores them: the root hashes have told
      const verifier::TickSide other[] = {forms[0][a], forms[1][b]};
      const auto found = comparer.compare(other);
      REQUIRE(found);
      CHECK(found->part == verifier::TickPart::image);
      CHECK(found->a == 0);
      CHECK(found->b == 1);
    }
}

}  // namespace
}  // namespace ticktrue::test
