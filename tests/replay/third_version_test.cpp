// Format version 3: what is written is read, nothing else is, and content outside of the chain costs no tick.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>
#include <string>

#include "replay/format/payload.h"
#include "replay/format/table_list.h"
#include "tests/replay/third_example.h"
#include "tests/replay/third_sessions.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

using replay::ChunkKind;
using replay::Detail;
using replay::Feature;
using replay::TraceCondition;
using replay::TraceReader;

constexpr std::uint32_t bit(Feature feature) {
  return static_cast<std::uint32_t>(feature);
}
constexpr std::uint32_t all_bound = bit(Feature::saves) | bit(Feature::marks) | bit(Feature::notes);

bool is_kind(const ChunkPlace& place, ChunkKind kind) {
  return place.kind == static_cast<std::uint8_t>(kind);
}

Bytes example() {
  Bytes bytes;
  for (std::size_t i = 0; i < third_example.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(std::string(third_example.substr(i, 2)), nullptr, 16)));
  return bytes;
}

/// One of each: begins late, all content outside of the chain, images of changes, stage hashes.
SessionPlan full_plan() {
  SessionPlan plan;
  plan.tick_count = 14;
  plan.first_tick = 7;
  plan.detail = Detail::full;
  plan.full_first = 11;
  plan.full_last = 15;
  plan.checkpoint_interval = 5;
  plan.features = all_bound | bit(Feature::tail);
  plan.stage_interval = 4;
  plan.has_shown = true;
  return plan;
}

SessionPlan random_plan(std::uint64_t seed) {
  Random random(seed);
  SessionPlan plan;
  plan.seed = seed;
  plan.bound_seed = random.bits();
  plan.table_count = 1 + random.below(random.below(4) == 0 ? 100 : 8);
  plan.changed_tables = random.below(4);
  plan.tick_count = 1 + random.below(30);
  plan.detail = static_cast<Detail>(1 + random.below(3));
  plan.checkpoint_interval = static_cast<std::uint32_t>(random.below(3) * 4);
  plan.features = static_cast<std::uint32_t>(random.below(16)) & all_bound;
  if (random.below(2) == 0) {
    plan.features |= bit(Feature::tail);
    plan.first_tick = random.below(50);
  }
  if (plan.detail == Detail::full) {
    plan.full_first = plan.first_tick + random.below(10);
    plan.full_last = plan.full_first + random.below(12);
  }
  plan.stage_interval = static_cast<std::uint32_t>(random.below(4));
  plan.has_shown = random.below(2) == 0;
  plan.compress = random.below(2) == 0;
  return plan;
}

