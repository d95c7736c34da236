// Encoding and bounded decoding of chunk payloads. The only file that includes zstd.h.
// SPDX-License-Identifier: MIT
#include "replay/format/payload.h"

#include <algorithm>
#include <array>

#include "base/assert.h"
#include "base/limits.h"
#include "replay/format/chunk.h"

#ifdef TICKTRUE_HAS_ZSTD
#include <zstd.h>
#endif

namespace ticktrue::replay {
namespace {

Error corrupt(const std::string& what) {
  return {ErrorCode::corrupt, what, ""};
}

Error over_limit(const std::string& place, const std::string& what, std::uint64_t found, std::uint64_t max) {
  return {ErrorCode::limit,
          place + ": " + what + ": found " + std::to_string(found) + ", expected at most " + std::to_string(max), ""};
}

/// For a setup that states version 3.
Status check_features(const TraceSetup& setup, const std::string& place) {
  if ((setup.features & ~feature_mask) != 0) {
    std::uint32_t bit = feature_count;
    while ((setup.features >> bit & 1) == 0) ++bit;
    return Error{ErrorCode::limit,
                 place + ": setup: features: found bit " + std::to_string(bit) + ", expected bits 0.." +
                     std::to_string(feature_count - 1),
                 "use a newer ticktrue"};
  }
  if (setup.has(Feature::shown) != setup.whole_schema.has_value())
    return Error{ErrorCode::limit,
                 place + ": setup: features: bit 0 (shown columns) is " +
                     (setup.has(Feature::shown) ? "1, and the schema has none" : "0, and the schema has some"),
                 ""};
  if (!setup.whole_schema) return {};
  if (const Status status = check_schema(*setup.whole_schema, SchemaLayout::third); !status)
    return Error{status.error().code, place + ": setup: " + status.error().message, status.error().hint};
  if (!(judged_schema(*setup.whole_schema) == setup.schema))
    return Error{ErrorCode::usage, place + ": setup: schema: is not the judged part of the one with shown columns", ""};
  return {};
}

SchemaLayout layout_of_version(std::uint16_t version) {
  return version >= format_version_third ? SchemaLayout::third : SchemaLayout::first;
}

}  // namespace

std::uint16_t version_of(const TraceSetup& setup) {
  if (setup.features != 0 || setup.stage_interval != 0 || setup.whole_schema ||
      layout_of(setup.schema) == SchemaLayout::third)
    return format_version_third;
  return detail_info(setup.detail).format_version;
}

Bytes StoredState::joined() const {
  Bytes image;
  join_image(tables, image);
  return image;
}

bool has_codec(Codec codec) {
#ifdef TICKTRUE_HAS_ZSTD
  if (codec == Codec::zstd) return true;
#endif
  return codec == Codec::none;
}

Status check_setup(const TraceSetup& setup, const std::string& place) {
  if (setup.simulation.empty() || setup.simulation.size() > limits::name_size_max)
    return Error{ErrorCode::limit,
                 place + ": setup: simulation name: found " + std::to_string(setup.simulation.size()) +
                     " bytes, expected 1.." + std::to_string(limits::name_size_max),
                 ""};
  if (setup.title.size() > limits::name_size_max)
    return over_limit(place, "setup: bytes of the title", setup.title.size(), limits::name_size_max);
  if (!is_dt(setup.dt))
    return Error{ErrorCode::invalid_scene, place + ": setup: dt: found a value that is negative or not finite", ""};
  if (setup.detail == Detail::full ? setup.full_first > setup.full_last : (setup.full_first | setup.full_last) != 0)
    return Error{ErrorCode::usage,
                 place + ": setup: ticks stored in full: found " + std::to_string(setup.full_first) + ".." +
                     std::to_string(setup.full_last) + ", expected first <= last with detail full, else 0..0",
                 ""};
  if (setup.stages.size() > limits::stage_count_max)
    return over_limit(place, "setup: stage count", setup.stages.size(), limits::stage_count_max);
  for (const std::string& stage : setup.stages)
    if (stage.size() > limits::name_size_max)
      return over_limit(place, "setup: bytes of a stage name", stage.size(), limits::name_size_max);
  if (const Status status = check_schema(setup.schema, layout_of_version(version_of(setup))); !status)
    return Error{status.error().code, place + ": setup: " + status.error().message, status.error().hint};
  if (const Status status = check_features(setup, place); !status) return status;
  // The earlier fields take far less than a megabyte per schema table.
  if (setup.setup.size() > limits::setup_size_max - (16u << 20))
    return over_limit(place, "setup: bytes", setup.setup.size(), limits::setup_size_max - (16u << 20));
  return {};
}

void encode_setup(const TraceSetup& setup, ByteWriter& out) {
  out.text(setup.simulation);
  out.u32(setup.physics_version);
  out.text(setup.title);
  out.f64(setup.dt);
  out.u8(static_cast<std::uint8_t>(setup.detail));
  out.u64(setup.full_first);
  out.u64(setup.full_last);
  out.u32(setup.checkpoint_interval);
  const std::uint16_t version = version_of(setup);
  if (version >= format_version_third) {
    out.u32(setup.features);
    out.u32(setup.stage_interval);
  }
  encode_schema(setup.whole_schema ? *setup.whole_schema : setup.schema, out, layout_of_version(version));
  out.u16(static_cast<std::uint16_t>(setup.stages.size()));
  for (const std::string& stage : setup.stages) out.text(stage);
  out.u32(static_cast<std::uint32_t>(setup.setup.size()));
  out.bytes(setup.setup);
}

Result<TraceSetup> decode_setup(ByteView payload, std::uint16_t version) {
  ByteReader in(payload);
  TraceSetup setup;
  setup.simulation = in.text(limits::name_size_max);
  setup.physics_version = in.u32();
  setup.title = in.text(limits::name_size_max);
  setup.dt = in.f64();
  const auto detail = static_cast<Detail>(in.u8());
  setup.full_first = in.u64();
  setup.full_last = in.u64();
  setup.checkpoint_interval = in.u32();
  if (version >= format_version_third) {
    setup.features = in.u32();
    setup.stage_interval = in.u32();
  }
  if (!in.ok()) return corrupt("setup: ends early");
  const auto is_known = [&](const DetailInfo& info) { return info.detail == detail && info.format_version <= version; };
  if (std::none_of(details.begin(), details.end(), is_known))
    return corrupt("setup: detail: found " + std::to_string(static_cast<unsigned>(detail)) + ", expected " +
                   (version == 1 ? "1 or 3 in format version 1" : "1..3"));
  setup.detail = detail;
  Result<StateSchema> schema = decode_schema(in, layout_of_version(version));
  if (!schema) return corrupt("setup: " + schema.error().message);
  if (has_shown_columns(*schema)) {
    setup.schema = judged_schema(*schema);
    setup.whole_schema = std::move(*schema);
  } else {
    setup.schema = std::move(*schema);
  }
  const std::size_t stage_count = in.u16();
  if (stage_count > limits::stage_count_max) return corrupt("setup: too many stages");
  for (std::size_t i = 0; i < stage_count && in.ok(); ++i) setup.stages.push_back(in.text(limits::name_size_max));
  const std::size_t size = in.u32();
  const ByteView rest = in.bytes(size);
  if (!in.ok() || !in.at_end()) return corrupt("setup: sizes do not add up");
  setup.setup.assign(rest.begin(), rest.end());
  if (const Status status = check_setup(setup, "trace"); !status) return corrupt(status.error().message);
  return setup;
}

namespace {

/// Reads the counts of a cells record. Returns the number of bytes that must follow; 0: the counts are wrong.
std::size_t cells_size(const StateSchema& schema, ByteReader& in, StateCells* out) {
  std::size_t columns_size = 0;
  for (const TableSchema& table : schema.tables) {
    const std::uint64_t row_count = in.varint();
    if (row_count > 0xffffffffu) return 0;
    if (row_count > 0) columns_size += 4 * table.columns.size();
    if (out != nullptr) out->row_counts.push_back(static_cast<std::uint32_t>(row_count));
  }
  const std::uint64_t partition_cells = in.varint();
  if (!in.ok() || partition_cells == 0 || partition_cells > partition_cells_max) return 0;
  if (out != nullptr) out->partition_cells = static_cast<std::uint32_t>(partition_cells);
  return columns_size + 2 * partition_count * static_cast<std::size_t>(partition_cells);
}

}  // namespace

void encode_row_cells(const StateCells& cells, ByteWriter& out) {
  // Several bytes at a time: single bytes would cost a tenth of the hashing.
  std::array<std::uint8_t, 2 * 64> bytes;
  std::size_t size = 0;
  for (const std::uint16_t cell : cells.cells) {
    bytes[size++] = static_cast<std::uint8_t>(cell);
    bytes[size++] = static_cast<std::uint8_t>(cell >> 8);
    if (size < bytes.size()) continue;
    out.bytes(bytes);
    size = 0;
  }
  out.bytes(ByteView(bytes).first(size));
}

void encode_cells(const StateCells& cells, const StateSchema& schema, ByteWriter& out) {
  for (const std::uint32_t count : cells.row_counts) out.varint(count);
  out.varint(cells.partition_cells);
  const std::uint32_t* column = cells.columns.data();
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    for (std::size_t c = 0; c < schema.tables[t].columns.size(); ++c, ++column)
      if (cells.row_counts[t] > 0) out.u32(*column);
  encode_row_cells(cells, out);
}

bool check_cells(const StateSchema& schema, ByteView body) {
  ByteReader in(body);
  const std::size_t size = cells_size(schema, in, nullptr);
  return size != 0 && in.remaining() == size;
}

void decode_cells(const StateSchema& schema, ByteView body, StateCells& out) {
  ByteReader in(body);
  out.row_counts.clear();
  const std::size_t size = cells_size(schema, in, &out);
  TICKTRUE_ASSERT(size != 0 && in.remaining() == size);
  out.columns.clear();
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    for (std::size_t c = 0; c < schema.tables[t].columns.size(); ++c)
      out.columns.push_back(out.row_counts[t] > 0 ? in.u32() : 0);
  out.cells.resize(partition_count * out.partition_cells);
  for (std::uint16_t& cell : out.cells) cell = in.u16();
}

StateCells decode_cells(const StateSchema& schema, ByteView body) {
  StateCells cells;
  decode_cells(schema, body, cells);
  return cells;
}

const DetailInfo& detail_info(Detail detail) {
  const auto found =
      std::find_if(details.begin(), details.end(), [&](const DetailInfo& info) { return info.detail == detail; });
  TICKTRUE_ASSERT(found != details.end());
  return *found;
}

Status check_facts(const BuildFacts& facts, const std::string& place) {
  if (facts.size() > fact_count_max) return over_limit(place, "build facts: count", facts.size(), fact_count_max);
  for (const auto& [name, value] : facts)
    if (std::max(name.size(), value.size()) > fact_size_max)
      return over_limit(place, "build facts: bytes of one", std::max(name.size(), value.size()), fact_size_max);
  return {};
}

void encode_facts(const FactsPayload& facts, ByteWriter& out) {
  out.u8(static_cast<std::uint8_t>(facts.codec));
  out.u16(static_cast<std::uint16_t>(facts.facts.size()));
  for (const auto& [name, value] : facts.facts) {
    out.text(name);
    out.text(value);
  }
}

Result<FactsPayload> decode_facts(ByteView payload) {
  ByteReader in(payload);
  FactsPayload facts;
  const std::uint8_t codec = in.u8();
  const std::size_t count = in.u16();
  if (codec > static_cast<std::uint8_t>(Codec::zstd) || count > fact_count_max)
    return corrupt("build facts: found an unknown codec or too many facts");
  facts.codec = static_cast<Codec>(codec);
  for (std::size_t i = 0; i < count && in.ok(); ++i) {
    std::string name = in.text(fact_size_max);
    std::string value = in.text(fact_size_max);
    facts.facts.emplace_back(std::move(name), std::move(value));
  }
  if (!in.ok() || !in.at_end()) return corrupt("build facts: sizes do not add up");
  return facts;
}

void encode_image_part(const ImagePart& part, ByteView raw, bool compress, ByteWriter& out, std::uint16_t version) {
  out.u64(part.root_hash);
  out.u64(part.image_size);
  out.u64(part.offset);
  out.u32(part.size);
  if (version >= format_version_third) out.f64(part.time_s);
#ifdef TICKTRUE_HAS_ZSTD
  if (compress && !raw.empty()) {
    Bytes packed(ZSTD_compressBound(raw.size()));
    constexpr int level = 3;  // the default of zstd
    const std::size_t size = ZSTD_compress(packed.data(), packed.size(), raw.data(), raw.size(), level);
    if (!ZSTD_isError(size) && size < raw.size()) {
      out.u8(static_cast<std::uint8_t>(Codec::zstd));
      out.bytes(ByteView(packed).first(size));
      return;
    }
  }
#else
  static_cast<void>(compress);
#endif
  out.u8(static_cast<std::uint8_t>(Codec::none));
  out.bytes(raw);
}

namespace {

Result<ImagePart> decode_part(ByteView payload, const std::string& what, std::size_t size_max, bool has_time) {
  ByteReader in(payload);
  ImagePart part;
  part.root_hash = in.u64();
  part.image_size = in.u64();
  part.offset = in.u64();
  part.size = in.u32();
  if (has_time) part.time_s = in.f64();
  const std::uint8_t codec = in.u8();
  if (!in.ok()) return corrupt(what + ": ends early");
  if (part.image_size > size_max) return over_limit(what, "size", part.image_size, size_max);
  if (part.offset > part.image_size ||
      part.size != std::min<std::uint64_t>(image_part_size, part.image_size - part.offset) ||
      (part.size == 0 && part.image_size != 0))
    return corrupt(what + ": parts do not add up: found " + std::to_string(part.size) + " bytes at " +
                   std::to_string(part.offset) + " of " + std::to_string(part.image_size));
  if (!is_dt(part.time_s)) return corrupt(what + ": time: found no finite length of time");
  if (codec > static_cast<std::uint8_t>(Codec::zstd))
    return corrupt(what + ": codec: found " + std::to_string(codec) + ", expected 0 or 1");
  part.codec = static_cast<Codec>(codec);
  part.stored = in.bytes(in.remaining());
  return part;
}

}  // namespace

Result<ImagePart> decode_image_part(ByteView payload, std::uint16_t version) {
  return decode_part(payload, "state image", limits::state_image_size_max, version >= format_version_third);
}

Result<ImagePart> decode_content_part(ByteView payload, const std::string& what, std::size_t size_max) {
  return decode_part(payload, what, size_max, false);
}

Status unpack_image_part(const ImagePart& part, Bytes& out) {
  if (part.codec == Codec::none) {
    if (part.stored.size() != part.size)
      return corrupt("state image: stored size: found another, expected the raw size");
    out.insert(out.end(), part.stored.begin(), part.stored.end());
    return {};
  }
#ifdef TICKTRUE_HAS_ZSTD
  const std::size_t start = out.size();
  out.resize(start + part.size);
  const std::size_t size = ZSTD_decompress(out.data() + start, part.size, part.stored.data(), part.stored.size());
  if (ZSTD_isError(size) || size != part.size) {
    out.resize(start);
    return corrupt("state image: zstd: does not unpack to " + std::to_string(part.size) + " bytes");
  }
  return {};
#else
  return Error{ErrorCode::unsupported, "state image: zstd: this build cannot unpack it", "use a build with zstd"};
#endif
}

void encode_end(const EndRecord& end, ByteWriter& out) {
  out.u8(static_cast<std::uint8_t>(end.reason));
  out.text(std::string_view(end.note).substr(0, note_size_max));
}

Result<EndRecord> decode_end(ByteView payload, std::uint64_t tick_count) {
  ByteReader in(payload);
  EndRecord end;
  end.tick_count = tick_count;
  const auto reason = static_cast<EndReason>(in.u8());
  end.note = in.text(note_size_max);
  if (!in.ok() || !in.at_end()) return corrupt("end: sizes do not add up");
  if (std::none_of(end_reasons.begin(), end_reasons.end(),
                   [&](const EndReasonInfo& info) { return info.reason == reason; }))
    return corrupt("end: reason: found " + std::to_string(static_cast<unsigned>(reason)) + ", expected 1..4");
  end.reason = reason;
  return end;
}

void CheckpointIndex::add(const IndexEntry& entry) {
  if (checkpoint_count++ % stride != 0) return;
  entries.push_back(entry);
  if (entries.size() <= index_entry_count_max) return;
  for (std::size_t i = 0; 2 * i < entries.size(); ++i) entries[i] = entries[2 * i];
  entries.resize((entries.size() + 1) / 2);
  stride *= 2;
}

void encode_index(const CheckpointIndex& index, ByteWriter& out) {
  out.u32(index.stride);
  out.u32(static_cast<std::uint32_t>(index.entries.size()));
  for (const IndexEntry& entry : index.entries) {
    out.u64(entry.tick);
    out.u64(entry.offset);
  }
}

Result<CheckpointIndex> decode_index(ByteView payload) {
  ByteReader in(payload);
  CheckpointIndex index;
  index.stride = in.u32();
  const std::size_t count = in.u32();
  if (!in.ok() || index.stride == 0 || count > index_entry_count_max || in.remaining() != 16 * count)
    return corrupt("index: sizes do not add up");
  index.entries.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    IndexEntry entry;
    entry.tick = in.u64();
    entry.offset = in.u64();
    if (i > 0 && (entry.tick <= index.entries.back().tick || entry.offset <= index.entries.back().offset))
      return corrupt("index: entry " + std::to_string(i) + ": found out of order, expected ascending ticks");
    index.entries.push_back(entry);
  }
  return index;
}

void encode_footer(const Footer& footer, ByteWriter& out) {
  out.u64(footer.index_offset);
  out.u64(footer.index_check);
  out.u64(footer.facts_check);
}

Result<Footer> decode_footer(ByteView payload) {
  ByteReader in(payload);
  Footer footer;
  footer.index_offset = in.u64();
  footer.index_check = in.u64();
  footer.facts_check = in.u64();
  if (!in.ok() || !in.at_end()) return corrupt("footer: size: found " + std::to_string(payload.size()));
  return footer;
}

}  // namespace ticktrue::replay
