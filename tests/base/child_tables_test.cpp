// Child tables: texts and lists gathered from a program's memory, and the rules of their rows.
// SPDX-License-Identifier: MIT
#include "base/state/child_tables.h"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "base/limits.h"
#include "base/random.h"
#include "base/state/gathered_state.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue {
namespace {

struct Part {
  std::uint16_t kind = 0;
  std::string label;
};
struct Holder {
  std::uint32_t id = 0;
  std::string name;
  std::vector<std::uint8_t> blob;
  std::vector<Part> parts;
};

template <typename List>
const void* give(const List& list, std::size_t* count) {
  *count = list.size();
  return list.data();
}
const Holder& holder(const void* owner) {
  return *static_cast<const Holder*>(owner);
}
const void* name_of(void*, const void* owner, std::uint32_t, std::size_t* count) {
  return give(holder(owner).name, count);
}
const void* blob_of(void*, const void* owner, std::uint32_t, std::size_t* count) {
  return give(holder(owner).blob, count);
}
const void* parts_of(void*, const void* owner, std::uint32_t, std::size_t* count) {
  return give(holder(owner).parts, count);
}
const void* label_of(void*, const void* owner, std::uint32_t, std::size_t* count) {
  return give(static_cast<const Part*>(owner)->label, count);
}

/// Holders with all kinds of children.
class HolderState {
 public:
  explicit HolderState(bool has_ids) {
    const RowMember id{"id", ScalarType::u32, 1, offsetof(Holder, id)};
    table_ = *state.table("holders", sizeof(Holder), {&id, 1});
    const RowMember kind{"kind", ScalarType::u16, 1, offsetof(Part, kind)};
    REQUIRE(state.child("holders.name", "holders", {TableForm::text, name_of, nullptr, 1}, {}));
    REQUIRE(state.child("holders.blob", "holders", {TableForm::bytes, blob_of, nullptr, 1}, {}));
    REQUIRE(state.child("holders.parts", "holders", {TableForm::rows, parts_of, nullptr, sizeof(Part)}, {&kind, 1}));
    REQUIRE(state.child("holders.parts.label", "holders.parts", {TableForm::text, label_of, nullptr, 1}, {}));
    if (has_ids) REQUIRE(state.key("holders", 1));
    REQUIRE(state.freeze());
  }
  Bytes image(const std::vector<Holder>& holders) {
    REQUIRE(state.rows(table_, holders.data(), static_cast<std::uint32_t>(holders.size())));
    REQUIRE(state.gather());
    Bytes image;
    encode_image(state.view(), image);
    return image;
  }
  GatheredState state;

 private:
  std::size_t table_ = 0;
};

std::string random_text(Random& random, std::size_t size_max) {
  std::string text(random.below(size_max + 1), ' ');
  for (char& c : text) c = static_cast<char>(random.below(256));
  return text;
}

std::vector<Holder> random_holders(Random& random) {
  std::vector<Holder> holders(random.below(8));
  std::uint32_t id = 0;
  for (Holder& one : holders) {
    one.id = id += 1 + static_cast<std::uint32_t>(random.below(5));
    one.name = random_text(random, 50);
    const std::string blob = random_text(random, 600);
    one.blob.assign(blob.begin(), blob.end());
    one.parts.resize(random.below(4));
    for (Part& part : one.parts) part = {static_cast<std::uint16_t>(random.below(9)), random_text(random, 45)};
  }
  return holders;
}

/// The text of an owner, from the pieces of the image.
std::string joined(const TableSchema& table, const ImageTable& rows, std::uint32_t owner) {
  std::string text;
  for (std::size_t row = 0; row < rows.row_count; ++row) {
    if (child_key(table, rows, row).owner != owner) continue;
    const auto* at = reinterpret_cast<const char*>(rows.rows.data() + row * table.row_size);
    text.append(at + 12, static_cast<unsigned char>(at[8]));
  }
  return text;
}

TEST_CASE("texts, bytes and lists of lists come back from an image, whatever they hold", "[base][children][property]") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const bool has_ids = seed % 2 == 0;
    HolderState holders_state(has_ids);
    for (int round = 0; round < 3; ++round) {
      const std::vector<Holder> holders = random_holders(random);
      const Bytes image = holders_state.image(holders);
      const StateSchema& schema = holders_state.state.schema();
      const auto tables = check_image(schema, image);
      REQUIRE(tables);
      std::uint32_t part_row = 0;
      for (std::uint32_t row = 0; row < holders.size(); ++row) {
        const std::uint32_t owner = has_ids ? holders[row].id : row;
        CHECK(joined(schema.tables[1], (*tables)[1], owner) == holders[row].name);
        CHECK(joined(schema.tables[2], (*tables)[2], owner) ==
              std::string(holders[row].blob.begin(), holders[row].blob.end()));
        for (std::uint32_t i = 0; i < holders[row].parts.size(); ++i, ++part_row) {
          const ChildKey key = child_key(schema.tables[3], (*tables)[3], part_row);
          CHECK((key.owner == owner && key.index == i));
          CHECK(lane_bits(schema.tables[3], (*tables)[3].rows, {3, part_row, 2, 0}) == holders[row].parts[i].kind);
          CHECK(joined(schema.tables[4], (*tables)[4], part_row) == holders[row].parts[i].label);
        }
      }
      CHECK((*tables)[3].row_count == part_row);
    }
  }
}

