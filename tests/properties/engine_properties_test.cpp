// Properties of every scene, solver, precision and broad phase: anything that is not state changes no bit.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstring>
#include <limits>
#include <set>

#include "base/bytes.h"
#include "base/hash.h"
#include "base/random.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"

namespace ticktrue::test {
namespace {

constexpr std::uint64_t whole_run = 240;  // ticks
#if defined(__SANITIZE_ADDRESS__)
constexpr std::uint64_t tick_count = 80;  // each tick costs twenty times as much
#else
constexpr std::uint64_t tick_count = whole_run;
#endif

class CountingObserver : public StageObserver {
 public:
  void after_stage(std::size_t stage, const StateView& state) override {
    stages.push_back(stage);
    hashes.push_back(root_hash(state));
  }
  std::vector<std::size_t> stages;
  std::vector<std::uint64_t> hashes;
};

/// Restores new engines from images of 50 ticks and compares the next ticks. The first engine runs to the end.
void check_restores(const Session& session, std::uint64_t end) {
  constexpr std::uint64_t ticks_compared = 20;
  const std::vector<std::uint64_t> expected = tick_hashes(session, end);
  const auto original = make_engine_or_fail(session.scene);
  Random random(end);
  bool is_first = true;
  for (std::uint64_t tick = 0; tick < end; ++tick) {
    if (tick == 0 || random.below(end) < 50) {
      CAPTURE(session.name, tick);
      const auto restored = make_engine_or_fail(session.scene);
      // The earlier ticks of the restored engine must not influence its next ticks.
      for (std::uint64_t other = 0; other < 2; ++other) REQUIRE(restored->step(input_of(session, other), nullptr));
      const Bytes image = image_of(*original);
      const Status loaded = restored->load(image);
      INFO((loaded ? "" : loaded.error().message));
      REQUIRE(loaded.has_value());
      CHECK(image_of(*restored) == image);
      std::vector<std::uint64_t> hashes;
      for (std::uint64_t later = tick; later < end && (is_first || later < tick + ticks_compared); ++later) {
        REQUIRE(restored->step(input_of(session, later), nullptr));
        hashes.push_back(root_hash(restored->state()));
      }
      CHECK(std::equal(hashes.begin(), hashes.end(), expected.begin() + static_cast<std::ptrdiff_t>(tick)));
      is_first = false;
    }
    REQUIRE(original->step(input_of(session, tick), nullptr));
  }
}

void check_broad_phases(const Session& session, std::uint64_t end) {
  const std::vector<std::uint64_t> expected = tick_hashes(session, end, {false, engine::BroadPhaseKind::brute_force});
  for (const auto& info : engine::broad_phases) {
    CAPTURE(session.name, info.name);
    CHECK(tick_hashes(session, end, {false, info.kind}) == expected);
  }
}

/// Checks that the tables which both states have are equal byte by byte.
void check_shared_tables(const StateView& a, const StateView& b) {
  for (std::size_t table = 0; table < a.schema->tables.size(); ++table) {
    const auto other = b.schema->find_table(a.schema->tables[table].name);
    REQUIRE(other.has_value());
    REQUIRE(a.schema->tables[table] == b.schema->tables[*other]);
    REQUIRE(a.tables[table].row_count == b.tables[*other].row_count);
    const std::size_t size = static_cast<std::size_t>(a.tables[table].row_count) * a.schema->tables[table].row_size;
    const bool same = std::equal(a.tables[table].data, a.tables[table].data + size, b.tables[*other].data);
    CAPTURE(a.schema->tables[table].name);
    REQUIRE(same);
  }
}

void check_full_pipeline(const Session& session, std::uint64_t end) {
  const auto composed = make_engine_or_fail(session.scene);
  const auto full = make_engine_or_fail(session.scene, {true, {}});
  CHECK(full->stage_names().size() >= composed->stage_names().size());
  for (std::uint64_t tick = 0; tick < end; ++tick) {
    CAPTURE(session.name, tick);
    REQUIRE(composed->step(input_of(session, tick), nullptr));
    REQUIRE(full->step(input_of(session, tick), nullptr));
    check_shared_tables(composed->state(), full->state());
  }
}

/// Runs 120 ticks. If the scene has a pointer, continues until the pointer holds a body.
void run_until_rich(engine::Engine& engine, const Session& session) {
  const auto pointers = engine.state().schema->find_table("pointers");
  for (std::uint64_t tick = 0; tick < 400; ++tick) {
    const bool is_poor = pointers && engine.state().tables[*pointers].row_count == 0;
    if (tick >= 120 && !is_poor) return;
    REQUIRE(engine.step(input_of(session, tick), nullptr));
  }
}

/// The image with one lane of one row replaced.
Bytes with_lane(const Bytes& image, const ImageTable& rows, const TableSchema& table, std::size_t row,
                const Column& column, std::size_t lane, std::uint64_t bits) {
  Bytes changed = image;
  const std::size_t size = scalar_info(column.type)->size;
  const auto start = static_cast<std::size_t>(rows.rows.data() - image.data());
  for (std::size_t i = 0; i < size; ++i)
    changed[start + row * table.row_size + column.offset + lane * size + i] =
        static_cast<std::uint8_t>(bits >> (8 * i));
  return changed;
}

bool is_real(ScalarType type) {
  return type == ScalarType::f32 || type == ScalarType::f64;
}
std::uint64_t real_bits(ScalarType type, double value) {
  return type == ScalarType::f32 ? bits_of(static_cast<float>(value)) : bits_of(value);
}

/// Values just outside the range of a column, and NaN.
std::vector<std::uint64_t> bad_values(const Column& column) {
  std::vector<std::uint64_t> bad;
  if (is_real(column.type)) {
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double value : {infinity, -infinity, std::numeric_limits<double>::quiet_NaN()})
      bad.push_back(real_bits(column.type, value));
    if (column.max < infinity) bad.push_back(real_bits(column.type, column.max * 1.001 + 0.001));
    if (column.min > -infinity) bad.push_back(real_bits(column.type, column.min - 0.001));
    return bad;
  }
  if (column.optional) return {static_cast<std::uint64_t>(column.max)};  // an id of no body; the next is "none"
  if (column.max < 4294967295.0) bad.push_back(static_cast<std::uint64_t>(column.max) + 1);
  if (column.min > 0) bad.push_back(static_cast<std::uint64_t>(column.min) - 1);
  return bad;
}

/// Values within a column's range that a run hardly produces.
std::vector<std::uint64_t> odd_values(const Column& column) {
  std::vector<std::uint64_t> odd;
  const double huge = column.type == ScalarType::f32 ? 3e38 : 1e300;
  if (is_real(column.type)) {
    for (const double value : {0.0, -1.0, 1e-30, 1e9, huge, -huge}) odd.push_back(real_bits(column.type, value));
    return odd;
  }
  for (const double value : {0.0, 1.0, 2.0, column.min, column.max / 2, column.max})
    odd.push_back(static_cast<std::uint64_t>(value));
  return odd;
}

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
  for (const Session& session : property_sessions()) check_broad_phases(session, tick_count);
}

