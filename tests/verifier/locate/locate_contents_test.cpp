// Differing texts and byte strings of two states: what is told of random states, against strings that are whole.
// SPDX-License-Identifier: MIT
#include "verifier/locate/locate_contents.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>

#include "base/random.h"
#include "base/state/gathered_state.h"
#include "tests/support/catch.h"

namespace ticktrue::test {
namespace {

using verifier::ContentDifference;
using verifier::ContentDifferences;
using verifier::ContentSide;

struct Shelf {
  std::uint32_t id = 0;
  std::string name;
  std::string blob;
  std::vector<std::string> labels;  // one of each slip
};
using Shelves = std::vector<Shelf>;

template <typename List>
const void* elements_of(const List& list, std::size_t* count) {
  *count = list.size();
  return list.data();
}
const Shelf& shelf(const void* owner) {
  return *static_cast<const Shelf*>(owner);
}

/// The tables of shelves.
class ShelfTables {
 public:
  ShelfTables(const Shelves& shelves, bool has_ids) {
    const RowMember id{"id", ScalarType::u32, 1, offsetof(Shelf, id)};
    const auto table = state_.table("shelves", sizeof(Shelf), {&id, 1});
    REQUIRE(table);
    const ElementReader name = [](void*, const void* owner, std::uint32_t, std::size_t* count) {
      return elements_of(shelf(owner).name, count);
    };
    const ElementReader blob = [](void*, const void* owner, std::uint32_t, std::size_t* count) {
      return elements_of(shelf(owner).blob, count);
    };
    const ElementReader slips = [](void*, const void* owner, std::uint32_t, std::size_t* count) {
      return elements_of(shelf(owner).labels, count);
    };
    const ElementReader label = [](void*, const void* owner, std::uint32_t, std::size_t* count) {
      return elements_of(*static_cast<const std::string*>(owner), count);
    };
    REQUIRE(state_.child("shelves.name", "shelves", {TableForm::text, name, nullptr, 1}, {}));
    REQUIRE(state_.child("shelves.blob", "shelves", {TableForm::bytes, blob, nullptr, 1}, {}));
    REQUIRE(state_.child("shelves.slips", "shelves", {TableForm::rows, slips, nullptr, sizeof(std::string)}, {}));
    REQUIRE(state_.child("shelves.slips.label", "shelves.slips", {TableForm::text, label, nullptr, 1}, {}));
    if (has_ids) REQUIRE(state_.key("shelves", 1));
    REQUIRE(state_.freeze());
    REQUIRE(state_.rows(*table, shelves.data(), static_cast<std::uint32_t>(shelves.size())));
    REQUIRE(state_.gather());
    encode_image(state_.view(), image_);
    auto tables = split_image(state_.schema(), image_);
    REQUIRE(tables);
    tables_ = std::move(*tables);
  }
  const StateSchema& schema() const { return state_.schema(); }
  std::span<const ImageTable> tables() const { return tables_; }