TEST_CASE("children that stay as large take no new memory", "[base][children][allocation]") {
  Random random(3);
  std::vector<Holder> holders = random_holders(random);
  while (holders.size() < 4) holders = random_holders(random);
  HolderState holders_state(true);
  holders[0].name = std::string(200, 'a');
  holders_state.image(holders);
  const std::vector<TableRows> before = holders_state.state.view().tables;
  for (int tick = 0; tick < 20; ++tick) {
    holders[0].name = std::string(static_cast<std::size_t>(180 + tick), 'b');
    REQUIRE(holders_state.state.gather());
    for (std::size_t t = 1; t < before.size(); ++t) CHECK(holders_state.state.view().tables[t].data == before[t].data);
  }
}

TEST_CASE("rows of children that break a rule are refused with the place", "[base][children][corruption]") {
  struct Case {
    std::string name;
    std::function<void(std::vector<std::uint8_t*>)> break_it;  // the begin of each row of the texts
    std::string message;
  };
  // Texts of 45 bytes (three pieces) and of 4, owners 2 and 5.
  const std::vector<Case> cases{
      {"index gap", [](auto rows) { rows[1][4] = 2; }, "names[1]: index: found 2, expected 1: it counts without gap"},
      {"index begins late", [](auto rows) { rows[3][4] = 1; }, "names[3]: index: found 1, expected 0"},
      {"owner unknown", [](auto rows) { rows[3][0] = 6; },
       "names[3]: owner: found 6, expected the id of a row of units"},
      {"owners descend", [](auto rows) { rows[3][0] = 1; }, "names[3]: owner: found 1, expected at least 2"},
      {"piece not full", [](auto rows) { rows[0][8] = 19; }, "names[0]: size: found 19, expected 20"},
      {"piece empty", [](auto rows) { rows[3][8] = 0; }, "names[3]: size: found 0, expected 1..20"},
      {"piece too large", [](auto rows) { rows[2][8] = 21; }, "names[2]: size: found 21, expected 1..20"},
      {"not padded", [](auto rows) { rows[3][12 + 7] = 1; }, "names[3]: byte 7, which is unused: found 1, expected 0"},
  };
  for (const Case& one : cases) {
    CAPTURE(one.name);
    const std::vector<std::string> texts{std::string(45, 'x'), "abcd"};
    const std::vector<std::uint32_t> ids{2, 5};
    GatheredState state;
    REQUIRE(state.column("units", "id", {ids.data(), ScalarType::u32, 1, 2}));
    REQUIRE(state.key("units", 1));
    const ElementReader read = [](void* user, const void*, std::uint32_t row, std::size_t* count) -> const void* {
      const std::string& text = (*static_cast<const std::vector<std::string>*>(user))[row];
      *count = text.size();
      return text.data();
    };
    REQUIRE(
        state.child("names", "units", {TableForm::text, read, const_cast<std::vector<std::string>*>(&texts), 1}, {}));
    REQUIRE(state.freeze());
    REQUIRE(state.gather());
    Bytes image;
    encode_image(state.view(), image);
    REQUIRE(check_image(state.schema(), image));
    constexpr std::size_t names_at = 4 + 2 * 4 + 4;
    std::vector<std::uint8_t*> rows;
    for (std::size_t row = 0; row < 4; ++row) rows.push_back(image.data() + names_at + 32 * row);
    one.break_it(rows);
    const auto refused = check_children(state.schema(), *split_image(state.schema(), image));
    REQUIRE_FALSE(refused);
    CHECK(test::contains(refused.error().message, one.message));
    CHECK_FALSE(check_image(state.schema(), image));
  }
}

TEST_CASE("an owner by number is a row of the parent", "[base][children][corruption]") {
  HolderState holders_state(false);
  std::vector<Holder> holders(2);
  holders[1].name = "x";
  Bytes image = holders_state.image(holders);
  const StateSchema& schema = holders_state.state.schema();
  REQUIRE(check_children(schema, *split_image(schema, image)));
  constexpr std::size_t names_at = 4 + 2 * 4 + 4;
  image[names_at] = 2;
  const auto refused = check_children(schema, *split_image(schema, image));
  REQUIRE_FALSE(refused);
  CHECK(test::contains(refused.error().message, "owner: found 2, expected a row of holders, which has 2"));
  // Where only others are new, it is not looked at again.
  const std::vector<std::uint32_t> others{3, 4}, parent{0};
  CHECK(check_children(schema, *split_image(schema, image), others));
  CHECK_FALSE(check_children(schema, *split_image(schema, image), parent));
}

}  // namespace
}  // namespace ticktrue
