// Reads chunk after chunk. A chunk is verified before any record of it is returned.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/hash.h"
#include "base/limits.h"
#include "replay/trace_reader_impl.h"

namespace ticktrue::replay {
namespace {

constexpr std::size_t ticks_view_size = 32u << 10;  // a usual ticks chunk: 1024 ticks of 11 bytes and their inputs

bool is_dt(double dt) {
  return std::isfinite(dt) && dt >= 0;
}

std::string hex16(std::uint64_t value) {
  return hex32(static_cast<std::uint32_t>(value)).substr(4);
}

std::string kind_name(std::uint8_t kind) {
  if (const ChunkKindInfo* info = chunk_kind_info(kind)) return std::string(info->name);
  return kind >= private_kind_first ? "private" : "unknown";
}

}  // namespace

ByteView TraceReader::Impl::view(std::uint64_t offset, std::size_t size) {
  const bool is_inside = offset >= window_offset && offset - window_offset <= window.size() &&
                         size <= window.size() - static_cast<std::size_t>(offset - window_offset);
  if (!is_inside) {
    file.read(offset, std::max(size, read_ahead_size), window);
    window_offset = offset;
    ++window_reads;
  }
  const auto at = static_cast<std::size_t>(offset - window_offset);
  return ByteView(window).subspan(at, std::min(size, window.size() - at));
}

std::string TraceReader::Impl::chunk_text(std::uint8_t kind) const {
  return "chunk " + std::to_string(cursor.sequence) + " (" + kind_name(kind) + ")";
}

Step TraceReader::Impl::stop(TraceCondition condition, std::uint64_t offset, const std::string& what) {
  fault = Fault{condition, offset, "offset " + std::to_string(offset) + ": " + what};
  return Step::stop;
}

ChunkHeader TraceReader::Impl::expected_header() const {
  ChunkHeader header;
  header.sequence = cursor.sequence;
  header.tick = cursor.tick;
  header.chain = cursor.chain;
  return header;
}

std::optional<ChunkHeader> TraceReader::Impl::read_header(std::uint64_t header_seed) {
  const std::string place = "chunk " + std::to_string(cursor.sequence);
  const ByteView bytes = view(cursor.offset, chunk_header_size);
  if (bytes.size() < chunk_header_size) {
    if (may_begin_chunk(bytes, expected_header()))
      truncated("the file ends before " + place + " is whole: found " + std::to_string(bytes.size()) +
                " bytes, expected at least " + std::to_string(chunk_header_size));
    else
      damaged(cursor.offset, place + ": header: found other bytes than a chunk begins with");
    return std::nullopt;
  }
  const std::optional<ChunkHeader> header = decode_chunk_header(bytes, header_seed);
  if (!header) {
    damaged(cursor.offset, place + ": header: its check does not match");
    return std::nullopt;
  }
  if (header->sequence != cursor.sequence)
    damaged(cursor.offset, place + ": order: found chunk " + std::to_string(header->sequence) + ", expected " +
                               std::to_string(cursor.sequence));
  else if (header->chain != cursor.chain)
    damaged(cursor.offset,
            place + ": chain value: found " + hex64(header->chain) + ", expected " + hex64(cursor.chain));
  else if (header->tick != cursor.tick)
    damaged(cursor.offset, place + ": first tick: found " + std::to_string(header->tick) + ", expected " +
                               std::to_string(cursor.tick));
  else
    return header;
  return std::nullopt;
}

std::optional<ByteView> TraceReader::Impl::read_payload(const ChunkHeader& header, std::size_t size_max) {
  if (header.size > size_max) {
    damaged(cursor.offset, chunk_text(header.kind) + ": size: found " + std::to_string(header.size) +
                               ", expected at most " + std::to_string(size_max));
    return std::nullopt;
  }
  const std::uint64_t whole = whole_size(header);
  if (whole > remaining()) {
    truncated("the file ends inside " + chunk_text(header.kind) + ": found " + std::to_string(remaining()) +
              " bytes of it, expected " + std::to_string(whole));
    return std::nullopt;
  }
  const ByteView bytes = view(cursor.offset, static_cast<std::size_t>(whole));
  if (bytes.size() < whole) {
    truncated("cannot read " + chunk_text(header.kind));
    return std::nullopt;
  }
  const ByteView payload = bytes.subspan(chunk_header_size, header.size);
  const std::uint64_t expected = hash64(payload, header.check);
  const std::uint64_t found = ByteReader(bytes.last(chunk_trailer_size)).u64();
  if (found != expected) {
    damaged(cursor.offset,
            chunk_text(header.kind) + ": checksum: found " + hex64(found) + ", expected " + hex64(expected));
    return std::nullopt;
  }
  return payload;
}

void TraceReader::Impl::pass(const ChunkHeader& header) {
  cursor.offset += whole_size(header);
  ++cursor.sequence;
}

Step TraceReader::Impl::read_chunk() {
  if (fault) return Step::stop;
  if (cursor.phase == Phase::closed) {
    if (remaining() == 0) return stop(TraceCondition::complete, file.size(), "");
    return damaged(cursor.offset, "behind the footer: found " + std::to_string(remaining()) +
                                      " more bytes, expected the end of the file");
  }
  if (remaining() == 0)
    return truncated("the file ends before chunk " + std::to_string(cursor.sequence) + ": expected " +
                     (cursor.phase == Phase::body ? "more ticks or an end" : "index and footer"));
  const std::optional<ChunkHeader> header = read_header(seed);
  if (!header) return Step::stop;
  if (const char* wanted = wanted_kind(*header))
    return damaged(cursor.offset,
                   chunk_text(header->kind) + ": kind: found " + std::to_string(header->kind) + ", expected " + wanted);
  if (header->kind >= private_kind_first) return read_private(*header);
  switch (static_cast<ChunkKind>(header->kind)) {
    case ChunkKind::ticks:
      return read_ticks(*header);
    case ChunkKind::checkpoint:
    case ChunkKind::image:
      return read_image_part(*header);
    case ChunkKind::end:
      return read_end(*header);
    case ChunkKind::index:
      return read_index(*header);
    default:
      return read_footer(*header);
  }
}

const char* TraceReader::Impl::wanted_kind(const ChunkHeader& header) const {
  const auto is = [&](ChunkKind kind) { return header.kind == static_cast<std::uint8_t>(kind); };
  if (cursor.phase == Phase::index) return is(ChunkKind::index) ? nullptr : "the index";
  if (cursor.phase == Phase::footer) return is(ChunkKind::footer) ? nullptr : "the footer";
  if (cursor.part_kind != 0) return header.kind == cursor.part_kind ? nullptr : "the next part of a state image";
  if (cursor.expects_image) return is(ChunkKind::image) ? nullptr : "the image of the last tick";
  if (header.kind >= private_kind_first) return cursor.has_pending ? "the end" : nullptr;
  if (is(ChunkKind::end)) return nullptr;
  if (cursor.has_pending) return "the end, since inputs of an unfinished tick came before";
  if (is(ChunkKind::checkpoint)) {
    if (!cursor.has_checkpoint) return header.tick == 0 ? nullptr : "the checkpoint at tick 0 first";
    return header.tick > cursor.last_checkpoint ? nullptr : "at most one checkpoint for a tick";
  }
  if (is(ChunkKind::ticks)) return cursor.has_checkpoint ? nullptr : "the checkpoint at tick 0 first";
  return "checkpoint, ticks or end";
}

Step TraceReader::Impl::read_private(const ChunkHeader& header) {
  const std::optional<ByteView> payload = read_payload(header, limits::chunk_size_max);
  if (!payload) return Step::stop;
  cursor.chain = extend_chain(header, {}, *payload);
  pass(header);
  return Step::passed;
}

Step TraceReader::Impl::read_ticks(const ChunkHeader& header) {
  std::uint64_t running = header.check;
  std::size_t at = chunk_header_size;  // of the next record
  std::size_t ticks_end = at;          // behind the last root record
  std::uint64_t tick = cursor.tick;
  double dt = setup.dt;
  bool has_image = false;
  std::uint8_t last_tag = 0;  // in the tick: records come in the order of their tags
  bool is_pending = false;    // dt or inputs came, the root hash not yet
  std::size_t inputs_offset = 0, inputs_size = 0;
  std::size_t want = ticks_view_size;
  ByteView bytes = view(cursor.offset, want);
  const std::uint64_t reads = window_reads;
  for (;;) {
    const Record record = parse_record(bytes.subspan(at), &running);
    const std::uint64_t place = cursor.offset + at;
    if (record.fault == RecordFault::ends_early) {
      if (at + record.size > limits::chunk_size_max)
        return damaged(place, chunk_text(header.kind) + ": size: found more than " +
                                  std::to_string(limits::chunk_size_max) + " bytes");
      if (bytes.size() < want || place + record.size > file.size()) break;
      want = std::min(std::max(at + record.size, 2 * want), limits::chunk_size_max);
      bytes = view(cursor.offset, want);
      if (window_reads != reads && !is_as_read(bytes, at, header.check, running)) return changed(header);
      continue;
    }
    if (record.fault != RecordFault::none) return damaged(place, chunk_text(header.kind) + ": " + fault_text(record));
    if (has_image && record.tag != static_cast<std::uint8_t>(RecordTag::close))
      return damaged(place, chunk_text(header.kind) + ": found a record behind a tick with image, expected close");
    if (record.tag < private_kind_first && record.tag != static_cast<std::uint8_t>(RecordTag::close)) {
      if (record.tag <= last_tag)
        return damaged(place, chunk_text(header.kind) + ": record order: found tag " + std::to_string(record.tag) +
                                  " after " + std::to_string(last_tag));
      last_tag = record.tag;
      is_pending = is_pending || record.tag <= static_cast<std::uint8_t>(RecordTag::inputs);
    }
    const std::size_t body_offset = static_cast<std::size_t>(record.body.data() - bytes.data());
    at += record.size;
    switch (static_cast<RecordTag>(record.tag)) {
      case RecordTag::dt:
        dt = ByteReader(record.body).f64();
        if (!is_dt(dt)) return damaged(place, chunk_text(header.kind) + ": dt: found no finite length of time");
        break;
      case RecordTag::inputs:
        inputs_offset = body_offset;
        inputs_size = record.body.size();
        break;
      case RecordTag::stages:
        if (!is_full(tick) || record.body.size() != 8 * setup.stages.size())
          return damaged(place, chunk_text(header.kind) + ": stage hashes: found " +
                                    std::to_string(record.body.size() / 8) + " where the setup has none or " +
                                    std::to_string(setup.stages.size()));
        break;
      case RecordTag::cells:
        if (setup.detail != Detail::cells || !check_cells(setup.schema, record.body))
          return damaged(place, chunk_text(header.kind) + ": cells: found " + std::to_string(record.body.size()) +
                                    " bytes where the setup has no cells, or whose counts do not add up");
        break;
      case RecordTag::root_image:
        if (!is_full(tick))
          return damaged(place, chunk_text(header.kind) + ": image: found one of a tick not stored in full");
        has_image = true;
        [[fallthrough]];
      case RecordTag::root:
        ++tick;
        if (tick > limits::tick_count_max)
          return damaged(place, chunk_text(header.kind) + ": tick count: found more than " +
                                    std::to_string(limits::tick_count_max));
        ticks_end = at;
        last_tag = 0;
        is_pending = false;
        inputs_size = 0;
        break;
      case RecordTag::close: {
        const std::uint32_t count = ByteReader(record.body).u32();
        if (count != tick - cursor.tick)
          return damaged(place, chunk_text(header.kind) + ": tick count: found " + std::to_string(count) +
                                    ", expected " + std::to_string(tick - cursor.tick));
        if (last_tag > static_cast<std::uint8_t>(RecordTag::inputs))
          return damaged(place,
                         chunk_text(header.kind) + ": found " +
                             (last_tag == static_cast<std::uint8_t>(RecordTag::stages) ? "stage hashes" : "cells") +
                             " without a root hash");
        set_ticks(bytes, ticks_end, tick);
        if (is_pending) set_pending(dt, bytes.subspan(inputs_offset, inputs_size));
        cursor.offset += at;
        ++cursor.sequence;
        cursor.chain = running;
        cursor.expects_image = has_image;
        return walk_end > 0 ? Step::ticks : Step::passed;
      }
      default:
        break;  // private
    }
  }
  // A flipped size can look like a truncated file: then an intact chunk follows.
  std::uint64_t behind = cursor.offset + at;
  const std::uint64_t cut = behind;
  if (find_header(behind))
    return damaged(cut, chunk_text(header.kind) + ": found a record that does not end before the next chunk");
  truncated("the file ends inside " + chunk_text(header.kind) + ": found " + std::to_string(tick - cursor.tick) +
            " whole ticks of it");
  bytes = view(cursor.offset, at);
  if (!is_as_read(bytes, at, header.check, running)) return changed(header);
  set_ticks(bytes, ticks_end, tick);
  if (is_pending) set_pending(dt, bytes.subspan(inputs_offset, inputs_size));
  return walk_end > 0 ? Step::ticks : Step::stop;
}

bool TraceReader::Impl::is_as_read(ByteView bytes, std::size_t end, std::uint64_t check, std::uint64_t running) {
  if (bytes.size() < end) return false;
  std::size_t at = chunk_header_size;
  while (at < end) {
    const Record record = parse_record(bytes.first(end).subspan(at), &check);
    if (record.fault != RecordFault::none) return false;
    at += record.size;
  }
  return check == running;
}

bool TraceReader::Impl::is_full(std::uint64_t tick) const {
  return setup.detail == Detail::full && setup.full_first <= tick && tick <= setup.full_last;
}

std::string TraceReader::Impl::fault_text(const Record& record) {
  switch (record.fault) {
    case RecordFault::unknown_tag:
      return "record tag: found " + std::to_string(record.tag) + ", expected 1..6, 15 or 128..255";
    case RecordFault::bad_size:
      return "record size: found one that is not allowed for tag " + std::to_string(record.tag);
    default:
      if (record.tag != static_cast<std::uint8_t>(RecordTag::close))
        return "record check: found " + hex16(record.check_found) + ", expected " + hex16(record.check_expected);
      return "chain value: found " + hex64(record.check_found) + ", expected " + hex64(record.check_expected);
  }
}

void TraceReader::Impl::set_ticks(ByteView bytes, std::size_t ticks_end, std::uint64_t tick) {
  records.assign(bytes.begin() + chunk_header_size, bytes.begin() + static_cast<std::ptrdiff_t>(ticks_end));
  walk_offset = 0;
  walk_end = records.size();
  walk_tick = cursor.tick;
  walk_dt = setup.dt;
  walk_file_offset = cursor.offset + chunk_header_size;
  cursor.tick = tick;
}

void TraceReader::Impl::set_pending(double dt, ByteView inputs) {
  cursor.has_pending = true;
  cursor.pending_dt = dt;
  cursor.pending_inputs.assign(inputs.begin(), inputs.end());
}

Step TraceReader::Impl::read_end(const ChunkHeader& header) {
  const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
  if (!payload) return Step::stop;
  Result<EndRecord> decoded = decode_end(*payload, header.tick);
  if (!decoded) return damaged(cursor.offset, decoded.error().message);
  end = std::move(*decoded);
  cursor.chain = extend_chain(header, {}, *payload);
  pass(header);
  cursor.phase = Phase::index;
  return Step::passed;
}

Step TraceReader::Impl::read_index(const ChunkHeader& header) {
  const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
  index_offset = cursor.offset;
  if (payload) {
    index_check = hash64(*payload, header.check);
    const Result<CheckpointIndex> index = decode_index(*payload);
    if (!index)
      damaged(cursor.offset, index.error().message);
    else if (is_sequential && (index->stride != seen.stride || index->entries != seen.entries))
      damaged(cursor.offset, "index: found other places than the checkpoints have");
  }
  if (fault) {
    // All ticks have been read, and the header locates the footer: continue, and report the damage at the end.
    if (fault->condition == TraceCondition::truncated || whole_size(header) > remaining()) return Step::stop;
    note_damage(*std::exchange(fault, std::nullopt));
  }
  pass(header);
  cursor.phase = Phase::footer;
  return Step::passed;
}

Step TraceReader::Impl::read_footer(const ChunkHeader& header) {
  const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
  if (!payload) return Step::stop;
  const Result<Footer> footer = decode_footer(*payload);
  if (!footer) return damaged(cursor.offset, footer.error().message);
  if (footer->index_offset != index_offset || (index_check && footer->index_check != *index_check))
    return damaged(cursor.offset, "footer: found the place or checksum of another index");
  if (!facts_fault && footer->facts_check != facts_check)
    return damaged(cursor.offset, "footer: build facts: found checksum " + hex64(facts_check) + ", expected " +
                                      hex64(footer->facts_check) + " (they belong to another recording)");
  pass(header);
  cursor.phase = Phase::closed;
  return Step::passed;
}

}  // namespace ticktrue::replay
