// Gathers scattered columns into packed rows, and writes them back.
// SPDX-License-Identifier: MIT
#include "base/state/gathered_state.h"

#include <algorithm>
#include <cstring>
#include <random>

#include "tests/support/catch.h"

using namespace ticktrue;

TEST_CASE("any layout gathers to the same rows as a copy value by value, and scatters back",
          "[base][gather][property]") {
  std::mt19937 engine(11);
  const auto random = [&engine] { return static_cast<std::uint32_t>(engine()); };
  for (int round = 0; round < 300; ++round) {
    const auto row_count = static_cast<std::uint32_t>(random() % 9);
    struct Values {
      Bytes memory;
      std::size_t start, stride, size;
    };
    std::vector<Values> columns(1 + random() % 5);
    GatheredState state;
    // Some columns share one block, as members of a struct do.
    Bytes shared(row_count * 64 + 64);
    for (std::uint8_t& byte : shared) byte = static_cast<std::uint8_t>(random());
    std::size_t used = 0;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const auto type = static_cast<ScalarType>(1 + random() % 6);  // integer types only: any bits are a valid value
      const std::uint32_t lanes = 1 + random() % 3;
      Values& values = columns[c];
      values.size = scalar_info(type)->size * lanes;
      const bool in_struct = random() % 2 == 0 && used + values.size <= 64;
      values.stride = in_struct ? 64 : values.size + random() % 5;
      values.memory.resize(in_struct ? 0 : row_count * values.stride + 16);
      for (std::uint8_t& byte : values.memory) byte = static_cast<std::uint8_t>(random());
      values.start = in_struct ? used : random() % 8;
      used += in_struct ? values.size + random() % 3 : 0;
      ColumnSource source;
      source.writable = (in_struct ? shared.data() : values.memory.data()) + values.start;
      source.data = source.writable;
      source.type = type;
      source.lane_count = lanes;
      source.row_count = row_count;
      source.stride = values.stride;
      REQUIRE(state.column("t", "c" + std::to_string(c), source));
    }
    REQUIRE(state.freeze());
    REQUIRE(state.gather());
    const TableSchema& table = state.schema().tables[0];
    const std::uint8_t* rows = state.view().tables[0].data;
    const auto at = [&](std::size_t c, std::size_t row) {
      const Bytes& block =
          columns[c].memory.empty() && row_count > 0 && columns[c].stride == 64 ? shared : columns[c].memory;
      return block.data() + columns[c].start + row * columns[c].stride;
    };
    bool equal = true;
    for (std::size_t row = 0; row < row_count; ++row)
      for (std::size_t c = 0; c < columns.size(); ++c)
        equal = equal &&
                std::memcmp(rows + row * table.row_size + table.columns[c].offset, at(c, row), columns[c].size) == 0;
    CHECK(equal);

    Bytes image;
    encode_image(state.view(), image);
    const auto tables = split_image(state.schema(), image);
    REQUIRE(tables);
    std::fill(shared.begin(), shared.end(), std::uint8_t{0});
    for (Values& values : columns) std::fill(values.memory.begin(), values.memory.end(), std::uint8_t{0});
    state.scatter(0, (*tables)[0]);
    REQUIRE(state.gather());
    Bytes again;
    encode_image(state.view(), again);
    CHECK((again == image));
  }
}

TEST_CASE("what is registered wrongly is refused with its place", "[base][gather][corruption]") {
  std::uint32_t words[4] = {1, 2, 3, 4};
  const auto source = [&](std::uint32_t lanes, std::uint32_t rows, std::size_t stride) {
    ColumnSource made;
    made.data = words;
    made.type = ScalarType::u32;
    made.lane_count = lanes;
    made.row_count = rows;
    made.stride = stride;
    return made;
  };
  GatheredState state;
  const auto message = [&](const Status& status) { return status ? std::string("accepted") : status.error().message; };
  CHECK(message(state.column("", "x", source(1, 1, 0))) == "table: name: found 0 bytes, expected 1..256");
  CHECK(message(state.column("t", std::string(300, 'x'), source(1, 1, 0))) ==
        "table t: column: name: found 300 bytes, expected 1..256");
  CHECK(message(state.column("t", "x", source(0, 1, 0))) == "table t: column x: lanes: found 0, expected 1..255");
  CHECK(message(state.column("t", "x", source(2, 2, 4))) ==
        "table t: column x: stride: found 4 bytes, expected at least 8 (2 lanes of u32)");
  CHECK(message(state.freeze()) == "state: found no column, expected at least one");
  ColumnSource null = source(1, 2, 0);
  null.data = nullptr;
  CHECK(message(state.column("t", "x", null)) ==
        "table t: column x: pointer: found null, expected the first of 2 rows");
  CHECK(message(state.column("t", "x", source(1, 0xffffffffu, 0))) ==
        "table t: column x: rows: found 4294967295, expected at most 67108864");
  CHECK(message(state.key("t", 1)) == "key: table t: found none of this name");
  REQUIRE(state.column("t", "x", source(1, 4, 0)));
  CHECK(message(state.key("t", 2)) == "table t: key columns: found 2, expected 1..1 (those registered so far)");
  CHECK(message(state.reference("t", "y", "t")) == "reference: table t: column y: found none of this name");
  CHECK(message(state.reference("t", "x", "u")) == "reference: table u: found none of this name");
}
