// Cells computed directly from docs/trace_format.md, section 12. The fast cells must be equal.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "base/random.h"
#include "base/row_kernels.h"
#include "base/state/cells.h"
#include "tests/support/catch.h"
#include "tests/support/toy_simulation.h"

namespace ticktrue::test {
namespace {

using Words = std::vector<std::uint32_t>;

std::uint64_t mix(std::uint64_t h, std::uint64_t w) {
  const std::uint64_t x = (h ^ w) * 0xd6e8feb86659fd93u;
  return x ^ (x >> 32);
}

std::uint64_t chain(std::uint64_t h, const Words& words) {
  std::size_t i = 0;
  for (; i + 1 < words.size(); i += 2) h = mix(h, words[i] | std::uint64_t{words[i + 1]} << 32);
  return i < words.size() ? mix(h, words[i]) : h;
}

/// The rows of a state in the byte order of files, on any machine.
struct FileState {
  explicit FileState(const StateView& state) : schema(*state.schema) {
    encode_image(state, image);
    tables = *split_image(schema, image);
  }
  const StateSchema& schema;
  Bytes image;
  std::vector<ImageTable> tables;
};

/// Words of some columns of a row.
Words words_of(const FileState& state, std::size_t t, std::size_t row, std::size_t first_column,
               std::size_t end_column) {
  const TableSchema& table = state.schema.tables[t];
  Words words;
  for (std::size_t c = first_column; c < end_column; ++c)
    for (std::size_t lane = 0; lane < table.columns[c].lane_count; ++lane) {
      const std::uint64_t bits = lane_bits(table, state.tables[t].rows, {t, row, c, lane});
      words.push_back(static_cast<std::uint32_t>(bits));
      if (scalar_info(table.columns[c].type)->size == 8) words.push_back(static_cast<std::uint32_t>(bits >> 32));
    }
  return words;
}

std::uint32_t column_hash(const FileState& state, std::size_t t, std::size_t c) {
  const std::size_t row_count = state.tables[t].row_count;
  std::vector<Words> rows;
  for (std::size_t row = 0; row < row_count; ++row) rows.push_back(words_of(state, t, row, c, c + 1));
  std::uint64_t h = row_count;
  for (std::size_t word = 0; word < rows[0].size(); ++word) {
    std::uint64_t sum = 0;
    for (std::uint32_t r = 0; r < row_count; r += 2) {
      const std::uint32_t a = rows[r][word] + (r + 1) * 0x9e3779b9u;
      const std::uint32_t b = (r + 1 < row_count ? rows[r + 1][word] : 0) + (r + 2) * 0x9e3779b9u;
      sum += std::uint64_t{a} * b;
    }
    h = mix(h, sum);
  }
  return static_cast<std::uint32_t>(h);
}

StateCells documented_cells(const StateView& view) {
  const FileState state(view);
  const StateSchema& schema = state.schema;
  struct Owner {
    std::size_t table, row;
    std::uint64_t value;
  };
  std::vector<Owner> owners;
  std::uint64_t row_owner_count = 0;
  const auto row_hash = [&](std::size_t t, std::size_t row) {
    return chain(mix(0, ~std::uint64_t{t}), words_of(state, t, row, 0, schema.tables[t].columns.size()));
  };
  StateCells cells;
  for (std::size_t t = 0; t < schema.tables.size(); ++t) {
    const std::uint32_t row_count = state.tables[t].row_count;
    cells.row_counts.push_back(row_count);
    for (std::size_t c = 0; c < schema.tables[t].columns.size(); ++c)
      cells.columns.push_back(row_count > 0 ? column_hash(state, t, c) : 0);
    if (!owns_rows(schema, t)) continue;
    row_owner_count += row_count;
    for (std::size_t row = 0; row < row_count; ++row) owners.push_back({t, row, row_hash(t, row)});
  }
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    for (std::size_t row = 0; !owns_rows(schema, t) && row < state.tables[t].row_count; ++row) {
      bool found = false;
      for (std::size_t c = 0; c < schema.tables[t].columns.size(); ++c) {
        const int target = schema.tables[t].columns[c].target;
        if (target < 0) continue;
        for (const std::uint32_t id : words_of(state, t, row, c, c + 1))
          for (Owner& owner : owners)
            if (owner.table == static_cast<std::size_t>(target) &&
                words_of(state, owner.table, owner.row, 0, 1)[0] == id) {
              owner.value += row_hash(t, row);
              found = true;
            }
      }
      if (!found) owners.push_back({t, row, row_hash(t, row)});
    }
  cells.partition_cells = partition_cells_for(row_owner_count);
  cells.cells.assign(partition_count * cells.partition_cells, 0);
  for (const Owner& owner : owners) {
    const std::size_t key_count = schema.tables[owner.table].key_column_count;
    const Words key_words = words_of(state, owner.table, owner.row, 0, key_count);
    const std::uint64_t key =
        key_words.empty() ? owner.row : (key_words.size() == 1 ? key_words[0] : chain(0, key_words));
    const std::uint64_t v = mix(owner.value, key);
    const std::uint64_t s = mix(mix(mix(0, owner.table + 1), key), 0);
    for (std::size_t p = 0; p < partition_count; ++p) {
      std::uint16_t& cell =
          cells.cells[p * cells.partition_cells + (((s >> 16 * p) & 0xffff) * cells.partition_cells >> 16)];
      cell = static_cast<std::uint16_t>(cell ^ (v >> 16 * p));
    }
  }
  return cells;
}

TEST_CASE("cells: one hasher gives the cells of the document for state after state", "[base][cells][equivalence]") {
  CellHasher hasher(ToySimulation::schema());
  StateCells found;
  const auto check = [&](ToySimulation& toy, const char* what) {
    toy.refresh();
    CAPTURE(what, toy.bodies.size());
    hasher.hash(toy.state(), 0, found);
    CHECK(found == documented_cells(toy.state()));
  };
  // 500 bodies fill several blocks of rows; 3 bodies do not fill one.
  for (const std::uint32_t body_count : {500u, 3u, 40u, 41u}) {
    ToySimulation toy(body_count);
    check(toy, "as made");
    for (ToyLink& link : toy.links) link.body_b = link.body_a;
    check(toy, "both references name one body");
    toy.bodies.erase(toy.bodies.begin() + 1);
    check(toy, "an id with a gap behind it, references to no row");
    toy.bodies.erase(toy.bodies.begin());
    check(toy, "ids that begin later");
    for (ToyLink& link : toy.links) link.body_a = link.body_b = 1'000'000;
    check(toy, "links of nobody");
    for (std::size_t i = 0; i < toy.bodies.size(); ++i) toy.bodies[i].id = static_cast<std::uint32_t>(7 + 3 * i);
    check(toy, "ids far apart");
    std::reverse(toy.bodies.begin(), toy.bodies.end());
    check(toy, "ids in another order");
    toy.links.clear();
    check(toy, "no link");
    toy.bodies.clear();
    check(toy, "no body");
  }
}

TEST_CASE("cells: of many tables, those that did not change are not hashed again, with the same result",
          "[base][cells][equivalence]") {
  constexpr std::size_t table_count = 90;
  StateSchema schema;
  for (std::size_t t = 0; t < table_count; ++t) {
    TableSchema table{"t" + std::to_string(t), {}, 12, 0};
    Column id, value, small;
    id.name = "id";
    value.name = "value";
    value.offset = 4;
    small.name = "small";
    small.type = ScalarType::u16;
    small.lane_count = 2;
    small.offset = 8;
    if (t < 3 || t % 10 == 7) table.key_column_count = 1;
    if (t % 10 == 5) id.target = static_cast<std::int16_t>(t % 3);  // rows of other tables refer to tables 0..2
    table.columns = {id, value, small};
    schema.tables.push_back(table);
  }
  REQUIRE(check_schema(schema, SchemaLayout::third));
  Random random(3);
  std::vector<std::vector<std::uint32_t>> rows(table_count);
  CellHasher hasher(schema);
  StateCells found;
  std::uint32_t cells_before = 0;
  for (int tick = 0; tick < 400; ++tick) {
    CAPTURE(tick);
    for (std::uint64_t change = random.below(4); change > 0; --change) {
      const std::size_t t = random.below(random.below(3) == 0 ? 6 : table_count);
      std::vector<std::uint32_t>& words = rows[t];
      const std::uint64_t kind = random.below(10);
      // Some tables grow by many rows, so that the number of cells changes.
      for (std::uint64_t more = kind == 0 ? random.below(60) : kind < 4 ? 1 : 0; more > 0; --more)
        for (int word = 0; word < 3; ++word)
          words.push_back(word == 0 ? static_cast<std::uint32_t>(words.size()) : static_cast<std::uint32_t>(tick));
      if (kind == 4) words.clear();
      if (kind < 5 || words.empty()) continue;
      const std::size_t at = 3 * random.below(words.size() / 3);
      if (kind == 5 && t >= 3)
        words.erase(words.begin() + static_cast<std::ptrdiff_t>(at),
                    words.begin() + static_cast<std::ptrdiff_t>(at + 3));
      else if (kind == 6 && t >= 3)
        words[at] += 1'000;  // another key, where the table has one
      else
        words[at + 1] = static_cast<std::uint32_t>(tick);
    }
    StateView view{&schema, {}};
    for (const std::vector<std::uint32_t>& words : rows)
      view.tables.push_back(
          {reinterpret_cast<const std::uint8_t*>(words.data()), static_cast<std::uint32_t>(words.size() / 3)});
    hasher.hash(view, 0, found);
    const StateCells expected = documented_cells(view);
    REQUIRE(found == expected);
    // Tables 0..2 and their owned rows are always hashed. Of the other tables, only changed ones are hashed.
    if (found.partition_cells == cells_before) CHECK(hasher.hashed_table_count() <= 3 + table_count / 10 + 4);
    cells_before = found.partition_cells;
    StateCells other;
    if (random.below(8) == 0) {
      hasher.hash(view, 50, other);
      CHECK(other.columns == expected.columns);
      cells_before = 50;
    }
    if (random.below(8) == 0 && !rows[5].empty()) CHECK(!hasher.owners_of(view, 5, 0).empty());
    if (random.below(8) == 0) CHECK(hasher.owners(view).size() <= 10'000);
  }
}

TEST_CASE("cells: rows of one to three words, in several blocks, have the hashes of the document",
          "[base][cells][equivalence]") {
  std::vector<std::uint32_t> words(3 * 5'001);
  for (std::uint32_t i = 0; i < words.size(); ++i) words[i] = static_cast<std::uint32_t>(mix(i, 5));
  for (std::uint32_t word_count = 1; word_count <= 3; ++word_count) {
    StateSchema schema;
    schema.tables.push_back({"samples", {}, 4 * word_count, 0});
    for (std::uint32_t word = 0; word < word_count; ++word) {
      Column column;
      column.name = std::string(1, static_cast<char>('a' + word));
      column.offset = static_cast<std::uint16_t>(4 * word);
      schema.tables[0].columns.push_back(column);
    }
    StateView view{&schema, {{reinterpret_cast<const std::uint8_t*>(words.data()), 5'001}}};
    StateCells found;
    CellHasher(schema).hash(view, 0, found);
    CHECK(found == documented_cells(view));
  }
}

TEST_CASE("the row kernels of every instruction set give the same", "[base][hash][cells][equivalence]") {
  std::vector<std::uint32_t> words(3'000);
  std::uint64_t state = 1;
  for (std::uint32_t& word : words) word = static_cast<std::uint32_t>(mix(state++, 17));
  const RowKernels& baseline = *all_row_kernels().front();
  for (const RowKernels* kernels : all_row_kernels())
    for (std::size_t word_count = 4; word_count < 40; ++word_count)
      for (const std::size_t row_count : {1u, 2u, 7u, 8u}) {
        CAPTURE(word_count, row_count);
        std::vector<std::uint64_t> expected(word_count), sums(word_count);
        baseline.sum_products(words.data(), word_count, 6, row_count, expected.data());
        kernels->sum_products(words.data(), word_count, 6, row_count, sums.data());
        CHECK(sums == expected);
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(words.data());
        for (const std::size_t size : {std::size_t{0}, word_count, 100 * word_count})
          CHECK(kernels->hash(bytes, size, row_count) == baseline.hash(bytes, size, row_count));
        // The mask matches a single word at every position.
        for (std::size_t at = 0; at < word_count; ++at) {
          std::vector<std::uint32_t> mask(word_count), want(word_count, 1);
          mask[at] = 0xffffff00u;
          want[at] = words[(row_count - 1) * word_count + at] & mask[at];
          CHECK(kernels->any_match(bytes, word_count, row_count, mask.data(), want.data()));
          CHECK((row_count == 1 || !kernels->any_match(bytes, word_count, row_count - 1, mask.data(), want.data())));
        }
      }
}

#if defined(__x86_64__) && defined(__SSE2__)
/// Whether the upper halves of the wide registers are zero.
[[gnu::noinline, gnu::target("avx")]] bool are_upper_halves_zero() {
  alignas(32) std::array<std::uint64_t, 64> words;
  asm volatile(
      "vmovdqa %%ymm0, 0(%0)\n vmovdqa %%ymm1, 32(%0)\n vmovdqa %%ymm2, 64(%0)\n vmovdqa %%ymm3, 96(%0)\n"
      "vmovdqa %%ymm4, 128(%0)\n vmovdqa %%ymm5, 160(%0)\n vmovdqa %%ymm6, 192(%0)\n vmovdqa %%ymm7, 224(%0)\n"
      "vmovdqa %%ymm8, 256(%0)\n vmovdqa %%ymm9, 288(%0)\n vmovdqa %%ymm10, 320(%0)\n vmovdqa %%ymm11, 352(%0)\n"
      "vmovdqa %%ymm12, 384(%0)\n vmovdqa %%ymm13, 416(%0)\n vmovdqa %%ymm14, 448(%0)\n vmovdqa %%ymm15, 480(%0)"
      :
      : "r"(words.data())
      : "memory");
  std::uint64_t any = 0;
  for (std::size_t at = 0; at < words.size(); at += 4) any |= words[at + 2] | words[at + 3];
  return any == 0;
}

// Code without AVX runs up to four times slower behind a kernel that leaves something there.
TEST_CASE("the row kernels leave nothing in the upper halves of wide registers", "[base][hash][cells]") {
  if (!__builtin_cpu_supports("avx2")) return;
  std::vector<std::uint32_t> words(3'000, 0x12345678u);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(words.data());
  std::vector<std::uint64_t> sums(40);
  const std::vector<std::uint32_t> mask(40, 1), want(40, 1);
  for (const RowKernels* kernels : all_row_kernels())
    for (std::size_t word_count = 4; word_count < 40; ++word_count) {
      CAPTURE(word_count);
      asm volatile("vzeroupper" ::
                       : "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8", "xmm9", "xmm10",
                         "xmm11", "xmm12", "xmm13", "xmm14", "xmm15");
      kernels->sum_products(words.data(), word_count, 6, 8, sums.data());
      const bool after_sums = are_upper_halves_zero();
      kernels->any_match(bytes, word_count, 8, mask.data(), want.data());
      const bool after_match = are_upper_halves_zero();
      kernels->hash(bytes, 100 * word_count, 1);
      const bool after_hash = are_upper_halves_zero();
      alignas(64) std::array<std::uint8_t, 1024> hash_state;
      std::uint64_t high, low;
      kernels->start128(hash_state.data(), hash_state.size());
      kernels->add128(hash_state.data(), bytes, 200 * word_count);
      kernels->value128(hash_state.data(), &high, &low);
      const bool after_hash128 = are_upper_halves_zero();
      CHECK(after_hash128);
      CHECK(after_sums);
      CHECK(after_match);
      CHECK(after_hash);
    }
}
#endif

}  // namespace
}  // namespace ticktrue::test
