// A record that does not agree with its own root hash is never a match, whichever part of it was changed.
// SPDX-License-Identifier: MIT
#include "tests/support/catch.h"
#include "tests/support/forging.h"
#include "tests/verifier/toy_variants.h"
#include "verifier/compare/diff.h"

namespace ticktrue::test {
namespace {

using verifier::DiffReport;
using verifier::DiffVerdict;
using verifier::Report;
using verifier::StoredCheckpoint;
using verifier::StoredTick;
using verifier::Verdict;
using verifier::VerifyMode;

constexpr std::uint64_t forged_tick = 22;

replay::TraceSetup cells_toy_setup() {
  replay::TraceSetup setup = toy_setup(6);
  setup.detail = replay::Detail::cells;
  return setup;
}

struct ForgedPart {
  const char* name;
  replay::TraceSetup setup;
  Forgery forgery;
  std::uint64_t tick;  // reported
  const char* note;    // in the notes or at the stage
};

void at_tick(StoredTick& tick, const std::function<void(StoredTick&)>& change) {
  if (tick.tick == forged_tick) change(tick);
}

std::vector<ForgedPart> forged_parts() {
  const replay::TraceSetup full = full_toy_setup(6, 0, 100);
  return {
      {"stage hash",
       full,
       {[](StoredTick& tick) { at_tick(tick, [](StoredTick& t) { t.stage_hashes[1] ^= 1; }); }},
       forged_tick,
       "the hashes after the stages do not"},
      // The last byte of the image is a lane of the last link.
      {"image",
       full,
       {[](StoredTick& tick) { at_tick(tick, [](StoredTick& t) { t.image->back() ^= 1; }); }},
       forged_tick,
       "the state image does not"},
      {"cell",
       cells_toy_setup(),
       {[](StoredTick& tick) { at_tick(tick, [](StoredTick& t) { t.cells->cells.back() ^= 0x100; }); }},
       forged_tick,
       "the cells do not"},
      {"column",
       cells_toy_setup(),
       {[](StoredTick& tick) { at_tick(tick, [](StoredTick& t) { t.cells->columns[0] ^= 1; }); }},
       forged_tick,
       "the cells do not"},
      {"checkpoint",
       toy_setup(6),
       {{},
        [](StoredCheckpoint& checkpoint) {
          if (checkpoint.tick == 24) checkpoint.image.back() ^= 1;
        }},
       24,
       "checkpoint"},
      {"hash of the checkpoint",
       toy_setup(6),
       {{},
        [](StoredCheckpoint& checkpoint) {
          if (checkpoint.tick == 24) checkpoint.root_hash ^= 1;
        }},
       24,
       "checkpoint"},
  };
}

std::string all_notes(const verifier::Divergence& divergence, const std::vector<std::string>& notes) {
  std::string text = divergence.stage.value_or("") + divergence.stage_note;
  for (const std::string& note : notes) text += "\n" + note;
  return text;
}

TEST_CASE("forged: verify finds whatever part of a record was changed", "[verifier][forged][corruption]") {
  for (const ForgedPart& part : forged_parts()) {
    const TemporaryFolder folder;
    replay::TraceSetup setup = part.setup;
    setup.checkpoint_interval = 8;
    REQUIRE(record_toy(folder.file("toy.ttr"), setup, 60));
    CHECK(verify_bytes(read_file(folder.file("toy.ttr")), toy_info).verdict == Verdict::match);
    forge_trace(folder.file("toy.ttr"), folder.file("forged.ttr"), part.forgery);
    const Bytes forged = read_file(folder.file("forged.ttr"));
    for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore})
      for (const unsigned thread_count : {1u, 3u}) {
        CAPTURE(part.name, int(mode), thread_count);
        verifier::VerifyOptions options = verify_options(toy_info, mode);
        options.thread_count = thread_count;
        options.search_single_bit = true;
        options.reopen = [&]() -> std::unique_ptr<verifier::TraceSource> {
          return std::make_unique<verifier::OwnedReaderSource>(open_trace(forged));
        };
        const Report report = verify_bytes(forged, options);
        CHECK(report.verdict == Verdict::diverged);
        REQUIRE(report.divergence);
        CHECK(report.divergence->tick == part.tick);
        CHECK(contains(all_notes(*report.divergence, report.notes), part.note));
      }
  }
}

