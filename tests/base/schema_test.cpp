// Schemas of format version 3: classes, children, small signed numbers, limits, and the judged part.
// SPDX-License-Identifier: MIT
#include "base/state/schema.h"

#include <functional>

#include "base/limits.h"
#include "base/random.h"
#include "base/state/state_view.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

constexpr SchemaLayout third = SchemaLayout::third;

/// Appends a column after the columns of its class.
Column& add(TableSchema& table, const std::string& name, ScalarType type, bool is_shown = false,
            std::uint8_t lane_count = 1) {
  Column column;
  column.name = name;
  column.type = type;
  column.lane_count = lane_count;
  column.is_shown = is_shown;
  std::uint32_t& size = is_shown ? table.shown_row_size : table.row_size;
  column.offset = static_cast<std::uint16_t>(size);
  size += std::uint32_t{scalar_info(type)->size} * lane_count;
  table.columns.push_back(column);
  return table.columns.back();
}

TableSchema& add_table(StateSchema& schema, const std::string& name) {
  schema.tables.emplace_back();
  schema.tables.back().name = name;
  return schema.tables.back();
}

TableSchema& add_child(StateSchema& schema, const std::string& name, TableForm form, std::int16_t parent) {
  TableSchema& child = add_table(schema, name);
  child.form = form;
  child.parent = parent;
  child.key_column_count = 2;
  add(child, "owner", ScalarType::u32).target = parent;
  add(child, "index", ScalarType::u32);
  if (form == TableForm::rows) return child;
  add(child, "size", ScalarType::u32);
  add(child, "bytes", ScalarType::u32, false, 5);
  return child;
}

/// A schema with every feature. A shown table precedes the judged tables.
StateSchema sample() {
  StateSchema schema;
  TableSchema& sparks = add_table(schema, "sparks");
  add(sparks, "x", ScalarType::f32, true);
  TableSchema& units = add_table(schema, "units");
  units.key_column_count = 1;
  add(units, "id", ScalarType::u32);
  add(units, "level", ScalarType::i8);
  add(units, "offset", ScalarType::i16, false, 2);
  add(units, "glow", ScalarType::f32, true);
  add(units, "spark", ScalarType::u64, true);
  add_child(schema, "units.name", TableForm::text, 1);
  add(add_child(schema, "units.items", TableForm::rows, 1), "count", ScalarType::u8);
  return schema;
}

Result<StateSchema> read(ByteView bytes) {
  ByteReader in(bytes);
  Result<StateSchema> schema = decode_schema(in, third);
  if (schema && !in.at_end()) return Error{ErrorCode::corrupt, "left over", ""};
  return schema;
}

Bytes written(const StateSchema& schema) {
  ByteWriter out;
  encode_schema(schema, out, third);
  return out.take();
}

/// A schema with judged columns only, which has the layout of versions 1 and 2.
StateSchema wide(std::size_t table_count, std::size_t column_count) {
  StateSchema schema;
  for (std::size_t t = 0; t < table_count; ++t) {
    TableSchema& table = add_table(schema, "t" + std::to_string(t));
    for (std::size_t c = 0; c < column_count; ++c) add(table, "c" + std::to_string(c), ScalarType::u8);
  }
  return schema;
}

TEST_CASE("a schema of version 3 is read as it was written, and no part of it is one", "[base][schema][equivalence]") {
  const StateSchema schema = sample();
  REQUIRE(check_schema(schema, third));
  CHECK(layout_of(schema) == third);
  const Bytes bytes = written(schema);
  const Result<StateSchema> again = read(bytes);
  REQUIRE(again);
  CHECK(*again == schema);
  CHECK(written(*again) == bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size) CHECK(!read(ByteView(bytes).first(size)));
}

TEST_CASE("any change of a byte of a schema is refused or another schema", "[base][schema][corruption]") {
  const Bytes whole = written(sample());
  Bytes bytes = whole;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int mask : {0x01, 0x02, 0x80, 0xff}) {
      bytes[i] = static_cast<std::uint8_t>(whole[i] ^ mask);
      const Result<StateSchema> schema = read(bytes);
      CAPTURE(i, mask);
      if (schema) CHECK(written(*schema) == bytes);
    }
    bytes[i] = whole[i];
  }
}

TEST_CASE("the judged part has neither shown columns nor tables of them alone", "[base][schema][analytic]") {
  const StateSchema judged = judged_schema(sample());
  REQUIRE(check_schema(judged, third));
  REQUIRE(judged.tables.size() == 3);
  CHECK(judged.tables[0].name == "units");
  CHECK(judged.tables[0].columns.size() == 3);
  CHECK(judged.tables[0].shown_row_size == 0);
  CHECK(judged.tables[0].row_size == 9);
  CHECK(judged.tables[1].parent == 0);
  CHECK(judged.tables[1].columns[0].target == 0);
  CHECK(!has_shown_columns(judged));
  CHECK(judged_schema(judged) == judged);
  CHECK(has_shown_columns(sample()));
}