TEST_CASE("the example of the design is read, and recovery writes the same bytes", "[replay][third][golden]") {
  const Bytes bytes = example();
  REQUIRE(bytes.size() == 1'158);
  auto reader = TraceReader::open_bytes(bytes, "example.ttr");
  REQUIRE(reader);
  CHECK(reader->first_tick() == 8);
  CHECK(reader->tick_count_hint() == 10U);
  CHECK(reader->setup().features == 31);
  CHECK(reader->setup().stage_interval == 2);
  REQUIRE(reader->setup().whole_schema);
  CHECK(reader->setup().whole_schema->tables[0].columns[2].name == "glow");
  CHECK(reader->setup().schema.tables[0].columns.size() == 2);
  CHECK(reader->setup().schema.tables[1].form == TableForm::text);
  const ThirdTrace all = read_third(*reader);
  CHECK(all.tail.condition == TraceCondition::complete);
  CHECK(all.tail.ticks_intact == 10);
  REQUIRE(all.checkpoints.size() == 1);
  CHECK(all.checkpoints[0].checkpoint.tick == 8);
  CHECK(all.checkpoints[0].checkpoint.root_hash == 0x236a687edc8a8395);
  CHECK(all.checkpoints[0].time_s == 8.0 / 64);
  const std::string text = "save of tick 8";
  CHECK(all.checkpoints[0].save == Bytes(text.begin(), text.end()));
  REQUIRE(all.checkpoints[0].shown);
  CHECK(all.checkpoints[0].shown->size() == 10);
  REQUIRE(all.ticks.size() == 2);
  CHECK(all.ticks[0].tick.root_hash == 0xce2453bc4144303b);
  CHECK(all.ticks[0].tick.stage_hashes == std::vector<std::uint64_t>{0xce2453bc4144303b});
  CHECK(all.ticks[0].bound.size() == 3);
  CHECK(all.ticks[1].tick.root_hash == 0xc7afb4fd8db99bd7);
  CHECK(all.ticks[1].tick.stage_hashes.empty());
  CHECK(all.ticks[1].bound.empty());
  CHECK(content_id(bytes) == 0x9d87d680385218ba);

  // Its image is of the schema, root and all.
  const auto tables = check_image(reader->setup().schema, all.checkpoints[0].checkpoint.image);
  REQUIRE(tables);
  CHECK((*tables)[0].row_count == 1);
  CHECK((*tables)[1].row_count == 2);
  // The writer puts marks where the program made them, before the stages: the record of the example stands behind.
  const Bytes again = recovered(bytes);
  CHECK(again.size() == bytes.size());
  CHECK(content_id(again) == content_id(bytes));
}

TEST_CASE("random sessions of version 3 are read as written and written as read", "[replay][third][property]") {
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    CAPTURE(seed);
    const SessionPlan plan = random_plan(seed);
    const Bytes bytes = write_session(plan);
    auto reader = TraceReader::open_bytes(bytes, "test.ttr");
    REQUIRE(reader);
    CHECK(reader->first_tick() == plan.first_tick);
    const ThirdTrace all = read_third(*reader);
    REQUIRE(all.tail.condition == TraceCondition::complete);
    REQUIRE(all.ticks.size() == plan.tick_count);

    // States, cells and stage hashes are those of the session.
    RandomTables state(plan.table_count, plan.seed);
    CellHasher hasher(state.schema());
    Bytes image;
    std::size_t checkpoint = 0;
    double time_s = 0.015625 * static_cast<double>(plan.first_tick);
    for (const ThirdTick& tick : all.ticks) {
      if (checkpoint < all.checkpoints.size() && all.checkpoints[checkpoint].checkpoint.tick == tick.tick.tick) {
        encode_image(state.view(), image);
        REQUIRE(all.checkpoints[checkpoint].checkpoint.image == image);
        const bool is_third = replay::version_of(reader->setup()) == replay::format_version_third;
        REQUIRE(all.checkpoints[checkpoint].time_s == (is_third ? std::optional(time_s) : std::nullopt));
        ++checkpoint;
      }
      state.change(plan.changed_tables);
      time_s += tick.tick.dt;
      REQUIRE(tick.tick.root_hash == root_hash(state.view()));
      REQUIRE(tick.tick.stage_hashes.empty() != reader->setup().has_stages(tick.tick.tick));
      REQUIRE(tick.tick.image.has_value() == reader->setup().is_full(tick.tick.tick));
      encode_image(state.view(), image);
      if (tick.tick.image) REQUIRE(*tick.tick.image == image);
      REQUIRE(tick.cells.has_value() == (plan.detail == Detail::cells));
      StateCells cells;
      hasher.hash(state.view(), 0, cells);
      if (tick.cells) REQUIRE(*tick.cells == cells);
    }
    REQUIRE(checkpoint == all.checkpoints.size());

    const Bytes again = recovered(bytes);
    REQUIRE(again == bytes);
    for (const ThirdCheckpoint& from : all.checkpoints) {
      REQUIRE(reader->seek(from.checkpoint.tick));
      const ThirdTrace rest = read_third(*reader);
      REQUIRE(rest.tail.condition == TraceCondition::complete);
      ThirdTrace expected = all;
      expected.ticks.erase(
          expected.ticks.begin(),
          expected.ticks.begin() + static_cast<std::ptrdiff_t>(from.checkpoint.tick - plan.first_tick));
      std::erase_if(expected.checkpoints,
                    [&](const ThirdCheckpoint& c) { return c.checkpoint.tick < from.checkpoint.tick; });
      require_same(rest, expected);
    }
  }
}

