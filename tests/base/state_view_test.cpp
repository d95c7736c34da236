// State as columns: every lane is part of the hash, and images restore equal bits. Bad images are refused, and
// differences are named exactly.
// SPDX-License-Identifier: MIT
#include "base/state/state_view.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <string>

#include "base/hash.h"
#include "base/limits.h"
#include "tests/support/catch.h"

namespace ticktrue {
namespace {

/// A state with owned rows, in canonical (little-endian) bytes until viewed.
struct OwnedState {
  StateSchema schema;
  std::vector<Bytes> rows;                // [table] machine's byte order
  std::vector<std::uint32_t> row_counts;  // [table]

  StateView view() const {
    StateView state;
    state.schema = &schema;
    for (std::size_t t = 0; t < rows.size(); ++t) state.tables.push_back({rows[t].data(), row_counts[t]});
    return state;
  }
};

Column column(const char* name, ScalarType type, std::uint16_t offset, std::uint8_t lane_count = 1) {
  Column c;
  c.name = name;
  c.type = type;
  c.offset = offset;
  c.lane_count = lane_count;
  return c;
}

/// Two tables that use every scalar type, several lanes, ranges, keys and both kinds of reference.
StateSchema sample_schema() {
  StateSchema schema;
  TableSchema bodies;
  bodies.name = "bodies";
  bodies.columns = {column("id", ScalarType::u32, 0), column("position", ScalarType::f32, 4, 2),
                    column("energy", ScalarType::f64, 12), column("type", ScalarType::u8, 20),
                    column("flags", ScalarType::u16, 21)};
  bodies.columns[3].min = 0;
  bodies.columns[3].max = 2;
  bodies.row_size = 23;
  bodies.key_column_count = 1;
  TableSchema contacts;
  contacts.name = "contacts";
  contacts.columns = {column("body_a", ScalarType::u32, 0),   column("body_b", ScalarType::u32, 4),
                      column("age", ScalarType::i32, 8),      column("balance", ScalarType::i64, 12),
                      column("feature", ScalarType::u64, 20), column("joint", ScalarType::u32, 28)};
  contacts.columns[0].target = 0;
  contacts.columns[1].target = 0;
  contacts.columns[2].min = -5;
  contacts.columns[2].max = 5;
  contacts.columns[5].target = 0;
  contacts.columns[5].optional = true;
  contacts.row_size = 32;
  contacts.key_column_count = 2;
  schema.tables = {bodies, contacts};
  return schema;
}

Bytes sample_image() {
  ByteWriter out;
  out.u32(3);
  for (const std::uint32_t id : {2u, 5u, 9u}) {
    out.u32(id);
    out.u32(bits_of(1.5f * static_cast<float>(id)));
    out.u32(bits_of(-0.25f));
    out.f64(1e-300 * id);
    out.u8(static_cast<std::uint8_t>(id % 3));
    out.u16(static_cast<std::uint16_t>(257 * id));
  }
  out.u32(2);
  for (const std::uint32_t b : {5u, 9u}) {
    out.u32(2);
    out.u32(b);
    out.i32(-3);
    out.u64(static_cast<std::uint64_t>(-7));
    out.u64(0x0102030405060708u + b);
    out.u32(b == 5 ? no_reference : 9);
  }
  return out.take();
}

OwnedState state_of(const StateSchema& schema, ByteView image) {
  OwnedState state;
  state.schema = schema;
  const auto tables = split_image(schema, image);
  REQUIRE(tables);
  for (std::size_t t = 0; t < tables->size(); ++t) {
    Bytes rows((*tables)[t].rows.size());
    decode_rows(schema.tables[t], (*tables)[t], rows.data());
    state.rows.push_back(std::move(rows));
    state.row_counts.push_back((*tables)[t].row_count);
  }
  return state;
}

Bytes changed(Bytes image, std::size_t offset, std::initializer_list<int> bytes) {
  for (const int byte : bytes) image[offset++] = static_cast<std::uint8_t>(byte);
  return image;
}

// Offsets from the start of the image to the first row of each table, in bytes.
constexpr std::size_t bodies_at = 4;
constexpr std::size_t contacts_at = 4 + 3 * 23 + 4;

std::string refusal(const StateSchema& schema, const Bytes& image) {
  const auto tables = check_image(schema, image);
  if (tables) return "accepted";
  CHECK(tables.error().code == ErrorCode::corrupt);
  return tables.error().message;
}

TEST_CASE("a state comes back from its image bit for bit", "[base][state_view][equivalence]") {
  const StateSchema schema = sample_schema();
  const Bytes image = sample_image();
  REQUIRE(check_schema(schema));
  REQUIRE(check_image(schema, image));
  const OwnedState state = state_of(schema, image);
  Bytes again;
  encode_image(state.view(), again);
  CHECK(again == image);
  encode_image(state.view(), again);  // into a used buffer
  CHECK(again == image);
}

TEST_CASE("the root hash is the documented one", "[base][state_view][golden]") {
  // Follows docs/trace_format.md, "Root hash", so that the format cannot change unnoticed.
  const StateSchema schema = sample_schema();
  const Bytes image = sample_image();
  const auto hash_text = [](std::string_view text) {
    return hash64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  ByteWriter digest;
  digest.u64(hash_text("bodies"));
  digest.u64(3);
  digest.u64(hash64(ByteView(image).subspan(bodies_at, 3 * 23)));
  digest.u64(hash_text("contacts"));
  digest.u64(2);
  digest.u64(hash64(ByteView(image).subspan(contacts_at, 2 * 32)));
  CHECK(hex64(root_hash(state_of(schema, image).view())) == hex64(hash64(digest.view())));
  CHECK(hex64(root_hash(state_of(schema, image).view())) == "63f38ece3fec16af");
}

TEST_CASE("tables beyond one block are hashed block by block", "[base][state_view][golden]") {
  StateSchema schema;
  TableSchema table;
  table.name = "cells";
  table.columns = {column("value", ScalarType::u64, 0)};
  table.row_size = 8;
  schema.tables = {table};
  for (const std::uint32_t row_count : {0u, 1u, 2047u, 2048u, 2049u, 4096u, 5000u}) {
    CAPTURE(row_count);
    ByteWriter out;
    out.u32(row_count);
    for (std::uint32_t i = 0; i < row_count; ++i) out.u64(i * 0x9e3779b97f4a7c15u);
    const Bytes image = out.take();
    const ByteView rows = ByteView(image).subspan(4);
    ByteWriter digest;
    digest.u64(hash64({reinterpret_cast<const std::uint8_t*>("cells"), 5}));
    digest.u64(row_count);
    for (std::size_t at = 0; at < rows.size(); at += 16384)
      digest.u64(hash64(rows.subspan(at, rows.size() - at < 16384 ? rows.size() - at : 16384)));
    CHECK(root_hash(state_of(schema, image).view()) == hash64(digest.view()));
  }
}

TEST_CASE("every bit of every row changes the root hash", "[base][state_view][equivalence]") {
  OwnedState state = state_of(sample_schema(), sample_image());
  std::vector<std::uint64_t> whole_tables, tables;
  const std::uint64_t whole = root_hash(state.view(), whole_tables);
  REQUIRE(whole_tables.size() == state.rows.size());
  for (std::size_t t = 0; t < state.rows.size(); ++t)
    for (std::size_t bit = 0; bit < state.rows[t].size() * 8; ++bit) {
      state.rows[t][bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
      const std::uint64_t changed = root_hash(state.view(), tables);
      CHECK(changed == root_hash(state.view()));
      if (changed == whole) FAIL_CHECK("table " << t << " bit " << bit << " does not count");
      // The hash of this table changes, and no other.
      for (std::size_t other = 0; other < tables.size(); ++other)
        if ((tables[other] == whole_tables[other]) != (other != t)) FAIL_CHECK("table " << t << " bit " << bit);
      state.rows[t][bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    }
  CHECK(root_hash(state.view(), tables) == whole);
  CHECK(tables == whole_tables);
}

TEST_CASE("rows moved to another table and renamed tables change the root hash", "[base][state_view][equivalence]") {
  StateSchema schema;
  TableSchema table;
  table.columns = {column("value", ScalarType::u32, 0)};
  table.row_size = 4;
  table.name = "a";
  schema.tables.push_back(table);
  table.name = "b";
  schema.tables.push_back(table);
  const std::uint64_t first = root_hash(state_of(schema, Bytes{1, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0}).view());
  const std::uint64_t second = root_hash(state_of(schema, Bytes{0, 0, 0, 0, 1, 0, 0, 0, 7, 0, 0, 0}).view());
  CHECK(first != second);
  schema.tables[0].name = "c";
  CHECK(root_hash(state_of(schema, Bytes{1, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0}).view()) != first);
}

TEST_CASE("a schema comes back from its encoding, and every cut of it is refused", "[base][state_view][corruption]") {
  ByteWriter out;
  encode_schema(sample_schema(), out);
  const Bytes bytes = out.take();
  ByteReader in(bytes);
  const auto schema = decode_schema(in);
  REQUIRE(schema);
  CHECK(*schema == sample_schema());
  CHECK(in.at_end());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ByteReader cut(ByteView(bytes).first(size));
    CAPTURE(size);
    CHECK_FALSE(decode_schema(cut).has_value());
  }
}

TEST_CASE("a schema with any byte changed is refused, or is another schema with exactly those bytes",
          "[base][state_view][corruption]") {
  ByteWriter out;
  encode_schema(sample_schema(), out);
  Bytes bytes = out.take();
  for (std::size_t i = 0; i < bytes.size(); ++i)
    for (const int mask : {0x01, 0x80, 0xff}) {
      bytes[i] ^= static_cast<std::uint8_t>(mask);
      ByteReader in(bytes);
      const auto schema = decode_schema(in);
      if (schema && in.at_end()) {
        ByteWriter again;
        encode_schema(*schema, again);
        if (again.take() != bytes) FAIL_CHECK("byte " << i << " mask " << mask << " is read, but not kept");
      }
      bytes[i] ^= static_cast<std::uint8_t>(mask);
    }
}

TEST_CASE("schemas with a fault are refused, and the fault is named", "[base][state_view][corruption]") {
  const auto refused = [](void (*break_it)(StateSchema&)) -> std::string {
    StateSchema schema = sample_schema();
    break_it(schema);
    const Status status = check_schema(schema);
    return status ? "accepted" : status.error().message;
  };
  using Catch::Matchers::Contains;
  CHECK(check_schema(sample_schema()));
  CHECK_THAT(refused([](StateSchema& s) { s.tables.clear(); }), !Contains("accepted"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[1].name = "bodies"; }), Contains("bodies"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[1].name = "bodies"; }),
             Contains("table bodies: stands twice: as table 0 and as table 1, counted from 0"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].columns[3].name = "id"; }),
             Contains("column id: stands twice: as column 0 and as column 3, counted from 0"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].name.clear(); }), !Contains("accepted"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].columns[1].name = "id"; }), Contains("id"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].columns[1].name.clear(); }), !Contains("accepted"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].columns[1].offset = 5; }), Contains("position"));  // gap
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].columns[1].offset = 3; }), Contains("position"));  // overlap
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].row_size = 24; }), Contains("row size"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].columns[1].lane_count = 0; }), !Contains("accepted"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].columns[1].type = static_cast<ScalarType>(99); }),
             !Contains("accepted"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].key_column_count = 200; }), !Contains("accepted"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[1].columns[0].target = 7; }), Contains("body_a"));
  CHECK_THAT(refused([](StateSchema& s) { s.tables[1].columns[0].target = 1; }), Contains("body_a"));  // two keys
  CHECK_THAT(refused([](StateSchema& s) { s.tables[1].columns[2].target = 0; }), Contains("age"));     // not u32
  CHECK_THAT(refused([](StateSchema& s) { s.tables[0].columns[3].min = 3; }), Contains("type"));
}

