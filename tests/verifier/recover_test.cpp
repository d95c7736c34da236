// What is recovered of a trace with a random hole verifies, loses nothing before the hole, and says what is missing.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "base/random.h"
#include "replay/format/chunk.h"
#include "tests/verifier/toy_variants.h"

namespace ticktrue::test {
namespace {

using replay::TraceCondition;
using verifier::Verdict;
using verifier::VerifyOptions;

enum class Hole { zeros, noise, removed, inserted, cut };

Bytes with_hole(const Bytes& whole, Hole kind, std::size_t offset, std::size_t size, Random& random) {
  Bytes bytes = whole;
  const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(offset);
  const auto last = first + static_cast<std::ptrdiff_t>(std::min(size, whole.size() - offset));
  if (kind == Hole::zeros) std::fill(first, last, std::uint8_t{0});
  if (kind == Hole::noise)
    for (auto at = first; at != last; ++at) *at = static_cast<std::uint8_t>(random.below(256));
  if (kind == Hole::removed) bytes.erase(first, last);
  if (kind == Hole::inserted) bytes.insert(first, size, 0x55);
  if (kind == Hole::cut) bytes.resize(offset);
  return bytes;
}

/// Offset of the first byte that differs; the shorter size if one is the beginning of the other.
std::size_t first_difference(const Bytes& a, const Bytes& b) {
  std::size_t at = 0;
  while (at < a.size() && at < b.size() && a[at] == b[at]) ++at;
  return at;
}

/// Ticks whose chunk, image included, ends before `offset`.
std::uint64_t ticks_before(const Bytes& whole, std::size_t offset) {
  std::uint64_t ticks = 0;
  for (const ChunkPlace& place : chunk_places(whole)) {
    if (place.offset + place.size > offset) break;
    const auto is = [&](replay::ChunkKind kind) { return place.kind == static_cast<std::uint8_t>(kind); };
    if (is(replay::ChunkKind::ticks)) {
      // The close record ends the chunk: u32 count, u64 value.
      ticks += ByteReader(ByteView(whole).subspan(place.offset + place.size - 12)).u32();
    }
  }
  return ticks;
}

TEST_CASE("what is recovered around a random hole verifies, and nothing before the hole is lost",
          "[verifier][recover][corruption]") {
  Random random(7);
  replay::TraceSetup setup = full_toy_setup(6, 20, 23);
  setup.checkpoint_interval = 7;
  const Bytes whole = toy_trace(setup, 60);
  const ReadTrace contents = read_all(whole);
  const std::size_t setup_end = chunk_places(whole)[1].offset;
  const TemporaryFolder folder;
  const std::string input = folder.file("in.ttr");
  const std::string output = folder.file("out.ttr");
  int recovered_count = 0;
  for (int round = 0; round < 400; ++round) {
    const auto kind = static_cast<Hole>(round % 5);
    const std::size_t offset = setup_end + random.below(static_cast<std::uint32_t>(whole.size() - setup_end));
    const std::size_t size = 1 + random.below(round % 2 == 0 ? 16 : 2'000);
    const Bytes bytes = with_hole(whole, kind, offset, size, random);
    if (bytes == whole) continue;
    const std::size_t intact_size = first_difference(bytes, whole);
    CAPTURE(round, offset, size, intact_size);
    write_file(input, bytes);
    const auto result = replay::recover_trace(input, output, true);
    REQUIRE(result);
    REQUIRE(result->tail.condition != TraceCondition::complete);
    REQUIRE_FALSE(result->tail.message.empty());
    REQUIRE(result->ticks_written >= ticks_before(whole, intact_size));
    REQUIRE(result->ticks_written >= result->tail.ticks_intact);
    // The range that is reported as intact behind the hole is intact, and is not the recovered part.
    for (const replay::IntactRange& range : result->tail.intact_after) {
      REQUIRE(range.first_tick >= result->ticks_written);
      REQUIRE(range.last_tick < contents.ticks.size());
    }
    if (result->ticks_written == 0) continue;
    ++recovered_count;
    const Bytes saved = read_file(output);
    const ReadTrace got = read_all(saved);
    REQUIRE(got.tail.condition == TraceCondition::complete);
    REQUIRE(got.ticks.size() == result->ticks_written);
    for (std::size_t i = 0; i < got.ticks.size(); ++i) {
      ReadTick expected = contents.ticks[i];
      if (!got.ticks[i].image) expected.image.reset();  // the hole may lie in the image of the last tick
      REQUIRE(got.ticks[i] == expected);
    }
    const verifier::Report report = verify_bytes(saved, toy_info);
    REQUIRE(report.verdict == Verdict::match);
    REQUIRE(report.ticks_compared == result->ticks_written);
  }
  CHECK(recovered_count > 250);
}

TEST_CASE("verify compares the ticks that recovery saves, and they are never a match",
          "[verifier][verify][recover][corruption]") {
  Random random(11);
  const TemporaryFolder folder;
  const std::string input = folder.file("in.ttr");
  int salvaged_count = 0;
  for (const std::uint32_t interval : {0u, 40u}) {
    const Bytes whole = toy_trace_with(toy_setup(3), 300, interval);
    const std::size_t setup_end = chunk_places(whole)[2].offset;
    for (int round = 0; round < 60; ++round) {
      Bytes bytes = whole;
      const std::size_t place = setup_end + random.below(static_cast<std::uint32_t>(whole.size() - setup_end));
      bytes[place] ^= static_cast<std::uint8_t>(1 + random.below(255));
      CAPTURE(interval, round, place);
      write_file(input, bytes);
      const auto recovered = replay::recover_trace(input, folder.file("out.ttr"), true);
      REQUIRE(recovered);
      for (const bool in_segments : {false, true}) {
        auto reader = replay::TraceReader::open(input);
        REQUIRE(reader);
        VerifyOptions options = verify_options(toy_info);
        options.in_segments = in_segments;
        const verifier::Report report = verifier::verify(*reader, options);
        REQUIRE(report.verdict == Verdict::damaged);
        REQUIRE(report.ticks_compared == recovered->ticks_written);
        REQUIRE(report.end);
        REQUIRE(report.end->tail.ticks_intact == recovered->ticks_written);
        REQUIRE(report.end->salvaged_from.has_value() == (recovered->ticks_written > recovered->tail.ticks_intact));
        REQUIRE(report.again.size() == (recovered->ticks_written > 0 ? 1 : 0));
        if (recovered->ticks_written == 0) REQUIRE_FALSE(report.hint.empty());
      }
      if (recovered->ticks_written <= recovered->tail.ticks_intact) continue;
      ++salvaged_count;
      // Up to a tick of the damaged chunk it is no match either; up to one of a whole chunk it is.
      const std::uint64_t proven = recovered->tail.ticks_intact;
      for (const std::uint64_t to : {recovered->ticks_written - 1, proven, proven - 1}) {
        if (to == proven - 1 && proven == 0) continue;
        CAPTURE(to);
        auto reader = replay::TraceReader::open(input);
        REQUIRE(reader);
        VerifyOptions options = verify_options(toy_info);
        options.to = to;
        const verifier::Report report = verifier::verify(*reader, options);
        REQUIRE(report.ticks_compared == to + 1);
        REQUIRE(report.verdict == (to < proven ? Verdict::match : Verdict::damaged));
      }
    }
  }
  CHECK(salvaged_count > 60);
}

TEST_CASE("of a long chunk that is damaged inside, all but the last three ticks before the damage are recovered",
          "[verifier][recover][corruption]") {
  const Bytes whole = toy_trace(toy_setup(3), 900);
  const ReadTrace contents = read_all(whole);
  const ChunkPlace chunk = chunk_places(whole)[3];
  REQUIRE(chunk.kind == static_cast<std::uint8_t>(replay::ChunkKind::ticks));
  const TemporaryFolder folder;
  Random random(3);
  for (int round = 0; round < 40; ++round) {
    const std::size_t place = chunk.offset + replay::chunk_header_size + random.below(chunk.size - 60);
    Bytes bytes = whole;
    bytes[place] ^= static_cast<std::uint8_t>(1 + random.below(255));
    CAPTURE(round, place);
    REQUIRE(read_all(bytes).ticks.empty());  // to a reader nothing of the chunk is proven
    std::uint64_t tick_count = 0;            // whose records end before the damage
    std::size_t record_end = replay::chunk_header_size;
    for (;;) {
      const replay::Record record =
          replay::parse_record(ByteView(whole).subspan(chunk.offset + record_end, chunk.size - record_end), nullptr);
      record_end += record.size;
      if (chunk.offset + record_end > place) break;
      tick_count += record.tag == static_cast<std::uint8_t>(replay::RecordTag::root) ? 1 : 0;
    }
    write_file(folder.file("in.ttr"), bytes);
    const auto result = replay::recover_trace(folder.file("in.ttr"), folder.file("out.ttr"), true);
    REQUIRE(result);
    REQUIRE(result->ticks_written == (tick_count > 3 ? tick_count - 3 : 0));
    if (result->ticks_written == 0) continue;
    const ReadTrace got = read_all(read_file(folder.file("out.ttr")));
    REQUIRE(got.tail.condition == TraceCondition::complete);
    for (std::size_t i = 0; i < got.ticks.size(); ++i) REQUIRE(got.ticks[i] == contents.ticks[i]);
  }
}

}  // namespace
}  // namespace ticktrue::test
