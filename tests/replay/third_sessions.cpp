// Writes sessions with everything that format version 3 adds.
// SPDX-License-Identifier: MIT
#include "tests/replay/third_sessions.h"

#include <algorithm>

namespace ticktrue::test {
namespace {

using replay::Feature;

constexpr std::uint32_t row_size = 12;

Column column(const std::string& name, ScalarType type, std::uint16_t offset, bool is_shown = false) {
  Column made;
  made.name = name;
  made.type = type;
  made.offset = offset;
  made.is_shown = is_shown;
  return made;
}

Bytes random_bytes(Random& random, std::size_t size_max) {
  Bytes bytes(random.below(size_max + 1));
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
  return bytes;
}

std::optional<Bytes> copy(const std::optional<ByteView>& bytes) {
  return bytes ? std::optional<Bytes>(Bytes(bytes->begin(), bytes->end())) : std::nullopt;
}

bool has(const SessionPlan& plan, Feature feature) {
  return (plan.features & static_cast<std::uint32_t>(feature)) != 0;
}

void write_bound(replay::TraceWriter& writer, const SessionPlan& plan, std::uint64_t tick, Random& random,
                 bool& has_name) {
  if (has(plan, Feature::notes) && random.below(3) == 0) {
    ByteWriter note;
    note.text("topic" + std::to_string(random.below(3)));
    note.bytes(random_bytes(random, 30));
    REQUIRE(writer.bound_record(replay::RecordTag::note, note.view()));
  }
  if (!has(plan, Feature::marks) || random.below(2) == 0) return;
  const std::string name = "rand";
  // Each chunk defines its names again: here each name occurs first behind a checkpoint.
  if (!has_name)
    REQUIRE(writer.bound_record(replay::RecordTag::name,
                                {reinterpret_cast<const std::uint8_t*>(name.data()), name.size()}));
  has_name = true;
  ByteWriter marks;
  marks.u64(random.bits());
  marks.varint(1);
  marks.varint(0);
  marks.varint(1 + random.below(300));
  marks.u32(static_cast<std::uint32_t>(tick));
  REQUIRE(writer.bound_record(replay::RecordTag::marks, marks.view()));
}

}  // namespace

RandomTables::RandomTables(std::size_t table_count, std::uint64_t seed) : random_(seed), rows_(table_count) {
  for (std::size_t t = 0; t < table_count; ++t) {
    TableSchema table;
    table.name = "table" + std::to_string(t);
    table.row_size = row_size;
    table.columns = {column("a", ScalarType::u64, 0), column("b", ScalarType::i16, 8), column("c", ScalarType::i8, 10),
                     column("d", ScalarType::u8, 11)};
    schema_.tables.push_back(table);
  }
  for (std::size_t t = 0; t < table_count; ++t)
    if (random_.below(3) != 0) rows_[t] = Bytes(row_size * (1 + random_.below(4)), static_cast<std::uint8_t>(t));
  refresh();
}

void RandomTables::change(std::size_t table_count) {
  for (std::size_t i = 0; i < table_count; ++i) {
    Bytes& rows = rows_[random_.below(rows_.size())];
    const std::uint64_t kind = random_.below(8);
    if (kind == 0) rows.clear();
    if (kind == 1) rows.resize(rows.size() + row_size, static_cast<std::uint8_t>(i));
    if (kind > 1 && !rows.empty()) rows[random_.below(rows.size())] = static_cast<std::uint8_t>(random_.bits());
  }
  refresh();
}

void RandomTables::refresh() {
  view_.schema = &schema_;
  view_.tables.clear();
  for (const Bytes& rows : rows_)
    view_.tables.push_back({rows.data(), static_cast<std::uint32_t>(rows.size() / row_size)});
}

replay::TraceSetup setup_of(const SessionPlan& plan) {
  replay::TraceSetup setup;
  setup.simulation = "ticktrue.many";
  setup.title = "many tables";
  setup.dt = 0.015625;
  setup.detail = plan.detail;
  setup.full_first = plan.full_first;
  setup.full_last = plan.full_last;
  setup.checkpoint_interval = plan.checkpoint_interval;
  setup.features = plan.features;
  setup.stage_interval = plan.stage_interval;
  setup.schema = RandomTables(plan.table_count, plan.seed).schema();
  if (plan.has_shown) {
    setup.features |= static_cast<std::uint32_t>(Feature::shown);
    setup.whole_schema = setup.schema;
    TableSchema& table = setup.whole_schema->tables[0];
    table.columns.push_back(column("glow", ScalarType::f32, 0, true));
    table.shown_row_size = 4;
  }
  setup.stages = {"move", "solve"};
  setup.setup = {1, 2, 3};
  return setup;
}

Bytes write_session(const SessionPlan& plan) {
  const TemporaryFolder folder;
  const std::string path = folder.file("session.ttr");
  replay::WriterOptions options = plain_writer();
  options.allow_third = true;
  options.compress = plan.compress;
  const replay::TraceSetup setup = setup_of(plan);
  auto writer = replay::TraceWriter::create(path, setup, toy_facts, options);
  if (!writer) FAIL(writer.error().message);
  if (plan.first_tick > 0) writer->begin_at(plan.first_tick, 0.015625 * static_cast<double>(plan.first_tick));
  RandomTables state(plan.table_count, plan.seed);
  Random random(plan.seed + 100);
  Random bound(plan.bound_seed);
  bool has_name = false;
  for (std::uint64_t tick = plan.first_tick; tick < plan.first_tick + plan.tick_count; ++tick) {
    if (writer->wants_checkpoint()) {
      REQUIRE(writer->checkpoint(state.view(), root_hash(state.view())));
      if (plan.has_shown) REQUIRE(writer->shown(random_bytes(bound, 40)));
      if (has(plan, Feature::saves) && bound.below(4) != 0) REQUIRE(writer->save(random_bytes(bound, 60)));
      has_name = false;
    }
    const Bytes inputs = random_bytes(random, random.below(2) * 9);
    REQUIRE(writer->begin_tick({random.below(5) == 0 ? 0.03125 : 0.015625, inputs}));
    write_bound(*writer, plan, tick, bound, has_name);
    state.change(plan.changed_tables);
    const std::uint64_t root = root_hash(state.view());
    const bool is_full = writer->wants_full();
    REQUIRE(writer->end_tick(root, std::vector<std::uint64_t>{root + 1, root}, &state.view()));
    if (is_full) has_name = false;
    if (is_full && plan.has_shown && bound.below(3) != 0) REQUIRE(writer->shown(random_bytes(bound, 40)));
  }
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  return read_file(path);
}

ThirdTrace read_third(replay::TraceReader& reader) {
  ThirdTrace all;
  for (;;) {
    const auto& item = reader.next();
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) {
      ThirdTick read;
      read.tick = {tick->tick,      tick->dt,           Bytes(tick->inputs.begin(), tick->inputs.end()),
                   tick->root_hash, tick->stage_hashes, {}};
      if (tick->image) read.tick.image = tick->image->joined();
      if (tick->cells != nullptr) read.cells = *tick->cells;
      read.shown = copy(tick->shown);
      for (const replay::BoundRecord& record : tick->bound)
        read.bound.emplace_back(record.tag, Bytes(record.body.begin(), record.body.end()));
      all.ticks.push_back(std::move(read));
    } else if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
      const Bytes image(checkpoint->image.begin(), checkpoint->image.end());
      all.checkpoints.push_back({{checkpoint->tick, checkpoint->root_hash, image},
                                 checkpoint->time_s,
                                 copy(checkpoint->shown),
                                 copy(checkpoint->save)});
    } else {
      all.tail = reader.tail();
      return all;
    }
  }
}

