// What cells name: columns exactly, rows by a short list that never leaves out one that differs.
// SPDX-License-Identifier: MIT
#include "verifier/locate/locate_cells.h"

#include <nlohmann/json.hpp>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"
#include "tool/session/session.h"
#include "verifier/compare/diff.h"
#include "verifier/inject/inject.h"

namespace ticktrue::test {
namespace {

using verifier::Candidate;
using verifier::Divergence;
using verifier::InjectOptions;
using verifier::InjectReport;
using verifier::InjectRow;
using verifier::Report;
using verifier::Verdict;

replay::TraceSetup cells_toy_setup(std::uint32_t body_count) {
  replay::TraceSetup setup = toy_setup(body_count);
  setup.detail = replay::Detail::cells;
  return setup;
}

bool names(const Divergence& divergence, const std::string& table, std::uint64_t row) {
  return std::any_of(divergence.candidates.begin(), divergence.candidates.end(),
                     [&](const Candidate& candidate) { return candidate.table == table && candidate.row == row; });
}

InjectReport inject_into(ByteView trace, const SimulationInfo& info, const InjectOptions& wanted) {
  replay::TraceReader reader = open_trace(trace);
  InjectOptions options = wanted;
  options.simulation = &info;
  Result<InjectReport> report = verifier::inject(reader, options);
  if (!report) FAIL(report.error().message);
  return std::move(*report);
}

void require_all_found(const InjectReport& report) {
  for (const InjectRow& row : report.rows) {
    CAPTURE(row.index, row.reason, row.place.table, row.place.column, row.place.row, row.bit);
    CHECK(row.outcome == InjectRow::Outcome::found);
    CHECK(row.cells_required);
  }
}

TEST_CASE("locate: cells name columns, bodies, row counts and spread of a divergence", "[verifier][cells][analytic]") {
  const Bytes trace = toy_trace_with(cells_toy_setup(30), 60, 0);
  injected = {20, ToySimulation::move_stage, [](ToySimulation& toy) {
                toy.bodies[4].hits += 1;
                toy.bodies[9].velocity[1] += 1;
              }};
  const Report report = verify_bytes(trace, faulty_info);
  REQUIRE(report.verdict == Verdict::diverged);
  const Divergence& found = *report.divergence;
  CHECK(found.tick == 20);
  CHECK(found.from_cells);
  REQUIRE(found.tables.size() == 1);
  CHECK(found.tables[0].table == "bodies");
  CHECK(found.tables[0].columns == std::vector<std::string>{"velocity", "hits"});
  CHECK(names(found, "bodies", 4));
  CHECK(names(found, "bodies", 9));
  CHECK(found.candidate_count <= 4);
  CHECK(found.unexplained_cells == 0);
  REQUIRE(!found.spread.empty());
  CHECK(found.spread[0].tick == 21);
  CHECK(found.spread[0].row_count >= 2);

  const std::string text = verifier::report_text(report);
  CAPTURE(text);
  CHECK(contains(text, "bodies.velocity, bodies.hits"));
  CHECK(contains(text, "name \"toy_5\""));
  CHECK(contains(text, "spread"));
  CHECK(contains(text, "ticktrue record toy.ttr --ticks 21 --detail full:20..20"));
  const auto json = nlohmann::json::parse(verifier::report_json({&report, 1}, false));
  CHECK(json["divergence"]["cells"]["candidate_count"] == found.candidate_count);
  CHECK(json["divergence"]["columns"][0] == "velocity");
  CHECK(json["divergence"]["spread"][0]["tick"] == 21);
}

TEST_CASE("locate: a row only one side has is told by the counts, and by its row before the tick",
          "[verifier][cells][analytic]") {
  const Bytes trace = toy_trace_with(cells_toy_setup(30), 12, 0);
  injected = {4, ToySimulation::move_stage, [](ToySimulation& toy) { toy.bodies.erase(toy.bodies.begin() + 29); }};
  const Report report = verify_bytes(trace, faulty_info);
  REQUIRE(report.divergence);
  REQUIRE(report.divergence->row_counts.size() == 1);
  CHECK(report.divergence->row_counts[0].table == "bodies");
  CHECK(report.divergence->row_counts[0].expected == report.divergence->row_counts[0].got + 1);
  CHECK(report.divergence->unexplained_cells == 0);
  CHECK(names(*report.divergence, "bodies", 29));
  CHECK(report.divergence->candidate_count <= 4);  // with bodies that its links refer to
}

TEST_CASE("locate: a row under another key is told once, and nothing else for its old cells",
          "[verifier][cells][analytic]") {
  const Bytes trace = toy_trace_with(cells_toy_setup(300), 12, 0);
  injected = {4, ToySimulation::move_stage, [](ToySimulation& toy) { toy.bodies.back().id = 5'000; }};
  const Report report = verify_bytes(trace, faulty_info);
  REQUIRE(report.divergence);
  CHECK(report.divergence->candidate_count == 1);
  CHECK(names(*report.divergence, "bodies", report.divergence->owner_count - 2));  // behind the world's row
  CHECK(report.divergence->unexplained_cells == 0);
  CHECK(!report.divergence->healed);
}

TEST_CASE("locate: where most cells differ, one that stays as it was hides nobody", "[verifier][cells][analytic]") {
  ToySimulation toy(1'000);
  CellHasher hasher(ToySimulation::schema());
  StateCells before;
  hasher.hash(toy.state(), 0, before);
  const std::vector<CellOwner> owners = hasher.owners(toy.state());
  StateCells after = before;
  for (std::uint16_t& cell : after.cells) cell = static_cast<std::uint16_t>(cell ^ 1);
  for (std::size_t same = 0; same < after.cells.size(); ++same) {
    after.cells[same] = before.cells[same];
    CHECK(verifier::find_candidates(before, after, owners).candidates.size() == owners.size());
    after.cells[same] = static_cast<std::uint16_t>(before.cells[same] ^ 1);
  }
}

TEST_CASE("locate: rows in another order are told as such", "[verifier][cells][analytic]") {
  const Bytes trace = toy_trace_with(cells_toy_setup(30), 12, 0);
  injected = {4, ToySimulation::move_stage, [](ToySimulation& toy) { std::swap(toy.links[0], toy.links[1]); }};
  const Report report = verify_bytes(trace, faulty_info);
  REQUIRE(report.divergence);
  CHECK(report.divergence->candidate_count == 0);
  CHECK(contains(verifier::report_text(report), "rows stand in another order"));
}

TEST_CASE("locate: a value that leaves one of its cells as it was is healed", "[verifier][cells][analytic]") {
  ToySimulation toy(1'000);
  CellHasher hasher(ToySimulation::schema());
  StateCells before, after;
  hasher.hash(toy.state(), 0, before);
  const std::vector<CellOwner> owners = hasher.owners(toy.state());
  // Charges of body 123 are tried until its new value agrees with the old one in the cell of a partition: one in 65,536
  // does by chance. All partitions are met by going on.
  const auto owner = std::find_if(owners.begin(), owners.end(),
                                  [](const CellOwner& found) { return found.table == 1 && found.row == 123; });
  const auto at = cells_of(*owner, before.partition_cells);
  // The same body among few, so that the search is quick: values do not depend on how many others there are.
  ToySimulation few(2);
  few.bodies = {toy.bodies[122], toy.bodies[123]};
  few.links = {toy.links[61]};
  few.refresh();
  StateCells few_before, few_after;
  hasher.hash(few.state(), before.partition_cells, few_before);
  std::vector<std::int32_t> collisions(partition_count, 0);
  std::size_t found_count = 0;
  for (std::int32_t charge = 100; charge < 3'000'000 && found_count < 2; ++charge) {
    few.bodies[1].charge = charge;
    hasher.hash(few.state(), before.partition_cells, few_after);
    for (std::size_t p = 0; p < partition_count; ++p) {
      const std::size_t cell = p * before.partition_cells + at[p];
      if (collisions[p] != 0 || few_before.cells[cell] != few_after.cells[cell]) continue;
      collisions[p] = charge;
      ++found_count;
    }
  }
  REQUIRE(found_count == 2);
  const std::int32_t true_charge = toy.bodies[123].charge;
  for (const std::int32_t charge : collisions) {
    if (charge == 0) continue;
    toy.bodies[123].charge = charge;
    hasher.hash(toy.state(), 0, after);
    const verifier::CellFinding finding = verifier::find_candidates(before, after, owners);
    CHECK(finding.differing_cells == partition_count - 1);
    CHECK(finding.healed);
    CHECK(finding.unexplained_cells == 0);
    CHECK(std::any_of(finding.candidates.begin(), finding.candidates.end(),
                      [](const CellOwner& candidate) { return candidate.table == 1 && candidate.row == 123; }));
    CHECK(finding.candidates.size() <= 3);  // 0.07 others are expected
  }
  toy.bodies[123].charge = true_charge;
}

TEST_CASE("locate: spread counts each differing row once, and rows of an owner with it",
          "[verifier][cells][analytic]") {
  const ToySimulation first(6);
  ToySimulation second(6);
  const auto spread = [&] {
    Bytes of_first, of_second;
    return verifier::spread_of_tables(ToySimulation::schema(), canonical_tables(first.state(), of_first),
                                      canonical_tables(second.state(), of_second), 9);
  };
  CHECK(spread().tick == 9);
  CHECK(spread().of == 7);  // the world and six bodies; links belong to bodies
  CHECK(spread().row_count == 0);
  CHECK(!spread().estimated);
  second.links[1].stiffness = 3;
  CHECK(spread().row_count == 0);
  second.bodies[1].charge += 1;
  second.bodies[1].velocity[0] += 1;
  second.bodies[1].velocity[1] += 1;
  CHECK(spread().row_count == 1);
  second.bodies[4].hits += 1;
  CHECK(spread().row_count == 2);
  second.world.score += 1;
  CHECK(spread().row_count == 3);
  second.links[0].stiffness = 3;
  CHECK(spread().row_count == 3);
}

TEST_CASE("inject: flips in traces with cells are found, table and column exact, the rows concerned in the list",
          "[verifier][cells][inject][analytic]") {
  const Bytes trace = toy_trace_with(cells_toy_setup(200), 40, 16);
  InjectOptions options;
  options.count = 300;
  const InjectReport report = inject_into(trace, toy_info, options);
  require_all_found(report);
  CHECK(report.lists.count == 300);
  CHECK(report.lists.median == report.lists.median_concerned);
  CHECK(contains(verifier::inject_text(report), "the rows concerned in the list"));
  const auto json = nlohmann::json::parse(verifier::inject_json(report));
  CHECK(json["lists"]["median"] == report.lists.median);
}

TEST_CASE("inject: two to four bodies at once are all in the list", "[verifier][cells][inject][analytic]") {
  const Bytes trace = toy_trace_with(cells_toy_setup(1'000), 6, 0);
  for (const std::uint32_t count : {2u, 3u, 4u}) {
    InjectOptions options;
    options.count = 40;
    options.seed = count;
    options.body_count = count;
    const InjectReport report = inject_into(trace, toy_info, options);
    require_all_found(report);
    for (const InjectRow& row : report.rows) CHECK(row.more.size() == count - 1);
    CHECK(report.lists.median_concerned == count);
    CHECK(report.lists.median <= 6);
  }
}

/// A trace of a built-in scene.
Bytes engine_trace(const std::string& scene, replay::Detail detail, std::uint64_t tick_count) {
  const TemporaryFolder folder;
  auto engine = engine::make_engine(*engine::make_builtin_scene(scene));
  REQUIRE(engine);
  replay::NoInputs inputs((*engine)->scene().settings.dt);
  replay::RecordOptions options;
  options.tick_count = tick_count;
  options.writer = plain_writer();
  tool::TraceChoices choices;
  choices.detail = detail;
  REQUIRE(replay::record(**engine, inputs, folder.file("engine.ttr"), tool::make_trace_setup(**engine, choices),
                         toy_facts, options));
  return read_file(folder.file("engine.ttr"));
}

TEST_CASE("inject: faults inside the solver are found at their tick, with their body in the list",
          "[verifier][cells][inject][analytic]") {
  const Bytes trace = engine_trace("stack?boxes=8", replay::Detail::cells, 30);
  for (const std::uint32_t substep : {0u, 3u}) {
    InjectOptions options;
    options.count = 60;
    options.after_substep = substep;
    const InjectReport report = inject_into(trace, engine::engine_info(), options);
    CHECK(report.failed == 0);
    CHECK(report.passed >= 40);  // low bits of small values may be lost in rounding
    for (const InjectRow& row : report.rows) {
      CAPTURE(row.index, row.reason);
      CHECK(row.outcome != InjectRow::Outcome::missed);
    }
  }
}

TEST_CASE("inject: threads change nothing of the report", "[verifier][cells][inject][determinism]") {
  for (const replay::Detail detail : {replay::Detail::root, replay::Detail::cells, replay::Detail::full}) {
    replay::TraceSetup setup = detail == replay::Detail::full ? full_toy_setup(30, 10, 20) : toy_setup(30);
    setup.detail = detail;
    const Bytes trace = toy_trace_with(setup, 40, 16);
    InjectOptions options;
    options.count = 60;
    const std::string alone = verifier::inject_json(inject_into(trace, toy_info, options));
    std::uint64_t told = 0;
    options.thread_count = 3;
    options.progress = [&](std::uint64_t done) { told = std::max(told, done); };
    options.reopen = [&] { return std::make_unique<verifier::OwnedReaderSource>(open_trace(trace)); };
    CHECK(verifier::inject_json(inject_into(trace, toy_info, options)) == alone);
    CHECK(told == 60);
  }
}

TEST_CASE("inject: faults that leave their own body as it was are counted as waived",
          "[verifier][cells][inject][analytic]") {
  // A body that is very light against its neighbour: its last bit is lost in rounding, but the solver has passed it on.
  const Bytes trace = engine_trace("mixed_pile?bodies=60", replay::Detail::cells, 120);
  InjectOptions options;
  options.count = 300;
  options.seed = 3;
  options.after_substep = 0;
  const InjectReport report = inject_into(trace, engine::engine_info(), options);
  CHECK(report.failed == 0);
  const auto waived = std::count_if(report.rows.begin(), report.rows.end(), [](const InjectRow& row) {
    return row.outcome == InjectRow::Outcome::found && row.waived;
  });
  CHECK(report.waived == static_cast<std::uint64_t>(waived));
  CHECK(report.lists.median_concerned == 1);
  const auto json = nlohmann::json::parse(verifier::inject_json(report));
  CHECK(json["waived"] == report.waived);
  CHECK(contains(verifier::inject_text(report), "waived") == (report.waived > 0));
}

TEST_CASE("inject: a simulation without an inside has no faults there", "[verifier][cells][inject][analytic]") {
  const Bytes trace = toy_trace_with(cells_toy_setup(6), 6, 0);
  InjectOptions options;
  options.count = 3;
  options.after_substep = 0;
  const InjectReport report = inject_into(trace, toy_info, options);
  CHECK(report.not_applicable == 3);
  CHECK(report.exit_code() != 0);
}

verifier::DiffReport diff_bytes(ByteView a, ByteView b, const SimulationInfo& info) {
  auto reader_a = replay::TraceReader::open_bytes(a, "a.ttr");
  auto reader_b = replay::TraceReader::open_bytes(b, "b.ttr");
  REQUIRE(reader_a);
  REQUIRE(reader_b);
  verifier::DiffOptions options;
  options.simulation = &info;
  return verifier::diff(*reader_a, *reader_b, options);
}

TEST_CASE("diff: cells of two traces name columns, bodies and spread without running anything",
          "[verifier][cells][diff][analytic]") {
  const Bytes a = toy_trace_with(cells_toy_setup(30), 40, 10);
  injected = {23, ToySimulation::move_stage, [](ToySimulation& toy) { toy.bodies[7].charge += 1; }};
  const TemporaryFolder folder;
  auto simulation = *make_faulty(cells_toy_setup(30).setup);
  ScriptedInputs source(lively_script);
  replay::RecordOptions options;
  options.tick_count = 40;
  options.writer = plain_writer();
  REQUIRE(replay::record(*simulation, source, folder.file("b.ttr"), cells_toy_setup(30), toy_facts, options));
  const verifier::DiffReport report = diff_bytes(a, read_file(folder.file("b.ttr")), toy_info);
  REQUIRE(report.verdict == verifier::DiffVerdict::different);
  const Divergence& found = *report.divergence;
  CHECK(found.tick == 23);
  CHECK(found.tables.size() == 1);
  CHECK(found.tables[0].columns == std::vector<std::string>{"charge"});
  CHECK(names(found, "bodies", 7));
  CHECK(found.candidate_count == 1);
  CHECK(!found.spread.empty());
  const std::string text = verifier::diff_text(report);
  CAPTURE(text);
  CHECK(contains(text, "bodies.charge"));
  CHECK(contains(text, "before tick 20"));
  CHECK(contains(text, "ticktrue diff a.ttr b.ttr"));
}

TEST_CASE("diff: two precisions of one scene differ in their precision", "[verifier][cells][diff][analytic]") {
  const Bytes f32 = engine_trace("stack?boxes=3&precision=f32", replay::Detail::cells, 3);
  const Bytes f64 = engine_trace("stack?boxes=3&precision=f64", replay::Detail::cells, 3);
  const verifier::DiffReport report = diff_bytes(f32, f64, engine::engine_info());
  CHECK(report.verdict == verifier::DiffVerdict::not_comparable);
  REQUIRE(!report.setup.empty());
  CHECK(report.setup[0].what == "precision");
  CHECK(report.setup[0].a == "f32");
  CHECK(report.setup[0].b == "f64");
  CHECK(report.reason == "precision: f32 and f64");
}

}  // namespace
}  // namespace ticktrue::test
