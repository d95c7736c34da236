// Recipes for forged traces. Each claims more than its bytes hold, or changes data that only a checksum protects.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/limits.h"
#include "base/random.h"
#include "base/state/cells.h"
#include "replay/format/table_list.h"
#include "tests/damage/forger.h"

namespace ticktrue::damage {
namespace {

using replay::ChunkKind;
using replay::RecordTag;

/// The parts of a recording that a recipe changes. All other parts are written unchanged.
struct Changes {
  Bytes setup;                 // the payload
  replay::FactsPayload facts;  // the codec determines whether images may be compressed
  std::size_t tick_count_max = 1000;
  bool closes = true;  // writes end, index and footer
};

Changes unchanged(const Recording& from) {
  Changes changes;
  ByteWriter payload;
  replay::encode_setup(from.setup, payload);
  changes.setup = payload.take();
  changes.facts.codec = replay::has_codec(replay::Codec::zstd) ? replay::Codec::zstd : replay::Codec::none;
  changes.facts.facts = {{"commit", "forged"}};
  return changes;
}

std::uint16_t version_of(const Recording& from) {
  return replay::detail_info(from.setup.detail).format_version;
}

Bytes body_of(std::uint64_t value) {
  ByteWriter out;
  out.u64(value);
  return out.take();
}

/// A random size from 1 to `max`; every order of magnitude is equally likely.
std::uint64_t any_size(Random& random, std::uint64_t max) {
  return static_cast<std::uint64_t>(std::exp2(random.unit() * std::log2(static_cast<double>(max))));
}

void change_bytes(Random& random, Bytes& bytes, std::size_t count) {
  constexpr std::uint8_t likely[] = {0x00, 0x01, 0x7f, 0x80, 0xff};
  for (; count > 0 && !bytes.empty(); --count) {
    const std::size_t at = random.below(bytes.size());
    bytes[at] = random.below(2) == 0 ? likely[random.below(5)] : static_cast<std::uint8_t>(random.below(256));
  }
}

void begin(Forger& forger, const Changes& changes) {
  forger.setup(changes.setup);
  forger.facts(changes.facts);
}

void write_tick(Forger& forger, const Recording& from, const Recording::Tick& tick, double& dt, std::size_t size_max) {
  if (bits_of(tick.dt) != bits_of(dt)) forger.record(RecordTag::dt, body_of(bits_of(tick.dt)));
  dt = tick.dt;
  if (!tick.inputs.empty()) forger.record(RecordTag::inputs, tick.inputs);
  if (!tick.stage_hashes.empty()) {
    ByteWriter hashes;
    for (const std::uint64_t hash : tick.stage_hashes) hashes.u64(hash);
    forger.record(RecordTag::stages, hashes.view());
  }
  if (!tick.cells.empty()) forger.record(RecordTag::cells, tick.cells);
  forger.record(tick.has_image ? RecordTag::root_image : RecordTag::root, body_of(tick.root_hash));
  if (!tick.has_image) return;
  forger.close_ticks();
  forger.image(ChunkKind::image, tick.root_hash, tick.image, tick.image.size(), true, size_max);
  forger.open_ticks();
  dt = from.setup.dt;
}

void finish(Forger& forger, std::uint64_t checkpoint_offset, const std::string& note) {
  ByteWriter end;
  replay::encode_end({replay::EndReason::complete, forger.tick(), note}, end);
  forger.end(end.view());
  replay::CheckpointIndex entries;
  entries.add({0, checkpoint_offset});
  ByteWriter index;
  replay::encode_index(entries, index);
  forger.index(index.view());
  forger.footer(0);
}

/// The recording, with `changes`.
Bytes write(const Recording& from, const Changes& changes, const std::string& note = "") {
  Forger forger(version_of(from));
  begin(forger, changes);
  const std::uint64_t first = forger.size();
  std::size_t next_checkpoint = 0;
  bool is_open = false;
  double dt = from.setup.dt;
  for (std::size_t t = 0;; ++t) {
    if (next_checkpoint < from.checkpoints.size() && from.checkpoints[next_checkpoint].tick == t) {
      const Recording::Checkpoint& checkpoint = from.checkpoints[next_checkpoint++];
      if (is_open) forger.close_ticks();
      is_open = false;
      forger.image(ChunkKind::checkpoint, checkpoint.root_hash, checkpoint.image, checkpoint.image.size(),
                   changes.facts.codec == replay::Codec::zstd, forged_size_max);
    }
    if (t >= from.ticks.size() || t >= changes.tick_count_max || forger.size() > forged_size_max * 3 / 4) break;
    if (!is_open) {
      forger.open_ticks();
      dt = from.setup.dt;
    }
    is_open = true;
    write_tick(forger, from, from.ticks[t], dt, forged_size_max);
  }
  if (is_open) forger.close_ticks();
  if (changes.closes) finish(forger, first, note);
  return forger.take();
}

// ---- Recipes ----

/// An image of the schema with row counts up to the limits. The image holds zeros, so it is small in the file.
Bytes image_head(Random& random, const StateSchema& schema, std::uint64_t image_size, bool is_true) {
  // All rows are in the first table. Its count comes first; the counts of the other tables are zeros at the end.
  const TableSchema& first = schema.tables.front();
  const std::uint64_t rest = 4 * (schema.tables.size() - 1);
  std::uint64_t row_count = image_size < rest + 4 ? 0 : (image_size - rest - 4) / std::max(1u, first.row_size);
  if (!is_true) row_count = random.below(2) == 0 ? 0xffffffffu : row_count + 1 + random.below(1000);
  ByteWriter head;
  head.u32(static_cast<std::uint32_t>(row_count));
  return head.take();
}

Bytes forge_images(const Recording& from, std::uint64_t seed, bool is_true, std::uint64_t count) {
  Random random(seed);
  const Changes changes = unchanged(from);
  Forger forger(version_of(from));
  begin(forger, changes);
  const std::uint64_t first = forger.size();
  const StateSchema& schema = from.setup.schema;
  const std::size_t row_size = std::max(1u, schema.tables.front().row_size);
  const std::size_t at = random.below(2);  // the first image is valid, or invalid as well
  if (at == 1 && !from.checkpoints.empty()) {
    const Recording::Checkpoint& right = from.checkpoints.front();
    forger.image(ChunkKind::checkpoint, right.root_hash, right.image, right.image.size(), true, forged_size_max);
  }
  double dt = from.setup.dt;
  for (std::uint64_t i = 0; i < count && i < from.ticks.size() && forger.size() < forged_size_max * 3 / 4; ++i) {
    if (i > 0 || at == 1) {
      forger.open_ticks();
      dt = from.setup.dt;
      Recording::Tick tick = from.ticks[i];
      tick.has_image = false;
      tick.stage_hashes.clear();
      write_tick(forger, from, tick, dt, forged_size_max);
      forger.close_ticks();
    }
    std::uint64_t size = any_size(random, limits::state_image_size_max);
    if (is_true) size = 4 * schema.tables.size() + size / row_size * row_size;
    const Bytes head = image_head(random, schema, size, is_true);
    forger.image(ChunkKind::checkpoint, random.bits(), head,
                 std::min<std::uint64_t>(size, limits::state_image_size_max), random.below(8) != 0,
                 forged_size_max * 7 / 8);
  }
  if (random.below(3) != 0) finish(forger, first, "");  // otherwise every seek must scan
  return forger.take();
}

Bytes forge_rows(const Recording& from, std::uint64_t seed) {
  return forge_images(from, seed, true, 1);
}
Bytes forge_false_rows(const Recording& from, std::uint64_t seed) {
  return forge_images(from, seed, false, 1 + seed % 3);
}
Bytes forge_many_images(const Recording& from, std::uint64_t seed) {
  return forge_images(from, seed, true, 2000);
}

/// A valid checkpoint before each tick, without an index: every seek scans.
Bytes forge_checkpoints(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  const Changes changes = unchanged(from);
  Forger forger(version_of(from));
  begin(forger, changes);
  const std::uint64_t first = forger.size();
  const Recording::Checkpoint& right = from.checkpoints.front();
  const std::size_t size = any_size(random, forged_size_max - 4096);
  for (std::size_t i = 0; forger.size() < size; ++i) {
    forger.image(ChunkKind::checkpoint, right.root_hash, right.image, right.image.size(), true, size);
    forger.open_ticks();
    forger.record(RecordTag::root, body_of(i < from.ticks.size() ? from.ticks[i].root_hash : i));
    forger.close_ticks();
  }
  if (random.below(2) == 0) finish(forger, first, "");
  return forger.take();
}

Bytes forge_full(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  Recording full = from;
  full.setup.detail = replay::Detail::full;
  full.setup.full_first = 0;
  full.setup.full_last = from.ticks.size();
  const Changes changes = unchanged(full);
  Forger forger(replay::format_version_first);
  begin(forger, changes);
  const std::uint64_t first = forger.size();
  const Recording::Checkpoint& right = from.checkpoints.front();
  forger.image(ChunkKind::checkpoint, right.root_hash, right.image, right.image.size(), true, forged_size_max);
  const std::size_t row_size = std::max(1u, from.setup.schema.tables.front().row_size);
  for (std::size_t i = 0; i < from.ticks.size() && i < 300 && forger.size() < forged_size_max / 2; ++i) {
    forger.open_ticks();
    forger.record(RecordTag::root_image, body_of(random.below(2) == 0 ? from.ticks[i].root_hash : random.bits()));
    forger.close_ticks();
    const std::uint64_t tables = 4 * from.setup.schema.tables.size();
    const std::uint64_t size = tables + any_size(random, limits::state_image_size_max - 4096) / row_size * row_size;
    forger.image(ChunkKind::image, random.bits(), image_head(random, from.setup.schema, size, true), size, true,
                 forged_size_max * 7 / 8);
  }
  finish(forger, first, "");
  return forger.take();
}

Bytes forge_schema(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  Recording made = from;
  StateSchema& schema = made.setup.schema;
  const std::size_t kept = random.below(2) == 0 ? 0 : schema.tables.size();
  schema.tables.resize(kept);
  const std::size_t table_count = kept + random.below(limits::table_count_max - kept) + 1;
  const std::size_t column_count = 1 + random.below(random.below(4) == 0 ? limits::column_count_max : 12);
  while (schema.tables.size() < table_count) {
    TableSchema table;
    table.name =
        std::string(1 + random.below(random.below(4) == 0 ? 250 : 8), 't') + std::to_string(schema.tables.size());
    for (std::size_t c = 0; c < column_count; ++c) {
      Column column;
      column.name = std::string(1 + random.below(12), 'c') + std::to_string(c);
      column.type = ScalarType::u64;
      column.lane_count = static_cast<std::uint8_t>(1 + random.below(limits::row_size_max / 8 / column_count));
      column.offset = static_cast<std::uint16_t>(table.row_size);
      table.row_size += 8u * column.lane_count;
      table.columns.push_back(column);
    }
    schema.tables.push_back(table);
  }
  if (random.below(2) == 0) made.setup.simulation = "simulation_of_somebody";
  made.checkpoints.resize(1);
  made.checkpoints[0].image.assign(4 * schema.tables.size(), 0);
  for (Recording::Tick& tick : made.ticks) tick.cells.clear(), tick.has_image = false, tick.stage_hashes.clear();
  return write(made, unchanged(made));
}

std::string any_text(Random& random, std::size_t size_max) {
  static const std::string pieces[] = {"\x1b[2J",
                                       "\x1b]0;x\a",
                                       "\n::error::x\n",
                                       "\r",
                                       "##[error]x",
                                       "\xc2\x9b"
                                       "31m",
                                       "\xff\xfe",
                                       "</script>",
                                       "&#10;",
                                       "\"",
                                       "\\",
                                       "a",
                                       " ",
                                       "\xe2\x80\xae",
                                       "\x7f",
                                       "%0A"};
  std::string text;
  const std::size_t size = random.below(size_max + 1);
  while (text.size() < size) text += pieces[random.below(std::size(pieces))];
  text.resize(size);
  return text;
}

Bytes forge_texts(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  Recording made = from;
  made.setup.title = any_text(random, limits::name_size_max);
  if (random.below(3) == 0) made.setup.simulation = "x" + any_text(random, limits::name_size_max - 1);
  if (random.below(3) == 0)
    for (std::string& stage : made.setup.stages) stage = "s" + any_text(random, 40);
  if (random.below(3) == 0)
    for (TableSchema& table : made.setup.schema.tables) table.columns.front().name = "c" + any_text(random, 40);
  Changes changes = unchanged(made);
  changes.facts.facts.clear();
  for (std::uint64_t count = random.below(replay::fact_count_max); count > 0; --count)
    changes.facts.facts.emplace_back(any_text(random, 60), any_text(random, random.below(20) == 0 ? 4096 : 60));
  return write(made, changes, any_text(random, replay::note_size_max));
}

Bytes forge_ticks(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  const Changes changes = unchanged(from);
  Forger forger(version_of(from));
  begin(forger, changes);
  const std::uint64_t first = forger.size();
  const Recording::Checkpoint& right = from.checkpoints.front();
  forger.image(ChunkKind::checkpoint, right.root_hash, right.image, right.image.size(), true, forged_size_max);
  const std::size_t size = any_size(random, forged_size_max - 4096);
  const std::uint64_t per_chunk = any_size(random, 100'000);
  while (forger.size() < size) {
    forger.open_ticks();
    for (std::uint64_t i = 0; i < per_chunk && forger.size() < size; ++i)
      forger.record(RecordTag::root,
                    body_of(forger.tick() < from.ticks.size() ? from.ticks[forger.tick()].root_hash : i));
    forger.close_ticks();
  }
  finish(forger, first, "");
  return forger.take();
}

Bytes forge_setup_bytes(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  Recording made = from;
  Bytes& setup = made.setup.setup;
  if (random.below(4) == 0 && setup.size() > 16) {  // repeats a piece of the setup
    const std::size_t at = random.below(setup.size());
    const Bytes piece(setup.begin() + static_cast<std::ptrdiff_t>(at),
                      setup.begin() + static_cast<std::ptrdiff_t>(std::min(setup.size(), at + 1 + random.below(200))));
    for (std::uint64_t count = random.below(forged_size_max / 2 / piece.size()); count > 0; --count)
      setup.insert(setup.end(), piece.begin(), piece.end());
  }
  change_bytes(random, setup, 1 + random.below(4));
  return write(made, unchanged(made));
}

Bytes forge_setup_fields(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  Changes changes = unchanged(from);
  change_bytes(random, changes.setup, 1 + random.below(3));
  return write(from, changes);
}

Bytes forge_values(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  Recording made = from;
  if (random.below(2) == 0) change_bytes(random, made.checkpoints[random.below(made.checkpoints.size())].image, 3);
  if (random.below(2) == 0) made.checkpoints[random.below(made.checkpoints.size())].root_hash ^= 1;
  for (int i = 0; i < 3; ++i) {
    Recording::Tick& tick = made.ticks[random.below(made.ticks.size())];
    if (random.below(3) == 0) change_bytes(random, tick.image, 4);
    if (random.below(3) == 0) tick.root_hash = random.bits();
    if (random.below(3) == 0 && !tick.stage_hashes.empty())
      tick.stage_hashes[random.below(tick.stage_hashes.size())] = 0;
    if (random.below(3) == 0) tick.dt = random.below(2) == 0 ? 0 : std::exp2(random.real(-1070, 1020));
  }
  return write(made, unchanged(made));
}

Bytes forge_cells(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  Recording made = from;
  made.setup.detail = replay::Detail::cells;
  made.setup.full_first = made.setup.full_last = 0;
  StateCells cells;
  for (std::size_t t = 0; t < made.setup.schema.tables.size(); ++t) {
    cells.row_counts.push_back(random.below(2) == 0 ? 0xffffffffu : static_cast<std::uint32_t>(random.below(1u << 31)));
    cells.columns.resize(cells.columns.size() + made.setup.schema.tables[t].columns.size(), 7);
  }
  cells.partition_cells = static_cast<std::uint32_t>(1 + random.below(partition_cells_max));
  cells.cells.assign(partition_count * cells.partition_cells, 1);
  ByteWriter body;
  replay::encode_cells(cells, made.setup.schema, body);
  for (std::size_t i = 0; i < made.ticks.size(); ++i) {
    Recording::Tick& tick = made.ticks[i];
    tick.has_image = false;
    tick.stage_hashes.clear();
    tick.cells = body.view().empty() ? Bytes() : Bytes(body.view().begin(), body.view().end());
    if (i == random.below(20)) tick.root_hash ^= 1;
  }
  return write(made, unchanged(made));
}

Bytes forge_inputs(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  Recording made = from;
  Recording::Tick& tick = made.ticks[random.below(std::min<std::size_t>(made.ticks.size(), 5))];
  for (const Recording::Tick& other : made.ticks)
    if (tick.inputs.empty() && !other.inputs.empty()) tick.inputs = other.inputs;
  if (random.below(2) == 0 && !tick.inputs.empty()) {
    const Bytes piece = tick.inputs;
    for (std::uint64_t count = any_size(random, forged_size_max / 2 / piece.size() + 1); count > 0; --count)
      tick.inputs.insert(tick.inputs.end(), piece.begin(), piece.end());
  } else if (random.below(2) == 0) {
    tick.inputs.assign(any_size(random, forged_size_max / 2), static_cast<std::uint8_t>(random.below(256)));
  }
  change_bytes(random, tick.inputs, random.below(4));
  return write(made, unchanged(made));
}

Bytes forge_index(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  Changes changes = unchanged(from);
  changes.closes = false;
  Forger forger(version_of(from));
  begin(forger, changes);
  const Recording::Checkpoint& right = from.checkpoints.front();
  const std::uint64_t first = forger.size();
  forger.image(ChunkKind::checkpoint, right.root_hash, right.image, right.image.size(), true, forged_size_max);
  forger.open_ticks();
  for (std::size_t i = 0; i < 50; ++i)
    forger.record(RecordTag::root, body_of(i < from.ticks.size() ? from.ticks[i].root_hash : i));
  forger.close_ticks();
  ByteWriter end;
  replay::encode_end({replay::EndReason::complete, forger.tick(), ""}, end);
  forger.end(end.view());
  ByteWriter index;
  const std::uint64_t count = any_size(random, 50'000);
  index.u32(random.below(2) == 0 ? 1 : static_cast<std::uint32_t>(random.bits()));
  index.u32(static_cast<std::uint32_t>(random.below(4) == 0 ? random.bits() : count));
  for (std::uint64_t i = 0; i < count; ++i) {
    index.u64(i * random.below(3));
    index.u64(random.below(2) == 0 ? first : random.bits() >> random.below(64));
  }
  forger.index(index.view());
  forger.footer(random.below(3) == 0 ? random.bits() >> random.below(64) : 0);
  return forger.take();
}

Bytes forge_headers(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  // Damage, followed by as many valid headers as fit. Recovery must try each header.
  Changes changes = unchanged(from);
  changes.closes = false;
  changes.tick_count_max = 5;
  Bytes bytes = write(from, changes);
  Forger forger(version_of(from));
  begin(forger, changes);
  const std::size_t head = forger.size();
  const std::size_t size = any_size(random, forged_size_max - 4096 - bytes.size());
  const std::uint64_t kind = random.below(3);
  while (forger.size() < head + size) {
    if (kind == 0) forger.chunk(0x80, Bytes(random.below(40)));
    if (kind == 1) forger.open_ticks(), forger.close_ticks();
    if (kind == 2) forger.image(ChunkKind::checkpoint, 0, {}, any_size(random, 64u << 20), true, head + size);
  }
  const Bytes behind = forger.take();
  bytes.push_back(0);
  bytes.insert(bytes.end(), behind.begin() + static_cast<std::ptrdiff_t>(head), behind.end());
  return bytes;
}

/// The recording in version 3, with a save after each checkpoint. The saves hold any bytes, and some claim to be
/// larger.
Bytes forge_saves(const Recording& from, std::uint64_t seed) {
  Random random(seed);
  replay::TraceSetup setup = from.setup;
  setup.detail = replay::Detail::root;
  setup.full_first = setup.full_last = 0;
  setup.features = static_cast<std::uint32_t>(replay::Feature::saves);
  Changes changes = unchanged(from);
  ByteWriter payload;
  replay::encode_setup(setup, payload);
  changes.setup = payload.take();
  Forger forger(replay::format_version_third);
  begin(forger, changes);
  const std::uint64_t first = forger.size();
  std::size_t next_checkpoint = 0;
  for (std::size_t t = 0; forger.size() < forged_size_max / 2; ++t) {
    if (next_checkpoint < from.checkpoints.size() && from.checkpoints[next_checkpoint].tick == t) {
      const Recording::Checkpoint& checkpoint = from.checkpoints[next_checkpoint++];
      const Result<std::vector<ImageTable>> tables = split_image(setup.schema, checkpoint.image);
      if (!tables) break;
      std::vector<std::uint32_t> listed;
      for (std::uint32_t i = 0; i < tables->size(); ++i)
        if ((*tables)[i].row_count > 0) listed.push_back(i);
      Bytes list;
      replay::encode_table_list(replay::ListBase::nothing, *tables, listed, list);
      forger.list(ChunkKind::checkpoint, list, list.size(), 0, checkpoint.root_hash);
      Bytes save(random.below(4'096), static_cast<std::uint8_t>(random.bits()));
      change_bytes(random, save, random.below(9));
      const bool lies = random.below(3) == 0;
      forger.content(ChunkKind::save, save, random.below(2) == 0, lies ? any_size(random, std::uint64_t{1} << 40) : 0);
    }
    if (t >= from.ticks.size()) break;
    Recording::Tick tick = from.ticks[t];
    tick.has_image = false;
    tick.stage_hashes.clear();
    tick.cells.clear();
    double dt = setup.dt;
    forger.open_ticks();
    write_tick(forger, from, tick, dt, forged_size_max);
    forger.close_ticks();
  }
  if (random.below(3) != 0) finish(forger, first, "");
  return forger.take();
}

}  // namespace

const std::vector<Recipe>& recipes() {
  static const std::vector<Recipe> list{
      {"rows", "a checkpoint of up to 1 GiB of zeros whose row counts add up", forge_rows},
      {"false_rows", "checkpoints whose row counts claim more than the image has", forge_false_rows},
      {"many_images", "as many checkpoints of up to 1 GiB as fit", forge_many_images},
      {"checkpoints", "a checkpoint before each tick, with and without an index", forge_checkpoints},
      {"full", "ticks with images of up to 1 GiB", forge_full},
      {"schema", "many tables, columns and long names", forge_schema},
      {"texts", "titles, names, facts and notes full of control bytes", forge_texts},
      {"ticks", "as many ticks or chunks as fit", forge_ticks},
      {"setup_bytes", "another setup of the simulation", forge_setup_bytes},
      {"setup_fields", "changed bytes anywhere in the setup chunk", forge_setup_fields},
      {"values", "other values in images, hashes and dt", forge_values},
      {"cells", "cells of states with billions of rows", forge_cells},
      {"inputs", "other inputs, and many", forge_inputs},
      {"index", "an index that leads anywhere", forge_index},
      {"headers", "damage, and right headers behind it", forge_headers},
      {"saves", "format version 3 with saves of any bytes", forge_saves},
  };
  return list;
}

}  // namespace ticktrue::damage