TEST_CASE("two equal names are found wherever they stand, and the first pair is named",
          "[base][state_view][property]") {
  std::mt19937 engine(23);
  const auto random = [&engine](std::size_t limit) { return static_cast<std::size_t>(engine()) % limit; };
  for (int round = 0; round < 200; ++round) {
    StateSchema schema;
    schema.tables.resize(2 + random(limits::table_count_max - 1));
    for (std::size_t t = 0; t < schema.tables.size(); ++t) {
      TableSchema& table = schema.tables[t];
      table.name = "t" + std::to_string(t);
      table.row_size = 4;
      table.columns.resize(1);
      table.columns[0].name = "c";
    }
    CHECK(check_schema(schema));
    for (std::size_t copies = 1 + random(3); copies > 0; --copies) {
      const std::size_t from = random(schema.tables.size());
      schema.tables[random(schema.tables.size())].name = schema.tables[from].name;
    }
    // Compares all pairs, as a reference.
    std::string expected;
    for (std::size_t t = 0; t < schema.tables.size() && expected.empty(); ++t)
      for (std::size_t before = t; before-- > 0;)
        if (schema.tables[before].name == schema.tables[t].name) {
          expected = "schema: table " + schema.tables[t].name + ": stands twice: as table " + std::to_string(before) +
                     " and as table " + std::to_string(t) + ", counted from 0";
          break;
        }
    const Status status = check_schema(schema);
    CHECK((status ? std::string() : status.error().message) == expected);
  }
}

