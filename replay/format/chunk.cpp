// Encoding and checking of chunk headers and tick records.
// SPDX-License-Identifier: MIT
#include "replay/format/chunk.h"

#include <algorithm>

#include "base/assert.h"
#include "base/hash.h"

namespace ticktrue::replay {
namespace {

constexpr std::uint8_t flag_streamed = 1;
constexpr std::size_t record_check_size = 2;

bool has_size_field(std::uint8_t tag, std::uint16_t version) {
  return tag == static_cast<std::uint8_t>(RecordTag::inputs) || tag == static_cast<std::uint8_t>(RecordTag::stages) ||
         tag == static_cast<std::uint8_t>(RecordTag::cells) || tag >= private_kind_first ||
         (version >= format_version_third && tag >= bound_tag_first &&
          tag <= static_cast<std::uint8_t>(RecordTag::note));
}

std::size_t body_size_max(std::uint8_t tag, std::uint16_t version) {
  switch (static_cast<RecordTag>(tag)) {
    case RecordTag::inputs:
      return input_size_max;
    case RecordTag::stages:
      return limits::stage_count_max * 8;
    case RecordTag::cells:
      return version >= format_version_third ? cell_list_size_max : cells_size_max;
    case RecordTag::name:
      return limits::name_size_max;
    case RecordTag::marks:
      return marks_size_max;
    case RecordTag::mark_list:
      return mark_list_size_max;
    case RecordTag::note:
      return 4 + topic_size_max + note_body_size_max;
    default:
      return limits::record_size_max;
  }
}

/// Size of the body of a tag without a size field; 0 for an unknown tag.
std::size_t fixed_body_size(std::uint8_t tag, std::uint16_t version) {
  switch (static_cast<RecordTag>(tag)) {
    case RecordTag::dt:
    case RecordTag::root:
    case RecordTag::root_image:
      return 8;
    case RecordTag::close:
      return version >= format_version_third ? 20 : 12;
    default:
      return 0;
  }
}

void encode_header_fields(const ChunkHeader& header, ByteWriter& out) {
  out.bytes(sync_marker);
  out.u8(header.kind);
  out.u8(header.size == streamed_size ? flag_streamed : 0);
  out.u16(0);
  out.u32(header.sequence);
  out.u32(header.size);
  out.u64(header.tick);
  out.u64(header.chain);
}

/// The earlier chain value, bound to the kind and the place of a chunk. Version 3 leaves out the sequence number,
/// because chunks outside the chain have one too.
std::uint64_t link_of(const ChunkHeader& header, std::uint16_t version) {
  ByteWriter link;
  link.u8(header.kind);
  if (version < format_version_third) link.u32(header.sequence);
  link.u64(header.tick);
  return hash64(link.view(), header.chain);
}

}  // namespace

const ChunkKindInfo* chunk_kind_info(std::uint8_t kind) {
  for (const ChunkKindInfo& info : chunk_kinds)
    if (static_cast<std::uint8_t>(info.kind) == kind) return &info;
  return nullptr;
}

void encode_file_header(ByteWriter& out, std::uint16_t version) {
  const std::size_t start = out.size();
  out.bytes(magic);
  out.u16(version);
  out.u16(0);
  out.u32(static_cast<std::uint32_t>(hash64(out.view().subspan(start))));
}

std::uint64_t chain_start(std::uint16_t version) {
  ByteWriter header;
  encode_file_header(header, version);
  return hash64(header.view());
}

std::uint64_t encode_chunk_header(const ChunkHeader& header, std::uint64_t seed, ByteWriter& out) {
  const std::size_t start = out.size();
  encode_header_fields(header, out);
  const std::uint64_t check = hash64(out.view().subspan(start), seed);
  out.u64(check);
  return check;
}

std::optional<ChunkHeader> decode_chunk_header(ByteView bytes, std::uint64_t seed) {
  TICKTRUE_ASSERT(bytes.size() >= chunk_header_size);
  if (!std::equal(sync_marker.begin(), sync_marker.end(), bytes.begin())) return std::nullopt;
  ByteReader in(bytes.subspan(sync_marker.size(), chunk_header_size - sync_marker.size()));
  ChunkHeader header;
  header.kind = in.u8();
  const std::uint8_t flags = in.u8();
  const std::uint16_t reserved = in.u16();
  header.sequence = in.u32();
  header.size = in.u32();
  header.tick = in.u64();
  header.chain = in.u64();
  header.check = in.u64();
  if (hash64(bytes.first(chunk_header_size - 8), seed) != header.check) return std::nullopt;
  const bool is_streamed = header.kind == static_cast<std::uint8_t>(ChunkKind::ticks);
  if (reserved != 0 || flags != (is_streamed ? flag_streamed : 0)) return std::nullopt;
  if (is_streamed != (header.size == streamed_size)) return std::nullopt;
  return header;
}

bool may_begin_chunk(ByteView part, const ChunkHeader& expected, bool knows_tick) {
  ByteWriter fields;
  encode_header_fields(expected, fields);
  for (std::size_t i = 0; i < part.size() && i < fields.size(); ++i) {
    // Kind, flags and size are unknown in advance.
    const bool is_unknown = i == 4 || i == 5 || (i >= 12 && i < 16) || (!knows_tick && i >= 16 && i < 24);
    if (!is_unknown && part[i] != fields.view()[i]) return false;
  }
  return true;
}

std::uint64_t extend_chain(const ChunkHeader& header, ByteView fields, ByteView data, std::uint16_t version) {
  return hash64(data, hash64(fields, link_of(header, version)));
}

std::uint64_t content_hash(ByteView bytes) {
  constexpr std::size_t block_size = 16 * 1024;
  ByteWriter digest;
  digest.u64(bytes.size());
  for (std::size_t offset = 0; offset < bytes.size(); offset += block_size)
    digest.u64(hash64(bytes.subspan(offset, std::min(block_size, bytes.size() - offset))));
  return hash64(digest.view());
}

Running begin_running(const ChunkHeader& header, std::uint16_t version) {
  if (version < format_version_third) return {header.check, 0};
  return {link_of(header, version), header.check};
}

void append_record(RecordTag tag, ByteView body, std::uint64_t& running, ByteWriter& out) {
  const std::size_t start = out.size();
  const auto tag_byte = static_cast<std::uint8_t>(tag);
  out.u8(tag_byte);
  if (has_size_field(tag_byte, format_version)) out.varint(body.size());
  out.bytes(body);
  running = hash64(out.view().subspan(start), running);
  out.u16(static_cast<std::uint16_t>(running));
}

void append_close(std::uint32_t tick_count, std::uint64_t& running, ByteWriter& out) {
  const std::size_t start = out.size();
  out.u8(static_cast<std::uint8_t>(RecordTag::close));
  out.u32(tick_count);
  running = hash64(out.view().subspan(start), running);
  out.u64(running);
}

void append_close(std::uint32_t tick_count, Running& running, ByteWriter& out) {
  const std::size_t start = out.size();
  out.u8(static_cast<std::uint8_t>(RecordTag::close));
  out.u32(tick_count);
  running.outside = hash64(out.view().subspan(start), running.outside);
  running.chained = hash64(out.view().subspan(start), running.chained);
  out.u64(running.outside);
  out.u64(running.chained);
}

namespace {

/// Checks the whole `record` at the start of `bytes`, and updates the running values.
void check_record(ByteView bytes, Running& running, std::uint16_t version, Record& record) {
  const bool is_close = record.tag == static_cast<std::uint8_t>(RecordTag::close);
  const bool has_outside = version >= format_version_third;
  const std::size_t checks_size = !is_close ? record_check_size : has_outside ? 16 : 8;
  const ByteView checked = bytes.first(record.size - checks_size);
  ByteReader in(bytes.subspan(checked.size(), checks_size));
  const auto is_right = [&](std::uint64_t value) {
    record.check_found = is_close ? in.u64() : in.u16();
    record.check_expected = is_close ? value : value & 0xffff;
    return record.check_found == record.check_expected;
  };
  if (has_outside && (is_close || is_bound_tag(record.tag))) {
    running.outside = hash64(checked, running.outside);
    if (!is_right(running.outside)) record.fault = RecordFault::bad_outside;
    if (!is_close) return;
  }
  const std::uint64_t value = hash64(checked, running.chained);
  const Record of_outside = record;
  if (!is_right(value)) {
    record.fault = RecordFault::bad_check;
    return;
  }
  running.chained = value;
  if (of_outside.fault == RecordFault::bad_outside) record = of_outside;
}

}  // namespace

Record parse_record(ByteView bytes, Running* running, std::uint16_t version) {
  Record record;
  if (bytes.empty()) {
    record.fault = RecordFault::ends_early;
    record.size = 1;
    return record;
  }
  record.tag = bytes[0];
  std::size_t body_offset = 1;
  std::size_t body_size = fixed_body_size(record.tag, version);
  if (has_size_field(record.tag, version)) {
    ByteReader in(bytes.subspan(1));
    const std::uint64_t size = in.varint();
    if (!in.ok()) {
      // The file ends inside the size field, or the size is invalid.
      bool goes_on = bytes.size() < 11;
      for (std::size_t i = 1; i < bytes.size() && goes_on; ++i) goes_on = (bytes[i] & 0x80) != 0;
      record.fault = goes_on ? RecordFault::ends_early : RecordFault::bad_size;
      record.size = bytes.size() + 1;
      return record;
    }
    if (size > body_size_max(record.tag, version) || (size == 0 && record.tag < private_kind_first)) {
      record.fault = RecordFault::bad_size;
      return record;
    }
    body_offset += in.offset();
    body_size = static_cast<std::size_t>(size);
  } else if (body_size == 0) {
    record.fault = RecordFault::unknown_tag;
    return record;
  }
  const bool is_close = record.tag == static_cast<std::uint8_t>(RecordTag::close);
  record.size = body_offset + body_size + (is_close ? 0 : record_check_size);
  if (bytes.size() < record.size) {
    record.fault = RecordFault::ends_early;
    return record;
  }
  record.body = bytes.subspan(body_offset, body_size);
  if (running != nullptr) check_record(bytes, *running, version, record);
  return record;
}

}  // namespace ticktrue::replay