TEST_CASE("other content outside of the chain gives another file of the same content", "[replay][third][property]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    SessionPlan plan = full_plan();
    plan.seed = seed;
    const Bytes one = write_session(plan);
    plan.bound_seed = 1'000 + seed;
    const Bytes other = write_session(plan);
    CHECK(one != other);
    CHECK(content_id(one) == content_id(other));
    const ThirdTrace a = read_third(one), b = read_third(other);
    REQUIRE(a.ticks.size() == b.ticks.size());
    for (std::size_t i = 0; i < a.ticks.size(); ++i) REQUIRE(a.ticks[i].tick == b.ticks[i].tick);
  }
}

TEST_CASE("many notes do not move the chunks of a trace", "[replay][third][property]") {
  SessionPlan plan;
  plan.tick_count = 3'000;
  plan.features = bit(Feature::notes);
  const Bytes one = write_session(plan);
  plan.bound_seed = 7;
  const Bytes other = write_session(plan);
  CHECK(one.size() != other.size());
  CHECK(content_id(one) == content_id(other));
  CHECK(chunk_places(one).size() == chunk_places(other).size());
}

TEST_CASE("a trace of version 3 cut anywhere is truncated, and what it gives is true",
          "[replay][third][truncation][corruption]") {
  const Bytes whole = write_session(full_plan());
  const ThirdTrace contents = read_third(whole);
  const std::size_t setup_end = chunk_places(whole)[1].offset;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CAPTURE(size);
    auto reader = TraceReader::open_bytes(ByteView(whole).first(size), "cut.ttr");
    REQUIRE(reader.has_value() == (size >= setup_end));
    if (!reader) {
      REQUIRE(reader.error().code == ErrorCode::truncated);
      continue;
    }
    const ThirdTrace part = read_third(*reader);
    REQUIRE(part.tail.condition == TraceCondition::truncated);
    REQUIRE(part.tail.offset == size);
    REQUIRE_FALSE(part.tail.message.empty());
    REQUIRE((part.checkpoints.empty() || part.tail.ticks_intact == 7 + part.ticks.size()));
    require_true_part(part, contents);
  }
}

TEST_CASE("every changed byte of a trace of version 3 is refused or reported", "[replay][third][flip][corruption]") {
  SessionPlan with_cells = full_plan();
  with_cells.detail = Detail::cells;
  with_cells.full_first = with_cells.full_last = 0;
  with_cells.tick_count = 6;
  SessionPlan with_images = full_plan();
  with_images.tick_count = 9;
  for (const SessionPlan& plan : {with_cells, with_images}) {
    const Bytes whole = write_session(plan);
    const ThirdTrace contents = read_third(whole);
    Bytes bytes = whole;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      for (const int mask : {0x01, 0x80, 0xff}) {
        CAPTURE(i, mask);
        bytes[i] = static_cast<std::uint8_t>(whole[i] ^ mask);
        auto reader = TraceReader::open_bytes(bytes, "flipped.ttr");
        if (!reader) {
          REQUIRE((reader.error().code == ErrorCode::corrupt || reader.error().code == ErrorCode::truncated ||
                   reader.error().code == ErrorCode::incompatible));
          continue;
        }
        const ThirdTrace part = read_third(*reader);
        REQUIRE(part.tail.condition == TraceCondition::damaged);
        REQUIRE_FALSE(part.tail.message.empty());
        require_true_part(part, contents);
      }
      bytes[i] = whole[i];
    }
  }
}