TEST_CASE("an engine restored at any of 50 ticks runs on with the same bits",
          "[properties][engine][restore][determinism]") {
  for (const Session& session : property_sessions()) check_restores(session, tick_count);
}

TEST_CASE("an observer sees every stage and changes no bit", "[properties][engine][determinism]") {
  for (const Session& session : property_sessions()) {
    CAPTURE(session.name);
    const std::vector<std::uint64_t> expected = tick_hashes(session, 60);
    const auto engine = make_engine_or_fail(session.scene);
    for (std::uint64_t tick = 0; tick < 60; ++tick) {
      CountingObserver observer;
      REQUIRE(engine->step(input_of(session, tick), &observer));
      REQUIRE(observer.stages.size() == engine->stage_names().size());
      for (std::size_t i = 0; i < observer.stages.size(); ++i) CHECK(observer.stages[i] == i);
      CHECK(root_hash(engine->state()) == expected[tick]);
      CHECK(observer.hashes.back() == expected[tick]);
    }
  }
}

TEST_CASE("a forced full pipeline changes no bit of the columns both have",
          "[properties][engine][pipeline][equivalence]") {
  for (const Session& session : property_sessions()) check_full_pipeline(session, tick_count);
}

TEST_CASE("golden scenes give the same bits under every broad phase, full pipeline, and restored",
          "[properties][engine][golden][equivalence]") {
  const std::vector<GoldenSession> sessions = golden_sessions();
  CHECK(sessions.size() >= 22);
  for (const GoldenSession& golden : sessions) {
    check_broad_phases(golden.session, golden.tick_count);
    check_full_pipeline(golden.session, golden.tick_count);
    check_restores(golden.session, golden.tick_count);
  }
}