TEST_CASE("every cut and every lengthening of an image is refused", "[base][state_view][corruption]") {
  const StateSchema schema = sample_schema();
  Bytes image = sample_image();
  for (std::size_t size = 0; size < image.size(); ++size) {
    CAPTURE(size);
    CHECK_FALSE(check_image(schema, ByteView(image).first(size)).has_value());
  }
  image.push_back(0);
  CHECK(refusal(schema, image) == "state image: 1 bytes left over");
}

TEST_CASE("an image that claims more rows than it has is refused", "[base][state_view][corruption]") {
  const std::string message = refusal(sample_schema(), changed(sample_image(), 0, {0xff, 0xff, 0xff, 0xff}));
  CHECK_THAT(message, Catch::Matchers::Contains("4294967295 rows"));
}

TEST_CASE("values out of their range are refused at their place", "[base][state_view][corruption]") {
  using Catch::Matchers::Contains;
  const StateSchema schema = sample_schema();
  const Bytes image = sample_image();
  // The type of a body is above its range; the age of a contact is below its range.
  CHECK_THAT(refusal(schema, changed(image, bodies_at + 23 + 20, {3})), Contains("bodies[1].type") && Contains("0..2"));
  CHECK_THAT(refusal(schema, changed(image, contacts_at + 8, {0xfa, 0xff, 0xff, 0xff})),
             Contains("contacts[0].age") && Contains("-6"));
  // NaN and infinity, in either precision and any lane.
  CHECK_THAT(refusal(schema, changed(image, bodies_at + 8, {0, 0, 0xc0, 0x7f})), Contains("bodies[0].position[1]"));
  CHECK_THAT(refusal(schema, changed(image, bodies_at + 46 + 4, {0, 0, 0x80, 0xff})),
             Contains("bodies[2].position[0]"));
  CHECK_THAT(refusal(schema, changed(image, bodies_at + 12, {0, 0, 0, 0, 0, 0, 0xf0, 0x7f})),
             Contains("bodies[0].energy"));
}

