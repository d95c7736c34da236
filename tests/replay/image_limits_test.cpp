// What a reader holds of compressed images is proportional to the file, and a writer keeps to it.
// SPDX-License-Identifier: MIT
#include "base/limits.h"
#include "replay/format/payload.h"
#include "tests/damage/forger.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

using damage::Forger;
using replay::ChunkKind;

/// A state of one table with one column of bytes: an image of any size.
replay::TraceSetup blob_setup() {
  replay::TraceSetup setup = toy_setup(1);
  setup.schema = {};
  TableSchema table;
  table.name = "blob";
  table.row_size = 1;
  table.columns.resize(1);
  table.columns[0].name = "byte";
  table.columns[0].type = ScalarType::u8;
  setup.schema.tables.push_back(table);
  return setup;
}

Forger begin(const replay::TraceSetup& setup) {
  Forger forger(replay::format_version_first);
  ByteWriter payload;
  replay::encode_setup(setup, payload);
  forger.setup(payload.view());
  forger.facts({replay::Codec::zstd, {}});
  return forger;
}

Bytes row_count(std::uint32_t count) {
  ByteWriter out;
  out.u32(count);
  return out.take();
}

replay::TraceTail tail_of(const Bytes& trace) {
  auto reader = replay::TraceReader::open_bytes(trace, "forged.ttr");
  if (!reader) FAIL(reader.error().message);
  while (!std::holds_alternative<std::monostate>(reader->next())) {
  }
  return reader->tail();
}

TEST_CASE("an image of zeros that is much larger than its file is refused before it is held",
          "[replay][image_limits][corruption]") {
  SKIP_UNLESS(replay::has_codec(replay::Codec::zstd), "a build without zstd");
  constexpr std::uint32_t size = 64u << 20;
  Forger forger = begin(blob_setup());
  forger.image(ChunkKind::checkpoint, 1, row_count(size - 4), size, true, SIZE_MAX);
  const Bytes trace = forger.take();
  REQUIRE(trace.size() < 64 * 200);
  const replay::TraceTail tail = tail_of(trace);
  CHECK(tail.condition == replay::TraceCondition::damaged);
  CHECK(contains(tail.message, "state image: bytes: found "));
  CHECK(tail.offset < trace.size() / 3);  // at the first part beyond the limit
}

TEST_CASE("images that each are small enough are refused when all unpack to too much",
          "[replay][image_limits][corruption]") {
  SKIP_UNLESS(replay::has_codec(replay::Codec::zstd), "a build without zstd");
  constexpr std::uint32_t size = 8u << 20;
  Forger forger = begin(blob_setup());
  for (std::uint64_t i = 0; i < 200; ++i) {
    forger.image(ChunkKind::checkpoint, 1, row_count(size - 4), size, true, SIZE_MAX);
    forger.open_ticks();
    forger.record(replay::RecordTag::root, Bytes(8));
    forger.close_ticks();
  }
  const replay::TraceTail tail = tail_of(forger.take());
  CHECK(tail.condition == replay::TraceCondition::damaged);
  CHECK(contains(tail.message, "state image: bytes of all images: found "));
}

TEST_CASE("a row count that its image cannot hold is found in the part that has it",
          "[replay][image_limits][corruption]") {
  SKIP_UNLESS(replay::has_codec(replay::Codec::zstd), "a build without zstd");
  Forger forger = begin(blob_setup());
  forger.image(ChunkKind::checkpoint, 1, row_count(0xffffffffu), 8u << 20, true, SIZE_MAX);
  const Bytes trace = forger.take();
  const replay::TraceTail tail = tail_of(trace);
  CHECK(contains(tail.message, "table blob: rows: found 4294967295, expected at most what an image of 8388608 bytes"));
  CHECK(tail.offset < 600);

  Forger shorter = begin(blob_setup());
  shorter.image(ChunkKind::checkpoint, 1, row_count(3), 100, false, SIZE_MAX);
  CHECK(contains(tail_of(shorter.take()).message, "state image: size: found 100 bytes, expected 7"));
}

TEST_CASE("what a writer compresses, a reader takes, whatever the state and wherever the file is cut",
          "[replay][image_limits][equivalence]") {
  constexpr std::uint32_t size = 40u << 20;
  const TemporaryFolder folder;
  const std::string path = folder.file("zeros.ttr");
  auto writer = replay::TraceWriter::create(path, blob_setup(), toy_facts, {false, true, false});
  REQUIRE(writer);
  Bytes image = row_count(size - 4);
  image.resize(size);
  for (std::uint64_t tick = 0; tick < 30; ++tick) {
    REQUIRE(writer->checkpoint_encoded(image, 1));
    REQUIRE(writer->begin_tick({0.015625, {}}));
    REQUIRE(writer->end_tick_encoded(1, {}, std::nullopt));
  }
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  const Bytes trace = read_file(path);
  CHECK(trace.size() < 4u << 20);  // one part in seventeen is stored as it is, once
  CHECK(tail_of(trace).condition == replay::TraceCondition::complete);
  for (const std::size_t part : {2, 3, 5}) {
    const Bytes cut(trace.begin(), trace.begin() + static_cast<std::ptrdiff_t>(trace.size() / part));
    CHECK(tail_of(cut).condition == replay::TraceCondition::truncated);
  }
}

}  // namespace
}  // namespace ticktrue::test