TEST_CASE("a damaged shown image, save or note is told, and every tick is read", "[replay][third][flip][corruption]") {
  const Bytes whole = write_session(full_plan());
  const ThirdTrace contents = read_third(whole);
  std::size_t content_count = 0;
  for (const ChunkPlace& place : chunk_places(whole)) {
    if (!is_kind(place, ChunkKind::shown) && !is_kind(place, ChunkKind::save)) continue;
    ++content_count;
    for (std::size_t i = 0; i < place.size; ++i) {
      CAPTURE(place.offset, i);
      Bytes bytes = whole;
      bytes[place.offset + i] ^= 0x10;
      const ThirdTrace part = read_third(bytes);
      REQUIRE(part.tail.condition == TraceCondition::damaged);
      REQUIRE(part.tail.offset == place.offset);
      REQUIRE(part.tail.end);
      REQUIRE(part.ticks.size() == contents.ticks.size());
      REQUIRE(part.checkpoints.size() == contents.checkpoints.size());
      require_true_part(part, contents);
      std::size_t missing = 0;
      for (std::size_t c = 0; c < part.checkpoints.size(); ++c) {
        missing += part.checkpoints[c].save != contents.checkpoints[c].save ? 1 : 0;
        missing += part.checkpoints[c].shown != contents.checkpoints[c].shown ? 1 : 0;
      }
      for (std::size_t t = 0; t < part.ticks.size(); ++t)
        missing += part.ticks[t].shown != contents.ticks[t].shown ? 1 : 0;
      // A lost header may hide the other parts of the same state.
      REQUIRE(missing >= 1);
      REQUIRE(missing <= 2);
    }
  }
  CHECK(content_count >= 6);
}

TEST_CASE("a wrong value of the records outside of the chain costs these records alone",
          "[replay][third][flip][corruption]") {
  SessionPlan plan = full_plan();
  plan.detail = Detail::root;
  plan.full_first = plan.full_last = 0;
  plan.checkpoint_interval = 0;
  const Bytes whole = write_session(plan);
  const ThirdTrace contents = read_third(whole);
  const std::vector<ChunkPlace> places = chunk_places(whole);
  const auto ticks = std::find_if(places.begin(), places.end(),
                                  [](const ChunkPlace& place) { return is_kind(place, ChunkKind::ticks); });
  REQUIRE(ticks != places.end());
  // The close record ends with both values of 8 bytes each.
  Bytes bytes = whole;
  bytes[ticks->offset + ticks->size - 16] ^= 1;
  ThirdTrace part = read_third(bytes);
  CHECK(part.tail.condition == TraceCondition::damaged);
  CHECK(contains(part.tail.message, "(ticks): value of the records outside of the chain: found "));
  CHECK(part.tail.end);
  REQUIRE(part.ticks.size() == contents.ticks.size());
  for (std::size_t i = 0; i < part.ticks.size(); ++i) {
    CHECK(part.ticks[i].tick == contents.ticks[i].tick);
    CHECK(part.ticks[i].bound.empty());
  }
  // The same for a byte of a note: the records of the chain prove the ticks.
  std::size_t at = ticks->offset + replay::chunk_header_size;
  for (;;) {
    const replay::Record record =
        replay::parse_record(ByteView(whole).subspan(at), nullptr, replay::format_version_third);
    if (record.tag == static_cast<std::uint8_t>(replay::RecordTag::note)) break;
    at += record.size;
  }
  bytes = whole;
  bytes[at + 6] ^= 1;
  part = read_third(bytes);
  CHECK(part.tail.condition == TraceCondition::damaged);
  CHECK(part.tail.offset == at);
  CHECK(part.ticks.size() == contents.ticks.size());
  bytes = whole;
  bytes[ticks->offset + ticks->size - 1] ^= 1;
  CHECK(read_third(bytes).ticks.empty());
}