TEST_CASE("references to rows that are not there are refused", "[base][state_view][corruption]") {
  using Catch::Matchers::Contains;
  const StateSchema schema = sample_schema();
  const Bytes image = sample_image();
  CHECK_THAT(refusal(schema, changed(image, contacts_at + 4, {6})), Contains("contacts[0].body_b") && Contains("id 6"));
  CHECK_THAT(refusal(schema, changed(image, contacts_at + 28, {4, 0, 0, 0})), Contains("contacts[0].joint"));
  // Only an optional reference may be no_reference.
  CHECK_THAT(refusal(schema, changed(image, contacts_at + 32 + 4, {0xff, 0xff, 0xff, 0xff})),
             Contains("contacts[1].body_b"));
  CHECK(check_image(schema, changed(image, contacts_at + 32 + 28, {0xff, 0xff, 0xff, 0xff})));
}

TEST_CASE("rows out of key order and duplicate keys are refused", "[base][state_view][corruption]") {
  using Catch::Matchers::Contains;
  const StateSchema schema = sample_schema();
  const Bytes image = sample_image();
  CHECK_THAT(refusal(schema, changed(image, bodies_at + 23, {2})), Contains("ascend"));  // 2, 2, 9
  CHECK_THAT(refusal(schema, changed(image, bodies_at + 23, {1})), Contains("ascend"));  // 2, 1, 9
  CHECK_THAT(refusal(schema, changed(image, contacts_at + 32 + 4, {5})), Contains("contacts[1]") && Contains("ascend"));
}