 private:
  GatheredState state_;
  Bytes image_;
  std::vector<ImageTable> tables_;
};

std::string drawn_text(Random& random, std::size_t size_max) {
  static constexpr const char* characters[] = {"a", "b", "c", "\xc3\xa4", "\xe2\x82\xac", "\xf0\x9d\x84\x9e"};
  std::string text;
  for (std::uint64_t i = random.below(size_max + 1); i > 0; --i)
    text += characters[random.below(4) == 0 ? random.below(6) : random.below(3)];
  return text;
}

std::string drawn_blob(Random& random) {
  std::string blob(random.below(3) == 0 ? 0 : random.below(700), ' ');
  for (char& byte : blob) byte = static_cast<char>(random.below(256));
  return blob;
}

bool is_first_byte(char byte) {
  return (static_cast<unsigned char>(byte) & 0xc0) != 0x80;
}

/// Cuts at a character or inside of one, changes one, adds some, or leaves it.
void change_text(Random& random, std::string& text) {
  std::size_t at = random.below(text.size() + 1);
  const std::uint64_t what = random.below(6);
  if (what == 5) text.resize(at);
  while (at < text.size() && !is_first_byte(text[at])) --at;
  if (what == 0) text.resize(at);
  if (what == 1) text.insert(at, drawn_text(random, 3));
  if (what == 2) text += drawn_text(random, 60);
  if (what == 3 && at < text.size() && (text[at] == 'a' || text[at] == 'b')) ++text[at];
}

Shelves drawn_shelves(Random& random) {
  Shelves shelves(random.below(7));
  std::uint32_t id = 0;
  for (Shelf& one : shelves) {
    one.id = id += 1 + static_cast<std::uint32_t>(random.below(3));
    one.name = drawn_text(random, random.below(2) == 0 ? 120 : 8);
    one.blob = drawn_blob(random);
    one.labels.resize(random.below(4));
    for (std::string& label : one.labels) label = drawn_text(random, 50);
  }
  return shelves;
}

Shelves changed_shelves(Random& random, Shelves shelves) {
  for (Shelf& one : shelves) {
    change_text(random, one.name);
    if (random.below(2) == 0 && !one.blob.empty()) ++one.blob[random.below(one.blob.size())];
    if (random.below(4) == 0) one.labels.resize(random.below(4), "new");
    for (std::string& label : one.labels) change_text(random, label);
  }
  if (random.below(3) == 0 && !shelves.empty())
    shelves.erase(shelves.begin() + static_cast<std::ptrdiff_t>(random.below(shelves.size())));
  return shelves;
}

/// The bytes of an owner in one state, and where it stands there.
struct Whole {
  std::string bytes;
  std::size_t row = 0;
};
/// By id or row of the shelf, and index of the slip.
using Wholes = std::map<std::pair<std::uint64_t, std::size_t>, Whole>;

Wholes wholes_of(const Shelves& shelves, bool has_ids, std::size_t table) {
  Wholes wholes;
  for (std::size_t row = 0; row < shelves.size(); ++row) {
    const Shelf& one = shelves[row];
    const std::uint64_t owner = has_ids ? one.id : row;
    if (table == 1) wholes[{owner, 0}] = {one.name, row};
    if (table == 2) wholes[{owner, 0}] = {one.blob, row};
    if (table == 4)
      for (std::size_t i = 0; i < one.labels.size(); ++i) wholes[{owner, i}] = {one.labels[i], row};
  }
  return wholes;
}

/// What should be told of one owner; nothing: its bytes are the same.
std::optional<ContentDifference> told_of(std::size_t table, const Whole* const (&states)[2], std::size_t index,
                                         bool has_ids, const std::array<const Shelves*, 2>& shelves) {
  static const std::string none;
  const std::string* const texts[] = {states[0] ? &states[0]->bytes : &none, states[1] ? &states[1]->bytes : &none};
  if (*texts[0] == *texts[1]) return std::nullopt;
  ContentDifference told;
  told.table = table == 1 ? "shelves.name" : table == 2 ? "shelves.blob" : "shelves.slips.label";
  told.is_text = table != 2;
  told.placed_by = texts[0]->empty() ? 1 : 0;
  told.top.row = states[told.placed_by]->row;
  told.place = "shelves[" + std::to_string(told.top.row) + "]";
  told.place += table == 1 ? ".name" : table == 2 ? ".blob" : ".slips[" + std::to_string(index) + "].label";
  if (has_ids) told.id = (*shelves[told.placed_by])[told.top.row].id;
  while (told.offset < std::min(texts[0]->size(), texts[1]->size()) &&
         (*texts[0])[told.offset] == (*texts[1])[told.offset])
    ++told.offset;
  const std::string& longest = texts[1]->size() >= texts[0]->size() ? *texts[1] : *texts[0];
  told.first = told.offset - std::min<std::uint64_t>(told.offset, 24);
  if (told.is_text) {
    const auto begins = std::count_if(longest.begin(), longest.begin() + static_cast<std::ptrdiff_t>(told.offset),
                                      [](char byte) { return is_first_byte(byte); });
    told.character = static_cast<std::uint64_t>(begins) - (is_first_byte(longest[told.offset]) ? 0 : 1);
    while (told.first < told.offset && !is_first_byte(longest[told.first])) ++told.first;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    told.sides.emplace_back();
    if (states[i] == nullptr) continue;
    std::size_t behind = std::min<std::size_t>(texts[i]->size(), told.offset + 40);
    while (told.is_text && behind > told.offset && behind < texts[i]->size() && !is_first_byte((*texts[i])[behind]))
      --behind;
    std::string bytes = told.first < behind ? texts[i]->substr(told.first, behind - told.first) : "";
    told.sides.back() = ContentSide{std::move(bytes), texts[i]->size()};
  }
  return told;
}

std::vector<ContentDifference> told_of_all(const Shelves& a, const Shelves& b, bool has_ids) {
  std::vector<ContentDifference> all;
  for (const std::size_t table : {1, 2, 4}) {
    const Wholes of_a = wholes_of(a, has_ids, table), of_b = wholes_of(b, has_ids, table);
    Wholes keys = of_a;
    keys.insert(of_b.begin(), of_b.end());
    for (const auto& [key, unused] : keys) {
      const auto in_a = of_a.find(key), in_b = of_b.find(key);
      const Whole* const states[2] = {in_a == of_a.end() ? nullptr : &in_a->second,
                                      in_b == of_b.end() ? nullptr : &in_b->second};
      if (auto told = told_of(table, states, key.second, has_ids, {&a, &b})) all.push_back(std::move(*told));
    }
  }
  return all;
}

TEST_CASE("contents: of two random states, each text and string of bytes that differs is told, and no other",
          "[verifier][contents][property]") {
  std::size_t told_count = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Random random(seed);
    const bool has_ids = seed % 2 == 0;
    const Shelves a = drawn_shelves(random);
    const Shelves b = seed % 5 == 0 ? drawn_shelves(random) : changed_shelves(random, a);
    const ShelfTables of_a(a, has_ids), of_b(b, has_ids);
    const std::span<const ImageTable> states[] = {of_a.tables(), of_b.tables()};
    const std::vector<ContentDifference> expected = told_of_all(a, b, has_ids);
    const std::size_t count_max = seed % 3 == 0 ? 2 : 100;
    const ContentDifferences found = verifier::find_content_differences(of_a.schema(), states, count_max);
    CAPTURE(seed);
    CHECK(found.count == expected.size());
    REQUIRE(found.list.size() == std::min(expected.size(), count_max));
    for (std::size_t i = 0; i < found.list.size(); ++i) {
      const ContentDifference& one = found.list[i];
      const ContentDifference& wanted = expected[i];
      CAPTURE(i, wanted.place);
      CHECK(one.place == wanted.place);
      CHECK(one.table == wanted.table);
      CHECK(one.placed_by == wanted.placed_by);
      CHECK(one.top.row == wanted.top.row);
      CHECK(one.id == wanted.id);
      CHECK(one.is_text == wanted.is_text);
      CHECK(one.offset == wanted.offset);
      CHECK(one.first == wanted.first);
      CHECK(one.character == wanted.character);
      CHECK(one.sides == wanted.sides);
    }
    told_count += expected.size();
  }
  CHECK(told_count > 1'000);
}

/// One row with a row in each of `depth` nested tables, and a text below the last.
Bytes nested_image(std::size_t depth, const std::string& text, StateSchema& schema) {
  GatheredState state;
  const std::uint32_t row = 0;
  const ElementReader one = [](void* user, const void*, std::uint32_t, std::size_t* count) -> const void* {
    *count = 1;
    return user;
  };
  const ElementReader read = [](void* user, const void*, std::uint32_t, std::size_t* count) {
    return elements_of(*static_cast<const std::string*>(user), count);
  };
  REQUIRE(state.column("t0", "value", {&row, ScalarType::u32, 1, 1}));
  for (std::size_t t = 1; t <= depth; ++t)
    REQUIRE(state.child("t" + std::to_string(t), "t" + std::to_string(t - 1),
                        {TableForm::rows, one, const_cast<std::uint32_t*>(&row), 4}, {}));
  REQUIRE(state.child("text", "t" + std::to_string(depth), {TableForm::text, read, const_cast<std::string*>(&text), 1},
                      {}));
  REQUIRE(state.freeze());
  REQUIRE(state.gather());
  schema = state.schema();
  Bytes image;
  encode_image(state.view(), image);
  return image;
}

TEST_CASE("contents: texts are told however deep they are nested", "[verifier][contents][analytic]") {
  for (const std::size_t depth : {1, 3, 62, 63, 64, 65, 66, 70}) {
    CAPTURE(depth);
    StateSchema schema;
    const Bytes a = nested_image(depth, "one", schema), b = nested_image(depth, "own", schema);
    const auto of_a = split_image(schema, a), of_b = split_image(schema, b);
    REQUIRE(of_a);
    REQUIRE(of_b);
    const std::span<const ImageTable> states[] = {*of_a, *of_b};
    const ContentDifferences found = verifier::find_content_differences(schema, states, 10);
    CHECK(found.count == 1);
    REQUIRE(found.list.size() == 1);
    CHECK(found.list[0].table == "text");
    CHECK(found.list[0].offset == 1);
    CHECK(found.list[0].sides[0]->bytes == "one");
    CHECK(found.list[0].sides[1]->bytes == "own");
  }
}

}  // namespace
}  // namespace ticktrue::test