TEST_CASE("a schema that needs nothing new has the layout of versions 1 and 2", "[base][schema][analytic]") {
  CHECK(layout_of(wide(64, 3)) == SchemaLayout::first);
  CHECK(layout_of(wide(65, 3)) == third);
  const std::function<void(StateSchema&)> changes[] = {
      [](StateSchema& s) { add(s.tables[0], "new", ScalarType::i8); },
      [](StateSchema& s) { add(s.tables[0], "new", ScalarType::i16); },
      [](StateSchema& s) { add(s.tables[0], "new", ScalarType::u8, true); },
      [](StateSchema& s) { add_child(s, "child", TableForm::rows, 0).columns[0].target = -1; },
  };
  for (const auto& change : changes) {
    StateSchema schema = wide(2, 2);
    REQUIRE(check_schema(schema));
    change(schema);
    CHECK(layout_of(schema) == third);
    CHECK(check_schema(schema, third));
    CHECK(!check_schema(schema));
  }
}

TEST_CASE("each limit of a schema holds, and one more is refused", "[base][schema][limits]") {
  CHECK(check_schema(wide(4'096, 1), third));
  CHECK(check_schema(wide(4'096, 16), third));  // 65,536 columns
  CHECK(check_schema(wide(1, 256), third));
  CHECK(read(written(wide(4'096, 16))));
  const auto refused = [](const StateSchema& schema, const std::string& what) {
    CAPTURE(what);
    const Status status = check_schema(schema, third);
    REQUIRE_FALSE(status);
    CHECK(status.error().message.find(what) != std::string::npos);
    CHECK(!read(written(schema)));
  };
  refused(wide(4'097, 1), "table count: found 4097, expected 1..4096");
  StateSchema columns = wide(4'096, 16);
  add(columns.tables[0], "one_more", ScalarType::u8);
  refused(columns, "columns of all tables: found 65537, expected at most 65536");
  refused(wide(1, 257), "column count: found 257, expected 1..256");
  for (const bool is_shown : {false, true}) {
    StateSchema rows;
    TableSchema& table = add_table(rows, "t");
    for (int c = 0; c < 16; ++c) add(table, "c" + std::to_string(c), ScalarType::u64, is_shown, 32);
    CHECK(check_schema(rows, third));
    add(table, "one_more", ScalarType::u8, is_shown);
    refused(rows, is_shown ? "shown row size: found 4097" : "row size: found 4097");
  }
}

TEST_CASE("a schema that contradicts itself is refused with the place", "[base][schema][corruption]") {
  struct Wrong {
    std::string what;
    std::function<void(StateSchema&)> change;
  };
  const Wrong all[] = {
      {"unknown scalar type", [](StateSchema& s) { s.tables[1].columns[1].type = static_cast<ScalarType>(11); }},
      {"form: found 4, expected 0..3", [](StateSchema& s) { s.tables[2].form = static_cast<TableForm>(4); }},
      {"has a parent and no form of a child", [](StateSchema& s) { s.tables[2].form = TableForm::plain; }},
      {"or a form and no parent", [](StateSchema& s) { s.tables[2].parent = -1; }},
      {"its parent does not stand before it", [](StateSchema& s) { s.tables[2].parent = 3; }},
      {"its parent does not stand before it", [](StateSchema& s) { s.tables[2].parent = 2; }},
      {"its parent sparks has no judged column", [](StateSchema& s) { s.tables[2].parent = 0; }},
      {"does not refer to its parent units", [](StateSchema& s) { s.tables[2].columns[0].target = -1; }},
      {"a child begins with the key columns", [](StateSchema& s) { s.tables[2].columns[0].name = "of"; }},
      {"a child begins with the key columns", [](StateSchema& s) { s.tables[2].columns[0].optional = true; }},
      {"a child begins with the key columns", [](StateSchema& s) { s.tables[2].key_column_count = 1; }},
      {"has the u32 columns owner, index, size and bytes",
       [](StateSchema& s) { add(s.tables[2], "more", ScalarType::u32); }},
      {"has the u32 columns owner, index, size and bytes",
       [](StateSchema& s) { s.tables[2].columns[2].name = "length"; }},
      {"a judged column stands behind a shown one", [](StateSchema& s) { add(s.tables[1], "late", ScalarType::u8); }},
      // A child has two key columns, so nothing can refer to a child. Cycles of children are therefore impossible.
      {"to a table with one u32 key", [](StateSchema& s) { add(s.tables[3], "of", ScalarType::u32).target = 2; }},
      {"a key column must be one unsigned integer", [](StateSchema& s) { s.tables[1].key_column_count = 2; }},
      {"key columns must all be judged, or all be shown",
       [](StateSchema& s) {
         TableSchema& table = add_table(s, "mixed");
         add(table, "a", ScalarType::u32);
         add(table, "b", ScalarType::u32, true);
         table.key_column_count = 2;
       }},
      {"which has no judged column",
       [](StateSchema& s) {
         s.tables[0] = {};
         s.tables[0].name = "sparks";
         s.tables[0].key_column_count = 1;
         add(s.tables[0], "id", ScalarType::u32, true);
         add(s.tables[3], "spark", ScalarType::u32).target = 0;
       }},
      {"offset: found 4, expected 0", [](StateSchema& s) { s.tables[1].columns[3].offset = 4; }},
      {"shown row size: found 13, columns cover 12", [](StateSchema& s) { ++s.tables[1].shown_row_size; }},
  };
  for (const Wrong& wrong : all) {
    CAPTURE(wrong.what);
    StateSchema schema = sample();
    wrong.change(schema);
    const Status status = check_schema(schema, third);
    REQUIRE_FALSE(status);
    CAPTURE(status.error().message);
    CHECK(status.error().message.find(wrong.what) != std::string::npos);
    CHECK(!read(written(schema)));
  }
  Bytes bytes = written(sample());
  bytes.back() = 2;  // the class of the last column
  const Result<StateSchema> refused = read(bytes);
  REQUIRE(!refused);
  CHECK(refused.error().message.find("class of a column is neither 0 nor 1") != std::string::npos);
}

TEST_CASE("small signed numbers are printed, and held to their ranges, with their sign", "[base][schema][analytic]") {
  CHECK(lane_text(ScalarType::i8, 0xff) == "-1");
  CHECK(lane_text(ScalarType::i8, 0x80) == "-128");
  CHECK(lane_text(ScalarType::i8, 0x7f) == "127");
  CHECK(lane_text(ScalarType::i16, 0x8000) == "-32768");
  CHECK(lane_text(ScalarType::i16, 0xfffe) == "-2");
  CHECK(lane_hex(ScalarType::i8, 0xff) == "ff");
  StateSchema schema;
  TableSchema& table = add_table(schema, "t");
  Column& column = add(table, "v", ScalarType::i8);
  column.min = -5;
  column.max = 3;
  for (int value = -128; value < 128; ++value) {
    const Bytes image{1, 0, 0, 0, static_cast<std::uint8_t>(value)};
    CHECK(check_image(schema, image).has_value() == (value >= -5 && value <= 3));
  }
}

TEST_CASE("random schemas are read as they were written", "[base][schema][property]") {
  Random random(17);
  for (int round = 0; round < 200; ++round) {
    StateSchema schema;
    const std::uint64_t table_count = 1 + random.below(20);
    for (std::uint64_t t = 0; t < table_count; ++t) {
      const bool is_child = t > 0 && random.below(3) == 0;
      const auto parent = static_cast<std::int16_t>(is_child ? random.below(t) : 0);
      const std::string name = "t" + std::to_string(t);
      if (is_child && schema.tables[static_cast<std::size_t>(parent)].row_size > 0) {
        TableSchema& child = add_child(schema, name, static_cast<TableForm>(1 + random.below(3)), parent);
        const TableSchema& of = schema.tables[static_cast<std::size_t>(parent)];
        if (of.key_column_count != 1 || of.columns[0].type != ScalarType::u32) child.columns[0].target = -1;
        continue;
      }
      TableSchema& table = add_table(schema, name);
      const std::uint64_t judged = random.below(6), shown = random.below(4);
      for (std::uint64_t c = 0; c < std::max<std::uint64_t>(1, judged + shown); ++c)
        add(table, "c" + std::to_string(c), static_cast<ScalarType>(1 + random.below(10)), c >= judged,
            static_cast<std::uint8_t>(1 + random.below(3)));
      if (table.columns[0].type == ScalarType::u32 && table.columns[0].lane_count == 1) table.key_column_count = 1;
    }
    REQUIRE(check_schema(schema, third));
    const Result<StateSchema> again = read(written(schema));
    REQUIRE(again);
    CHECK(*again == schema);
    const StateSchema judged = judged_schema(schema);
    CHECK((judged.tables.empty() || check_schema(judged, third)));
  }
}

}  // namespace
}  // namespace ticktrue::test