TEST_CASE("the first non-finite lane is found, in table, row and column order", "[base][state_view][analytic]") {
  const StateSchema schema = sample_schema();
  CHECK_FALSE(find_non_finite(state_of(schema, sample_image()).view()));
  const struct {
    std::size_t offset;
    std::initializer_list<int> bytes;
    StatePlace place;
  } cases[] = {
      {bodies_at + 23 + 8, {0, 0, 0xc0, 0x7f}, {0, 1, 1, 1}},               // NaN
      {bodies_at + 46 + 4, {0, 0, 0x80, 0x7f}, {0, 2, 1, 0}},               // inf
      {bodies_at + 46 + 4, {0, 0, 0x80, 0xff}, {0, 2, 1, 0}},               // -inf
      {bodies_at + 12, {0, 0, 0, 0, 0, 0, 0xf8, 0xff}, {0, 0, 2, 0}},       // NaN in f64
      {bodies_at + 23 + 12, {1, 0, 0, 0, 0, 0, 0xf0, 0x7f}, {0, 1, 2, 0}},  // signalling NaN
  };
  for (const auto& c : cases) {
    CAPTURE(c.offset);
    const auto place = find_non_finite(state_of(schema, changed(sample_image(), c.offset, c.bytes)).view());
    REQUIRE(place);
    CHECK(*place == c.place);
  }
  // Two values, and opposite infinities, which would cancel in a sum.
  Bytes two = changed(sample_image(), bodies_at + 23 + 4, {0, 0, 0x80, 0x7f});
  two = changed(two, bodies_at + 46 + 4, {0, 0, 0x80, 0xff});
  CHECK(find_non_finite(state_of(schema, two).view()) == StatePlace{0, 1, 1, 0});
}

TEST_CASE("a lane that is not finite is found in rows of every width", "[base][state_view][equivalence]") {
  for (const ScalarType type : {ScalarType::f32, ScalarType::f64})
    for (const std::size_t lane_count : {1u, 2u, 4u, 31u, 32u, 33u, 63u, 64u, 65u, 200u}) {  // 64 words fit in place
      const std::size_t size = type == ScalarType::f32 ? 4 : 8;
      StateSchema schema;
      TableSchema& table = schema.tables.emplace_back();
      table.name = "wide";
      table.row_size = static_cast<std::uint32_t>(4 + lane_count * size);  // first, an id that looks like a NaN
      table.columns.push_back({"id", ScalarType::u32, 1, 0});
      for (std::size_t lane = 0; lane < lane_count; ++lane)
        table.columns.push_back({"x" + std::to_string(lane), type, 1, static_cast<std::uint16_t>(4 + lane * size)});
      constexpr std::size_t row_count = 5;
      Bytes rows(row_count * table.row_size, 0);
      for (std::size_t row = 0; row < row_count; ++row)
        std::fill_n(rows.begin() + static_cast<std::ptrdiff_t>(row * table.row_size), 4, std::uint8_t{0xff});
      const StateView state{&schema, {{rows.data(), row_count}}};
      CHECK_FALSE(find_non_finite(state));
      for (std::size_t lane = 0; lane < lane_count; ++lane) {
        CAPTURE(size, lane_count, lane);
        std::uint8_t* const at = rows.data() + 3 * table.row_size + 4 + lane * size;
        const float single = std::numeric_limits<float>::infinity();
        const double twice = std::numeric_limits<double>::quiet_NaN();
        std::memcpy(at, size == 4 ? static_cast<const void*>(&single) : &twice, size);
        CHECK(find_non_finite(state) == StatePlace{0, 3, 1 + lane, 0});
        std::fill_n(at, size, std::uint8_t{0});
      }
    }
}