TEST_CASE("the sessions use every table, and leave none of them empty", "[properties][engine][pipeline]") {
  std::set<std::string> seen;
  std::uint64_t asleep = 0, woken = 0;
  std::set<std::uint32_t> substeps;
  for (const Session& session : property_sessions()) {
    const auto engine = make_engine_or_fail(session.scene);
    std::vector<std::uint32_t> slept;
    for (std::uint64_t tick = 0; tick < whole_run; ++tick) {
      REQUIRE(engine->step(input_of(session, tick), nullptr));
      const StateView& state = engine->state();
      for (std::size_t t = 0; t < state.tables.size(); ++t) {
        const TableSchema& table = state.schema->tables[t];
        if (state.tables[t].row_count > 0) seen.insert(table.name);
        const auto value = [&](std::size_t row, std::size_t column) {
          std::uint32_t bits;
          std::memcpy(&bits, state.tables[t].data + row * table.row_size + table.columns[column].offset, 4);
          return bits;
        };
        if (table.name == "sleep") {
          std::vector<std::uint32_t> now;
          for (std::size_t row = 0; row < state.tables[t].row_count; ++row)
            if (value(row, 1) != 0) now.push_back(value(row, 0));
          asleep += now.size();
          for (const std::uint32_t body : slept) woken += std::find(now.begin(), now.end(), body) == now.end();
          slept = now;
        }
        if (table.name == "substeps")
          for (std::size_t row = 0; row < state.tables[t].row_count; ++row) substeps.insert(value(row, 1));
      }
    }
  }
  CHECK(seen == std::set<std::string>{"accelerations", "bodies", "budget", "contacts", "events", "gears", "integrator",
                                      "joints", "loads", "pointers", "sensors", "sleep", "substeps", "touching",
                                      "world"});
  CHECK(asleep > 1000);
  CHECK(woken > 5);
  CHECK(substeps.size() >= 4);
}