/// A trace of one ticks chunk whose notes take more than the reader reads ahead.
Bytes write_long_notes(std::uint64_t tick_count) {
  const TemporaryFolder folder;
  const std::string path = folder.file("notes.ttr");
  SessionPlan plan;
  plan.features = bit(Feature::notes);
  replay::WriterOptions options = plain_writer();
  options.allow_third = true;
  auto writer = replay::TraceWriter::create(path, setup_of(plan), toy_facts, options);
  REQUIRE(writer);
  RandomTables state(plan.table_count, plan.seed);
  REQUIRE(writer->checkpoint(state.view(), root_hash(state.view())));
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    ByteWriter note;
    note.text("log");
    note.bytes(Bytes(4'000, static_cast<std::uint8_t>(tick)));
    REQUIRE(writer->begin_tick({0.015625, Bytes{1}}));
    REQUIRE(writer->bound_record(replay::RecordTag::note, note.view()));
    state.change(1);
    REQUIRE(writer->end_tick(root_hash(state.view()), {}, nullptr));
  }
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  return read_file(path);
}

TEST_CASE("a record outside of the chain that changes while it is read is refused", "[replay][third][corruption]") {
  const Bytes long_chunk = write_long_notes(200);
  const Bytes short_chunk = write_long_notes(20);
  const std::vector<ChunkPlace> places = chunk_places(long_chunk);
  REQUIRE(is_kind(places[3], ChunkKind::ticks));
  REQUIRE(places[3].size > (600u << 10));
  const std::size_t records = places[3].offset + replay::chunk_header_size;
  const replay::Record inputs =
      replay::parse_record(ByteView(long_chunk).subspan(records), nullptr, replay::format_version_third);
  const std::size_t in_note = records + inputs.size + 100;
  const struct {
    const char* name;
    Bytes bytes;
    std::size_t place;  // that changes
  } cases[] = {
      {"note of a chunk that is read in two parts", long_chunk, in_note},
      {"inputs of the same", long_chunk, records + 2},
      {"note of a chunk that is cut off", Bytes(short_chunk.begin(), short_chunk.end() - 2'000), in_note},
  };
  for (const auto& one : cases) {
    CAPTURE(one.name);
    Bytes bytes = one.bytes;
    auto reader = TraceReader::open_bytes(bytes, "changing.ttr");
    REQUIRE(reader);
    // Behind the checkpoint, the reader holds the begin of the ticks chunk already.
    REQUIRE(std::holds_alternative<replay::CheckpointRecord>(reader->next()));
    bytes[one.place] ^= 1;
    CHECK(std::holds_alternative<std::monostate>(reader->next()));
    CHECK(reader->tail().condition == TraceCondition::damaged);
    CHECK(contains(reader->tail().message, "(ticks): the file changed while it was read"));
  }
}

TEST_CASE("removed, doubled and swapped chunks of version 3 are damage", "[replay][third][splice][corruption]") {
  const Bytes whole = write_session(full_plan());
  const ThirdTrace contents = read_third(whole);
  const std::vector<ChunkPlace> places = chunk_places(whole);
  std::vector<ByteView> chunks;
  for (const ChunkPlace& place : places) chunks.push_back(ByteView(whole).subspan(place.offset, place.size));
  const auto require_refused = [&](const std::vector<ByteView>& changed, bool is_bound) {
    Bytes bytes(whole.begin(), whole.begin() + replay::file_header_size);
    for (const ByteView chunk : changed) bytes.insert(bytes.end(), chunk.begin(), chunk.end());
    auto reader = TraceReader::open_bytes(bytes, "spliced.ttr");
    if (!reader) {
      REQUIRE(reader.error().code == ErrorCode::corrupt);
      return;
    }
    const ThirdTrace part = read_third(*reader);
    REQUIRE(part.tail.condition == TraceCondition::damaged);
    require_true_part(part, contents);
    if (is_bound) REQUIRE(part.ticks.size() == contents.ticks.size());
  };
  const auto is_bound = [&](std::size_t i) {
    return is_kind(places[i], ChunkKind::shown) || is_kind(places[i], ChunkKind::save);
  };
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    CAPTURE(i);
    std::vector<ByteView> changed = chunks;
    changed.erase(changed.begin() + static_cast<std::ptrdiff_t>(i));
    if (i + 1 < chunks.size()) require_refused(changed, is_bound(i));
    changed = chunks;
    changed.insert(changed.begin() + static_cast<std::ptrdiff_t>(i), chunks[i]);
    require_refused(changed, is_bound(i));
    for (std::size_t other = 0; other < i; ++other) {
      CAPTURE(other);
      changed = chunks;
      std::swap(changed[i], changed[other]);
      require_refused(changed, false);
    }
  }
}

TEST_CASE("shown images and saves of another recording are not taken", "[replay][third][splice][corruption]") {
  SessionPlan plan = full_plan();
  const Bytes one = write_session(plan);
  plan.seed = 99;  // another state, the same setup
  const Bytes two = write_session(plan);
  const auto save_of = [](const Bytes& bytes) {
    for (const ChunkPlace& place : chunk_places(bytes))
      if (is_kind(place, ChunkKind::save)) return place;
    return ChunkPlace{};
  };
  const ChunkPlace a = save_of(one), b = save_of(two);
  REQUIRE(a.size > 0);
  Bytes mixed(one.begin(), one.begin() + static_cast<std::ptrdiff_t>(a.offset));
  mixed.insert(mixed.end(), two.begin() + static_cast<std::ptrdiff_t>(b.offset),
               two.begin() + static_cast<std::ptrdiff_t>(b.offset + b.size));
  mixed.insert(mixed.end(), one.begin() + static_cast<std::ptrdiff_t>(a.offset + a.size), one.end());
  const ThirdTrace part = read_third(mixed);
  CHECK(part.tail.condition == TraceCondition::damaged);
  require_true_part(part, read_third(one));
}

TEST_CASE("behind damage in a full range, ranges are intact again without a state", "[replay][third][corruption]") {
  SessionPlan plan;
  plan.features = bit(Feature::notes);
  plan.detail = Detail::full;
  plan.full_last = 30;
  plan.tick_count = 24;
  plan.checkpoint_interval = 16;
  const Bytes whole = write_session(plan);
  const std::vector<ChunkPlace> places = chunk_places(whole);
  // setup, facts, checkpoint, then ticks and image of each tick.
  Bytes bytes = whole;
  bytes[places[3 + 2 * 5].offset + 60] ^= 1;
  const ThirdTrace part = read_third(bytes);
  CHECK(part.tail.condition == TraceCondition::damaged);
  CHECK(part.tail.ticks_intact == 5);
  REQUIRE(part.tail.intact_after.size() == 1);
  CHECK(part.tail.intact_after[0].first_tick == 6);
  CHECK(part.tail.intact_after[0].last_tick == 23);
  CHECK(part.tail.intact_after[0].has_checkpoint);
}

TEST_CASE("recovery keeps where a trace begins, its time and what stands outside of the chain",
          "[replay][third][recovery]") {
  const Bytes whole = write_session(full_plan());
  const ThirdTrace contents = read_third(whole);
  const std::vector<ChunkPlace> places = chunk_places(whole);
  for (std::size_t i = 3; i + 3 < places.size(); ++i) {
    CAPTURE(i);
    const Bytes again = recovered(ByteView(whole).first(places[i].offset));
    if (again.empty()) {  // without a tick nothing is written
      CHECK(i <= 5);
      continue;
    }
    auto reader = TraceReader::open_bytes(again, "again.ttr");
    REQUIRE(reader);
    CHECK(reader->first_tick() == 7);
    const ThirdTrace part = read_third(*reader);
    CHECK(part.tail.condition == TraceCondition::complete);
    REQUIRE(part.tail.end);
    require_true_part(part, contents);
  }
}

TEST_CASE("a checkpoint states the largest time where the sum of dt has no finite value",
          "[replay][third][regression]") {
  const TemporaryFolder folder;
  SessionPlan plan;
  plan.features = bit(Feature::saves);
  const RandomTables tables(plan.table_count, plan.seed);
  replay::WriterOptions options = plain_writer();
  options.allow_third = true;
  auto writer = replay::TraceWriter::create(folder.file("a.ttr"), setup_of(plan), {}, options);
  REQUIRE(writer);
  const std::uint64_t root = root_hash(tables.view());
  for (int tick = 0; tick < 3; ++tick) {
    REQUIRE(writer->checkpoint(tables.view(), root));
    REQUIRE(writer->begin_tick({1e308, {}}));
    REQUIRE(writer->end_tick(root, {}, &tables.view()));
  }
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  const ThirdTrace trace = read_third(read_file(folder.file("a.ttr")));
  CHECK(trace.tail.message == "");
  REQUIRE(trace.checkpoints.size() == 3);
  CHECK(trace.checkpoints[1].time_s == 1e308);
  CHECK(trace.checkpoints[2].time_s == std::numeric_limits<double>::max());
}

TEST_CASE("a writer states version 3 only where the setup needs it, and where it may", "[replay][third][version]") {
  const TemporaryFolder folder;
  SessionPlan plan;
  CHECK(replay::version_of(toy_setup(2)) == 1);
  replay::TraceSetup cells = toy_setup(2);
  cells.detail = Detail::cells;
  CHECK(replay::version_of(cells) == 2);
  replay::TraceSetup setup = toy_setup(2);
  setup.stage_interval = 1;
  CHECK(replay::version_of(setup) == 3);
  auto writer = replay::TraceWriter::create(folder.file("a.ttr"), setup, {}, plain_writer());
  REQUIRE(!writer);
  CHECK(writer.error().code == ErrorCode::unsupported);
  CHECK(contains(writer.error().message, "format version 3 is needed"));
  CHECK(!std::filesystem::exists(folder.file("a.ttr")));
  plan.table_count = 300;
  writer = replay::TraceWriter::create(folder.file("a.ttr"), setup_of(plan), {}, plain_writer());
  REQUIRE(!writer);
  CHECK(contains(writer.error().message, "tables: found 300, expected at most 64: a trace holds no more"));
  for (const std::uint32_t feature : {1u, 64u, 1u << 31}) {
    setup = toy_setup(2);
    setup.features = feature;
    CHECK(!replay::check_setup(setup, "x"));
  }
  replay::TraceSetup shown = setup_of(full_plan());
  CHECK(replay::check_setup(shown, "x"));
  shown.features &= ~1u;
  CHECK(!replay::check_setup(shown, "x"));
}

TEST_CASE("of 4,096 tables a tick stores those that changed", "[replay][third][size]") {
  SessionPlan plan;
  plan.table_count = 4'096;
  plan.changed_tables = 1;
  plan.tick_count = 50;
  plan.detail = Detail::full;
  plan.full_last = 100;
  Bytes bytes = write_session(plan);
  ThirdTrace all = read_third(bytes);
  CHECK(all.tail.condition == TraceCondition::complete);
  std::size_t image_size = 0;
  for (const ChunkPlace& place : chunk_places(bytes))
    if (is_kind(place, ChunkKind::image)) image_size += place.size;
  // The first image is relative to the checkpoint as well.
  CHECK(image_size < 50 * 200);
  CHECK(recovered(bytes) == bytes);
  plan.detail = Detail::cells;
  plan.full_last = 0;
  bytes = write_session(plan);
  all = read_third(bytes);
  REQUIRE(all.ticks.size() == 50);
  REQUIRE(all.ticks[49].cells);
  CHECK(all.ticks[49].cells->row_counts.size() == 4'096);
  const std::uint64_t cells_size = 8 * std::uint64_t{all.ticks[49].cells->partition_cells};
  std::size_t ticks_size = 0;
  for (const ChunkPlace& place : chunk_places(bytes))
    if (is_kind(place, ChunkKind::ticks)) ticks_size += place.size;
  // The first record of each chunk lists all tables: about 16 bytes a table with rows, and its numbers.
  CHECK(ticks_size < 2 * 4'096 * 20 + 50 * (cells_size + 60));
}

}  // namespace
}  // namespace ticktrue::test