TEST_CASE("forged: diff finds whatever part of a record was changed", "[verifier][forged][corruption]") {
  for (const ForgedPart& part : forged_parts()) {
    const TemporaryFolder folder;
    replay::TraceSetup setup = part.setup;
    setup.checkpoint_interval = 8;
    REQUIRE(record_toy(folder.file("toy.ttr"), setup, 60));
    // Without that checkpoint of its own, the other one has only the tick's hash to compare it with.
    setup.checkpoint_interval = 0;
    REQUIRE(record_toy(folder.file("none.ttr"), setup, 60));
    forge_trace(folder.file("toy.ttr"), folder.file("forged.ttr"), part.forgery);
    for (const char* other : {"toy.ttr", "none.ttr"}) {
      CAPTURE(part.name, other);
      auto a = replay::TraceReader::open(folder.file(other));
      auto b = replay::TraceReader::open(folder.file("forged.ttr"));
      REQUIRE(a);
      REQUIRE(b);
      const DiffReport report = verifier::diff(*a, *b, {});
      CHECK(report.verdict == DiffVerdict::different);
      CHECK(report.ticks_compared == 60);
      REQUIRE(report.divergence);
      CHECK(report.divergence->tick == part.tick);
      CHECK(contains(all_notes(*report.divergence, report.notes), part.note));
    }
  }
}

TEST_CASE("forged: reports count the parts that were compared, and diff those that were not",
          "[verifier][forged][report]") {
  const TemporaryFolder folder;
  const auto record = [&](const char* name, replay::TraceSetup setup, std::uint32_t interval) {
    setup.checkpoint_interval = interval;
    REQUIRE(record_toy(folder.file(name), setup, 40));
    return folder.file(name);
  };
  const std::string full = record("full.ttr", full_toy_setup(6, 5, 14), 8);
  const std::string cells = record("cells.ttr", cells_toy_setup(), 8);
  Report report = verify_bytes(read_file(full), toy_info);
  CHECK(report.compared.ticks == 40);
  CHECK(report.compared.stage_hashes == 10);
  CHECK(report.compared.images == 10);
  CHECK(report.compared.cells == 0);
  CHECK(contains(verifier::report_json({&report, 1}, false), "\"stage_hashes\": 10"));
  report = verify_bytes(read_file(cells), toy_info);
  CHECK(report.compared.cells == 40);
  CHECK(report.compared.images == 0);
  verifier::VerifyOptions part = verify_options(toy_info);
  part.from = 30;
  CHECK(verify_bytes(read_file(cells), part).compared.cells == 10);

  auto a = replay::TraceReader::open(full);
  auto b = replay::TraceReader::open(cells);
  REQUIRE(a);
  REQUIRE(b);
  const DiffReport different = verifier::diff(*a, *b, {});
  CHECK(different.verdict == DiffVerdict::equal);
  CHECK(different.checkpoints_compared == 6);  // 0, 8, 16, 24, 32, 40
  CHECK(different.compared.ticks == 40);
  REQUIRE(different.notes.size() == 3);
  CHECK(different.notes[0] == "hashes after the stages: a stores them for 10 ticks, b for 0; compared for 0");
  CHECK(contains(different.notes[2], "cells: a stores them for 0 ticks, b for 40; compared for 0"));
}

TEST_CASE("forged: any number of sides is compared, and the first two that differ are named",
          "[verifier][forged][analytic]") {
  using verifier::TickPart;
  using verifier::TickSide;
  const TemporaryFolder folder;
  REQUIRE(record_toy(folder.file("toy.ttr"), full_toy_setup(6, 0, 10), 5));
  auto reader = replay::TraceReader::open(folder.file("toy.ttr"));
  REQUIRE(reader);
  std::optional<StoredTick> tick;
  while (!tick) {
    const auto& item = reader->next();
    if (const auto* record = std::get_if<replay::TickRecord>(&item)) tick = verifier::copy_of(*record);
  }
  verifier::TickComparer comparer(reader->setup().schema);
  StoredTick hash_only = *tick;
  hash_only.stage_hashes.clear();
  hash_only.image.reset();
  StoredTick other = *tick;
  other.image->back() ^= 1;
  std::vector<TickSide> sides{side_of(hash_only), side_of(*tick), side_of(hash_only), side_of(*tick)};
  CHECK(!comparer.compare(sides));
  sides.push_back(side_of(other));
  auto found = comparer.compare(sides);
  REQUIRE(found);
  CHECK(found->part == TickPart::image);
  CHECK(found->a == 1);
  CHECK(found->b == 4);
  other.root_hash ^= 1;
  sides.back() = side_of(other);
  found = comparer.compare(sides);
  REQUIRE(found);
  CHECK(found->part == TickPart::root_hash);
  CHECK(found->a == 0);
  const verifier::ComparedParts compared = comparer.take_compared();
  CHECK(compared.ticks == 3);
  CHECK(compared.images == 2);
}

}  // namespace
}  // namespace ticktrue::test