TEST_CASE("every lane of every column is covered by the root hash", "[properties][engine][hash]") {
  for (const Session& session : property_sessions()) {
    const auto engine = make_engine_or_fail(session.scene);
    run_until_rich(*engine, session);
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

TEST_CASE("a change of any lane of any column is one difference, at its place", "[properties][engine][diff]") {
  for (const Session& session : property_sessions()) {
    const auto engine = make_engine_or_fail(session.scene);
    run_until_rich(*engine, session);
    const StateSchema& schema = *engine->state().schema;
    const Bytes image = image_of(*engine);
    const auto expected = split_image(schema, image);
    REQUIRE(expected.has_value());
    for (std::size_t t = 0; t < expected->size(); ++t) {
      const TableSchema& table = schema.tables[t];
      if ((*expected)[t].row_count == 0) continue;
      const std::size_t row = (*expected)[t].row_count - 1;
      for (std::size_t c = table.key_column_count; c < table.columns.size(); ++c)
        for (std::size_t lane = 0; lane < table.columns[c].lane_count; ++lane) {
          const Bytes changed = with_lane(image, (*expected)[t], table, row, table.columns[c], lane, 0x3f123457);
          const auto found = split_image(schema, changed);
          REQUIRE(found.has_value());
          const std::vector<LaneDifference> differences = diff_images(schema, *expected, *found, 10);
          CAPTURE(session.name, table.name, table.columns[c].name, lane);
          REQUIRE(differences.size() == 1);
          CHECK(differences[0].place.table == t);
          CHECK(differences[0].place.column == c);
          CHECK(differences[0].place.lane == lane);
        }
    }
  }
}

TEST_CASE("images with values out of range are refused and change nothing",
          "[properties][engine][restore][corruption]") {
  std::set<std::string> tried, triable;
  for (const Session& session : property_sessions()) {
    const auto engine = make_engine_or_fail(session.scene);
    run_until_rich(*engine, session);
    const Bytes image = image_of(*engine);
    const auto tables = split_image(*engine->state().schema, image);
    REQUIRE(tables.has_value());
    for (std::size_t t = 0; t < tables->size(); ++t) {
      const TableSchema& table = engine->state().schema->tables[t];
      for (const Column& column : table.columns)
        if (!bad_values(column).empty()) triable.insert(table.name + "." + column.name);
      if ((*tables)[t].row_count == 0) continue;
      for (const Column& column : table.columns)
        for (std::size_t lane = 0; lane < column.lane_count; ++lane)
          for (const std::size_t row : {std::size_t{0}, (*tables)[t].row_count - std::size_t{1}})
            for (const std::uint64_t bits : bad_values(column)) {
              CAPTURE(session.name, table.name, row, column.name, lane, bits);
              const Status status = engine->load(with_lane(image, (*tables)[t], table, row, column, lane, bits));
              CHECK_FALSE(status.has_value());
              if (!status) CHECK(status.error().code == ErrorCode::corrupt);
              CHECK(image_of(*engine) == image);
              tried.insert(table.name + "." + column.name);
            }
    }
    for (std::size_t size = 0; size < image.size(); size += 1 + size / 8)
      CHECK_FALSE(engine->load(ByteView(image).first(size)).has_value());
    Bytes longer = image;
    longer.push_back(0);
    CHECK_FALSE(engine->load(longer).has_value());
  }
  CHECK(tried == triable);
}

TEST_CASE("images with odd values in range are refused or run on", "[properties][engine][restore][corruption]") {
  for (const Session& session : property_sessions()) {
    const auto engine = make_engine_or_fail(session.scene);
    run_until_rich(*engine, session);
    const Bytes image = image_of(*engine);
    const auto tables = split_image(*engine->state().schema, image);
    REQUIRE(tables.has_value());
    for (std::size_t t = 0; t < tables->size(); ++t) {
      const TableSchema& table = engine->state().schema->tables[t];
      if ((*tables)[t].row_count == 0) continue;
      for (const Column& column : table.columns)
        for (const std::uint64_t bits : odd_values(column)) {
          CAPTURE(session.name, table.name, column.name, bits);
          const std::size_t row = (*tables)[t].row_count / 2;
          const std::size_t lane = column.lane_count - std::size_t{1};
          const Status status = engine->load(with_lane(image, (*tables)[t], table, row, column, lane, bits));
          if (!status) {
            CHECK(status.error().code == ErrorCode::corrupt);
            continue;
          }
          // Without inputs, because accept decides which inputs an odd state takes.
          for (int tick = 0; tick < 3; ++tick)
            if (engine->accept({session.scene.settings.dt, {}}))
              REQUIRE(engine->step({session.scene.settings.dt, {}}, nullptr));
        }
    }
  }
}

}  // namespace ticktrue::test