TEST_CASE("a lane that is not finite is found in every row of short rows", "[base][state_view][equivalence]") {
  for (const std::size_t lane_count : {1u, 2u, 3u, 7u, 9u, 10u, 16u, 33u}) {
    StateSchema schema;
    TableSchema& table = schema.tables.emplace_back();
    table.name = "samples";
    table.row_size = static_cast<std::uint32_t>(4 * lane_count + 4);
    table.columns = {{"x", ScalarType::f32, static_cast<std::uint8_t>(lane_count), 0},
                     {"id", ScalarType::u32, 1, static_cast<std::uint16_t>(4 * lane_count)}};
    // More rows than a block of 16 KiB holds, and a few that do not fill a group.
    for (const std::uint32_t row_count : {1u, 2u, 5u, 8u, 13u, 16'384u / table.row_size + 11}) {
      std::vector<std::uint32_t> words(std::size_t{row_count} * (lane_count + 1), 0x7f7fffffu);
      for (std::size_t row = 0; row < row_count; ++row) words[row * (lane_count + 1) + lane_count] = 0xffffffffu;
      const StateView state{&schema, {{reinterpret_cast<const std::uint8_t*>(words.data()), row_count}}};
      CHECK_FALSE(find_non_finite(state));
      for (std::size_t row = 0; row < row_count; row += row_count < 20 || row + 20 > row_count ? 1 : 7) {
        CAPTURE(lane_count, row_count, row);
        std::uint32_t& word = words[row * (lane_count + 1) + row % lane_count];
        word = 0xff800000u;
        if (find_non_finite(state) != StatePlace{0, row, 0, row % lane_count}) FAIL_CHECK("not found");
        word = 0x7f7fffffu;
      }
    }
  }
}

TEST_CASE("large finite values are not taken for infinite", "[base][state_view][analytic]") {
  Bytes image = sample_image();
  for (const std::size_t row : {0u, 1u, 2u})  // FLT_MAX and DBL_MAX in each row: sums of them overflow
    image = changed(changed(image, bodies_at + row * 23 + 4, {0xff, 0xff, 0x7f, 0x7f}), bodies_at + row * 23 + 12,
                    {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xef, 0x7f});
  CHECK_FALSE(find_non_finite(state_of(sample_schema(), image).view()));
}

TEST_CASE("a changed lane is the one difference, wherever it is", "[base][state_view][equivalence]") {
  const StateSchema schema = sample_schema();
  const Bytes image = sample_image();
  const auto before = split_image(schema, image);
  REQUIRE(before);
  for (std::size_t t = 0; t < schema.tables.size(); ++t) {
    const TableSchema& table = schema.tables[t];
    for (std::size_t row = 0; row < (*before)[t].row_count; ++row)
      for (std::size_t c = 0; c < table.columns.size(); ++c)
        for (std::size_t lane = 0; lane < table.columns[c].lane_count; ++lane) {
          if (c < table.key_column_count) continue;  // a changed key would be another row
          const std::size_t size = scalar_info(table.columns[c].type)->size;
          const std::size_t first_row = t == 0 ? bodies_at : contacts_at;
          Bytes other = image;
          other[first_row + row * table.row_size + table.columns[c].offset + lane * size] ^= 1;
          const auto after = split_image(schema, other);
          REQUIRE(after);
          const auto differences = diff_images(schema, *before, *after, 10);
          CAPTURE(t, row, c, lane);
          REQUIRE(differences.size() == 1);
          CHECK(differences[0].place == StatePlace{t, row, c, lane});
          REQUIRE(differences[0].expected);
          REQUIRE(differences[0].got);
          CHECK((*differences[0].expected ^ *differences[0].got) == 1);
          CHECK(*differences[0].expected == lane_bits(table, (*before)[t].rows, {t, row, c, lane}));
        }
  }
  CHECK(diff_images(schema, *before, *before, 10).empty());
}

TEST_CASE("a missing and an extra row differ in their keys, and rows after them do not",
          "[base][state_view][equivalence]") {
  const StateSchema schema = sample_schema();
  const Bytes three = sample_image();
  Bytes two(three.begin(), three.end());
  two.erase(two.begin() + bodies_at + 23, two.begin() + bodies_at + 46);  // the body with id 5
  two[0] = 2;
  const auto a = split_image(schema, three);
  const auto b = split_image(schema, two);
  REQUIRE(a);
  REQUIRE(b);
  const auto gone = diff_images(schema, *a, *b, 10);
  REQUIRE(gone.size() == 1);
  CHECK(gone[0].place == StatePlace{0, 1, 0, 0});
  CHECK(gone[0].id == std::uint64_t{5});
  CHECK(gone[0].expected == std::uint64_t{5});
  CHECK_FALSE(gone[0].got);
  const auto extra = diff_images(schema, *b, *a, 10);
  REQUIRE(extra.size() == 1);
  CHECK(extra[0].place == StatePlace{0, 1, 0, 0});
  CHECK(extra[0].got == std::uint64_t{5});
  CHECK_FALSE(extra[0].expected);
}

TEST_CASE("differences stop at the number asked for", "[base][state_view][analytic]") {
  const StateSchema schema = sample_schema();
  const Bytes image = sample_image();
  Bytes other = image;
  for (std::size_t row = 0; row < 3; ++row) other[bodies_at + row * 23 + 4] ^= 1;
  const auto a = split_image(schema, image);
  const auto b = split_image(schema, other);
  REQUIRE(a);
  REQUIRE(b);
  CHECK(diff_images(schema, *a, *b, 100).size() == 3);
  CHECK(diff_images(schema, *a, *b, 2).size() == 2);
}

TEST_CASE("lanes print so that they read back exactly", "[base][state_view][analytic]") {
  CHECK(lane_text(ScalarType::f32, bits_of(0.1f)) == "0.1");
  CHECK(lane_text(ScalarType::f32, bits_of(16777217.0f)) == "16777216");
  CHECK(lane_text(ScalarType::f64, bits_of(0.1)) == "0.1");
  CHECK(lane_text(ScalarType::f64, bits_of(1.0 / 3.0)) == "0.3333333333333333");
  CHECK(lane_text(ScalarType::f64, bits_of(-0.0)) == "-0");
  CHECK(lane_text(ScalarType::i32, 0xffffffffu) == "-1");
  CHECK(lane_text(ScalarType::i64, ~std::uint64_t{0}) == "-1");
  CHECK(lane_text(ScalarType::u64, ~std::uint64_t{0}) == "18446744073709551615");
  CHECK(lane_hex(ScalarType::f32, bits_of(1.0f)) == "3f800000");
  CHECK(lane_hex(ScalarType::u8, 7) == "07");
  CHECK(lane_hex(ScalarType::u16, 7) == "0007");
  CHECK(lane_hex(ScalarType::f64, bits_of(1.0)) == "3ff0000000000000");
}

TEST_CASE("ulp distance counts representable values between two floats", "[base][state_view][analytic]") {
  CHECK(ulp_distance(ScalarType::f32, bits_of(1.0f), bits_of(1.0f)) == std::uint64_t{0});
  CHECK(ulp_distance(ScalarType::f32, bits_of(1.0f), bits_of(1.0f + 0x1p-23f)) == std::uint64_t{1});
  CHECK(ulp_distance(ScalarType::f32, bits_of(1.0f), bits_of(2.0f)) == std::uint64_t{1} << 23);
  CHECK(ulp_distance(ScalarType::f32, bits_of(0.0f), bits_of(-0.0f)) == std::uint64_t{0});
  CHECK(ulp_distance(ScalarType::f32, 1, 0x80000001u) == std::uint64_t{2});
  CHECK(ulp_distance(ScalarType::f64, bits_of(-1.0), bits_of(1.0)) == 2 * bits_of(1.0));
  CHECK_FALSE(ulp_distance(ScalarType::f32, 0x7fc00000u, bits_of(1.0f)));
  CHECK_FALSE(ulp_distance(ScalarType::u32, 1, 2));
}

}  // namespace
}  // namespace ticktrue
