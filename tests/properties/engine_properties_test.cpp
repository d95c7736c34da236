// What must hold for every scene, solver, precision and broad phase: same bits, whatever is not state.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "base/hash.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"

namespace ticktrue::test {
namespace {

constexpr std::uint64_t tick_count = 240;

class CountingObserver : public StageObserver {
 public:
  void after_stage(std::size_t stage, const StateView& state) override {
    stages.push_back(stage);
    hashes.push_back(root_hash(state));
  }
  std::vector<std::size_t> stages;
  std::vector<std::uint64_t> hashes;
};

}  // namespace

TEST_CASE("the same session gives the same bits again", "[properties][engine][determinism]") {
  for (const Session& session : property_sessions()) {
    CAPTURE(session.name);
    const std::vector<std::uint64_t> hashes = tick_hashes(session, tick_count);
    CHECK(tick_hashes(session, tick_count) == hashes);
    CHECK(hashes.front() != hashes.back());
  }
}

TEST_CASE("every broad phase gives the same bits", "[properties][engine][broad_phase][equivalence]") {
  for (const Session& session : property_sessions()) {
    const std::vector<std::uint64_t> expected =
        tick_hashes(session, tick_count, {false, engine::BroadPhaseKind::brute_force});
    for (const auto& info : engine::broad_phases) {
      CAPTURE(session.name, info.name);
      CHECK(tick_hashes(session, tick_count, {false, info.kind}) == expected);
    }
  }
}

TEST_CASE("an engine restored at any tick runs on with the same bits", "[properties][engine][restore][determinism]") {
  for (const Session& session : property_sessions()) {
    const std::vector<std::uint64_t> expected = tick_hashes(session, tick_count);
    const auto original = make_engine_or_fail(session.scene);
    for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
      if (tick % 37 == 5) {
        CAPTURE(session.name, tick);
        const auto restored = make_engine_or_fail(session.scene);
        // What the restored engine did before must leave no trace in what it does next.
        for (std::uint64_t other = 0; other < 3; ++other) restored->step(input_of(session, other), nullptr);
        const Bytes image = image_of(*original);
        const Status loaded = restored->load(image);
        INFO((loaded ? "" : loaded.error().message));
        REQUIRE(loaded.has_value());
        CHECK(image_of(*restored) == image);
        std::vector<std::uint64_t> hashes;
        for (std::uint64_t later = tick; later < tick_count; ++later) {
          restored->step(input_of(session, later), nullptr);
          hashes.push_back(root_hash(restored->state()));
        }
        CHECK(std::equal(hashes.begin(), hashes.end(), expected.begin() + static_cast<std::ptrdiff_t>(tick)));
      }
      original->step(input_of(session, tick), nullptr);
    }
  }
}

TEST_CASE("an observer sees every stage and changes no bit", "[properties][engine][determinism]") {
  for (const Session& session : property_sessions()) {
    CAPTURE(session.name);
    const std::vector<std::uint64_t> expected = tick_hashes(session, 60);
    const auto engine = make_engine_or_fail(session.scene);
    for (std::uint64_t tick = 0; tick < 60; ++tick) {
      CountingObserver observer;
      engine->step(input_of(session, tick), &observer);
      REQUIRE(observer.stages.size() == engine->stage_names().size());
      for (std::size_t i = 0; i < observer.stages.size(); ++i) CHECK(observer.stages[i] == i);
      CHECK(root_hash(engine->state()) == expected[tick]);
      CHECK(observer.hashes.back() == expected[tick]);
    }
  }
}

TEST_CASE("a forced full pipeline changes no bit of the columns both have",
          "[properties][engine][pipeline][equivalence]") {
  for (const Session& session : property_sessions()) {
    CAPTURE(session.name);
    const auto composed = make_engine_or_fail(session.scene);
    const auto full = make_engine_or_fail(session.scene, {true, {}});
    CHECK(full->stage_names().size() >= composed->stage_names().size());
    for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
      composed->step(input_of(session, tick), nullptr);
      full->step(input_of(session, tick), nullptr);
      const StateView& a = composed->state();
      const StateView& b = full->state();
      for (std::size_t table = 0; table < a.schema->tables.size(); ++table) {
        const auto other = b.schema->find_table(a.schema->tables[table].name);
        REQUIRE(other.has_value());
        REQUIRE(a.schema->tables[table] == b.schema->tables[*other]);
        REQUIRE(a.tables[table].row_count == b.tables[*other].row_count);
        const std::size_t size = static_cast<std::size_t>(a.tables[table].row_count) * a.schema->tables[table].row_size;
        const bool same = std::equal(a.tables[table].data, a.tables[table].data + size, b.tables[*other].data);
        CAPTURE(tick, a.schema->tables[table].name);
        REQUIRE(same);
      }
    }
  }
}

TEST_CASE("every lane of every column is covered by the root hash", "[properties][engine][hash]") {
  for (const Session& session : property_sessions()) {
    const auto engine = make_engine_or_fail(session.scene);
    for (std::uint64_t tick = 0; tick < 120; ++tick) engine->step(input_of(session, tick), nullptr);
    const StateView& state = engine->state();
    const std::uint64_t expected = root_hash(state);
    for (std::size_t t = 0; t < state.tables.size(); ++t) {
      const TableSchema& table = state.schema->tables[t];
      if (state.tables[t].row_count == 0) continue;
      Bytes rows(state.tables[t].data,
                 state.tables[t].data + static_cast<std::size_t>(state.tables[t].row_count) * table.row_size);
      for (std::size_t byte = 0; byte < rows.size(); byte += 1 + byte / table.row_size) {
        rows[byte] ^= 0x10;
        StateView changed = state;
        changed.tables[t].data = rows.data();
        CAPTURE(session.name, table.name, byte);
        CHECK(root_hash(changed) != expected);
        rows[byte] ^= 0x10;
      }
    }
  }
}

TEST_CASE("images with values out of range are refused and change nothing",
          "[properties][engine][restore][corruption]") {
  for (const Session& session : property_sessions()) {
    const auto engine = make_engine_or_fail(session.scene);
    for (std::uint64_t tick = 0; tick < 120; ++tick) engine->step(input_of(session, tick), nullptr);
    const Bytes image = image_of(*engine);
    const auto tables = split_image(*engine->state().schema, image);
    REQUIRE(tables.has_value());
    for (std::size_t t = 0; t < tables->size(); ++t) {
      const TableSchema& table = engine->state().schema->tables[t];
      if ((*tables)[t].row_count == 0) continue;
      for (const Column& column : table.columns) {
        const bool anything_goes =
            column.max >= 4294967295.0 && column.type != ScalarType::f32 && column.type != ScalarType::f64;
        if (anything_goes) continue;
        // All bits set: a NaN, or an integer beyond every range.
        Bytes bad = image;
        const std::size_t at = static_cast<std::size_t>((*tables)[t].rows.data() - image.data()) + column.offset;
        for (std::size_t i = 0; i < scalar_info(column.type)->size; ++i) bad[at + i] = 0xff;
        CAPTURE(session.name, table.name, column.name);
        const Status status = engine->load(bad);
        CHECK_FALSE(status.has_value());
        if (!status) CHECK(status.error().code == ErrorCode::corrupt);
        CHECK(image_of(*engine) == image);
      }
    }
    for (std::size_t size = 0; size < image.size(); size += 1 + size / 8)
      CHECK_FALSE(engine->load(ByteView(image).first(size)).has_value());
    Bytes longer = image;
    longer.push_back(0);
    CHECK_FALSE(engine->load(longer).has_value());
  }
}

}  // namespace ticktrue::test