ThirdTrace read_third(ByteView bytes) {
  auto reader = replay::TraceReader::open_bytes(bytes, "test.ttr");
  if (!reader) FAIL(reader.error().message);
  return read_third(*reader);
}

void require_true_part(const ThirdTrace& part, const ThirdTrace& whole) {
  REQUIRE(part.ticks.size() <= whole.ticks.size());
  REQUIRE(part.checkpoints.size() <= whole.checkpoints.size());
  for (std::size_t i = 0; i < part.ticks.size(); ++i) {
    const ThirdTick& got = part.ticks[i];
    const ThirdTick& expected = whole.ticks[i];
    ReadTick tick = expected.tick;
    if (!got.tick.image) tick.image.reset();  // the last one may be cut off
    if (i + 1 < part.ticks.size()) REQUIRE(got.tick.image.has_value() == expected.tick.image.has_value());
    REQUIRE(got.tick == tick);
    REQUIRE(got.cells == expected.cells);
    if (got.shown) REQUIRE(got.shown == expected.shown);
    if (!got.bound.empty()) REQUIRE(got.bound == expected.bound);
  }
  for (std::size_t i = 0; i < part.checkpoints.size(); ++i) {
    const ThirdCheckpoint& got = part.checkpoints[i];
    const ThirdCheckpoint& expected = whole.checkpoints[i];
    REQUIRE(got.checkpoint == expected.checkpoint);
    REQUIRE(got.time_s == expected.time_s);
    if (got.shown) REQUIRE(got.shown == expected.shown);
    if (got.save) REQUIRE(got.save == expected.save);
  }
}

void require_same(const ThirdTrace& part, const ThirdTrace& whole) {
  require_true_part(part, whole);
  REQUIRE(part.ticks.size() == whole.ticks.size());
  REQUIRE(part.checkpoints.size() == whole.checkpoints.size());
  for (std::size_t i = 0; i < part.ticks.size(); ++i) {
    REQUIRE(part.ticks[i].bound == whole.ticks[i].bound);
    REQUIRE(part.ticks[i].shown == whole.ticks[i].shown);
    REQUIRE(part.ticks[i].tick == whole.ticks[i].tick);
  }
  for (std::size_t i = 0; i < part.checkpoints.size(); ++i) {
    REQUIRE(part.checkpoints[i].shown == whole.checkpoints[i].shown);
    REQUIRE(part.checkpoints[i].save == whole.checkpoints[i].save);
  }
}

Bytes recovered(ByteView bytes) {
  const TemporaryFolder folder;
  write_file(folder.file("in.ttr"), bytes);
  const auto result = replay::recover_trace(folder.file("in.ttr"), folder.file("out.ttr"), false);
  if (!result) FAIL(result.error().message);
  return read_file(folder.file("out.ttr"));
}

std::uint64_t content_id(ByteView trace) {
  const std::vector<ChunkPlace> places = chunk_places(trace);
  // The index stands behind the end, with the chain value before it in bytes 24..31 of its header.
  return ByteReader(trace.subspan(places[places.size() - 2].offset + 24, 8)).u64();
}

}  // namespace ticktrue::test
