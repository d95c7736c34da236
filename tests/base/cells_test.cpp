// Cells: differing columns and owners are found, and the numbers equal those in the documents.
// SPDX-License-Identifier: MIT
#include "base/state/cells.h"

#include <set>

#include "tests/support/catch.h"
#include "tests/support/toy_simulation.h"

namespace ticktrue::test {
namespace {

StateCells cells(const StateView& state) {
  StateCells out;
  CellHasher(*state.schema).hash(state, 0, out);
  return out;
}

/// The columns (of all tables, in schema order) whose hashes differ.
std::set<std::size_t> differing_columns(const StateCells& a, const StateCells& b) {
  std::set<std::size_t> found;
  for (std::size_t c = 0; c < a.columns.size(); ++c)
    if (a.columns[c] != b.columns[c]) found.insert(c);
  return found;
}

/// Keys of owners in the bodies table whose cells all differ.
std::set<std::uint64_t> differing_bodies(const StateView& state, const StateCells& a, const StateCells& b) {
  std::set<std::uint64_t> found;
  CellHasher hasher(*state.schema);
  for (const CellOwner& owner : hasher.owners(state)) {
    const auto at = cells_of(owner, a.partition_cells);
    bool all = true;
    for (std::size_t p = 0; p < partition_count; ++p)
      all = all && a.cells[p * a.partition_cells + at[p]] != b.cells[p * a.partition_cells + at[p]];
    if (all && owner.table == 1) found.insert(owner.key);
  }
  return found;
}

TEST_CASE("cells: every bit of every lane changes the hash of its column and of no other",
          "[base][cells][equivalence]") {
  const std::uint32_t row_count = 7;  // an odd number, so that the last row has no partner
  ToySimulation toy(row_count);
  const StateCells before = cells(toy.state());
  const StateSchema& schema = *toy.state().schema;
  std::size_t column_index = 0;
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    for (const Column& column : schema.tables[t].columns) {
      const std::size_t size = scalar_info(column.type)->size * column.lane_count;
      for (std::size_t row = 0; row < toy.state().tables[t].row_count; ++row)
        for (std::size_t bit = 0; bit < 8 * size; ++bit) {
          auto* byte = const_cast<std::uint8_t*>(toy.state().tables[t].data) + row * schema.tables[t].row_size +
                       column.offset + bit / 8;
          *byte = static_cast<std::uint8_t>(*byte ^ (1u << (bit % 8)));
          CAPTURE(column.name, row, bit);
          CHECK(differing_columns(before, cells(toy.state())) == std::set<std::size_t>{column_index});
          *byte = static_cast<std::uint8_t>(*byte ^ (1u << (bit % 8)));
        }
      ++column_index;
    }
}

TEST_CASE("cells: signs that flip in two rows do not cancel", "[base][cells][regression]") {
  ToySimulation toy(9);
  for (std::size_t i = 0; i < 9; ++i) toy.bodies[i].velocity[0] = toy.bodies[i].velocity[1] = 0.0F;
  const StateCells before = cells(toy.state());
  for (std::size_t a = 0; a < 9; ++a)
    for (std::size_t b = 0; b < 9; ++b) {
      if (a == b) continue;
      toy.bodies[a].velocity[0] = toy.bodies[b].velocity[1] = -0.0F;
      const StateCells after = cells(toy.state());
      CAPTURE(a, b);
      CHECK(differing_columns(before, after).size() == 1);
      const auto found = differing_bodies(toy.state(), before, after);
      CHECK(found.count(a) == 1);
      CHECK(found.count(b) == 1);
      toy.bodies[a].velocity[0] = toy.bodies[b].velocity[1] = 0.0F;
    }
}

TEST_CASE("cells: a changed row points to the bodies it refers to", "[base][cells][analytic]") {
  ToySimulation toy(40);
  const StateCells before = cells(toy.state());
  toy.links[3].stiffness += 1;
  CHECK(differing_bodies(toy.state(), before, cells(toy.state())) ==
        std::set<std::uint64_t>{toy.links[3].body_a, toy.links[3].body_b});
  toy.links[3].stiffness -= 1;
  toy.bodies[11].hits += 1;
  CHECK(differing_bodies(toy.state(), before, cells(toy.state())) == std::set<std::uint64_t>{11});
  toy.bodies[11].hits -= 1;
  CHECK(cells(toy.state()) == before);
}

TEST_CASE("cells: ids with gaps and out of order find their rows as dense ids do", "[base][cells][equivalence]") {
  ToySimulation toy(40);
  for (ToyBody& body : toy.bodies) body.id = body.id * 977 + 5;
  for (ToyLink& link : toy.links) link.body_a = link.body_a * 977 + 5, link.body_b = link.body_b * 977 + 5;
  for (ToyBody& body : toy.bodies) body.partner = no_reference;
  std::swap(toy.bodies[2], toy.bodies[30]);  // an order that a faulty simulation may produce
  const StateCells before = cells(toy.state());
  toy.links[4].stiffness = 2;
  CHECK(differing_bodies(toy.state(), before, cells(toy.state())) ==
        std::set<std::uint64_t>{toy.links[4].body_a, toy.links[4].body_b});
}

TEST_CASE("cells: a row that refers to no row there is is an owner itself", "[base][cells][analytic]") {
  ToySimulation toy(6);
  toy.links[1].body_a = 1000;
  toy.links[1].body_b = 1001;
  const StateView& state = toy.state();
  CellHasher hasher(*state.schema);
  bool found = false;
  for (const CellOwner& owner : hasher.owners(state)) found = found || (owner.table == 2 && owner.row == 1);
  CHECK(found);
  const StateCells before = cells(state);
  toy.links[1].stiffness += 1;
  CHECK(cells(state).cells != before.cells);
}

TEST_CASE("cells: their number grows with the owners and stays bounded", "[base][cells][analytic]") {
  CHECK(partition_cells_for(1'000) == 24);
  std::uint32_t last = 0;
  for (std::uint64_t count = 1; count < 10'000'000; count = count * 2 + 1) {
    const std::uint32_t now = partition_cells_for(count);
    CHECK(now >= last);
    CHECK(now <= partition_cells_max);
    last = now;
  }
}

TEST_CASE("cells: partitions spread owners evenly and apart from each other", "[base][cells][analytic]") {
  // 10,000 owners in 24 cells: 416.7 are expected per cell, with a standard deviation of 20. Six standard
  // deviations never occur by chance.
  std::vector<int> counts(partition_count * 24);
  int together = 0;  // owners that share both cells with owner 0: expected 10,000 / 576 = 17.4, deviation 4.2
  const auto first = cells_of({1, 0, 0}, 24);
  for (std::uint64_t key = 0; key < 10'000; ++key) {
    const auto at = cells_of({1, 0, key}, 24);
    for (std::size_t p = 0; p < partition_count; ++p) ++counts[p * 24 + at[p]];
    together += at[0] == first[0] && at[3] == first[3] ? 1 : 0;
  }
  for (const int count : counts) CHECK((count > 296 && count < 537));
  CHECK((together > 1 && together < 44));
}

TEST_CASE("cells: neighbouring ids are spread like others", "[base][cells][regression]") {
  // 24 owners in 24 cells leave (23/24)^24 of the cells empty. On average 15.36 cells are taken, with a deviation of
  // 1.5 for one window and 0.15 for the mean of 100 windows.
  for (std::size_t p = 0; p < partition_count; ++p) {
    std::size_t taken = 0;
    for (std::uint64_t window = 0; window < 100; ++window) {
      std::set<std::uint32_t> cells;
      for (std::uint64_t key = 0; key < 24; ++key) cells.insert(cells_of({1, 0, 24 * window + key}, 24)[p]);
      taken += cells.size();
    }
    CAPTURE(p);
    CHECK((taken > 1'446 && taken < 1'626));
  }
}

}  // namespace
}  // namespace ticktrue::test
