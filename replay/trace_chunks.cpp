// Reads chunk after chunk. A chunk is verified before its records are returned.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "base/hash.h"
#include "base/limits.h"
#include "replay/trace_reader_impl.h"

namespace ticktrue::replay {
namespace {

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
    if (may_begin_chunk(bytes, expected_header(), cursor.has_checkpoint || !setup.has(Feature::tail)))
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
  std::optional<ChunkHeader> header = read_header(seed);
  if (!header) header = find_behind_lost();
  if (!header) return Step::stop;
  if (const char* wanted = wanted_kind(*header))
    return damaged(cursor.offset,
                   chunk_text(header->kind) + ": kind: found " + std::to_string(header->kind) + ", expected " + wanted);
  const auto kind = static_cast<ChunkKind>(header->kind);
  if (kind == ChunkKind::shown || kind == ChunkKind::save) return read_content_part(*header);
  if (kind == ChunkKind::peer) return read_peer(*header);
  cursor.state_kind = cursor.content_kind = 0;
  cursor.has_shown = cursor.has_save = cursor.has_gap = false;
  if (header->kind >= private_kind_first) return read_private(*header);
  switch (kind) {
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
  if (cursor.content_kind != 0)
    return header.kind == cursor.content_kind ? nullptr : "the next part of a shown image or a save";
  if (is(ChunkKind::shown) && setup.has(Feature::shown))
    return cursor.state_kind != 0 && !cursor.has_shown && !cursor.has_save
               ? nullptr
               : "a shown image directly behind a state alone, at most one";
  if (is(ChunkKind::save) && setup.has(Feature::saves))
    return cursor.state_kind == static_cast<std::uint8_t>(ChunkKind::checkpoint) && !cursor.has_save
               ? nullptr
               : "a save directly behind a checkpoint alone, at most one";
  if (is(ChunkKind::peer) && setup.has(Feature::peers) && cursor.has_checkpoint)
    return cursor.peer_count < peer_count_max ? nullptr : "at most 255 peers";
  if (cursor.peer_count > 0) return is(ChunkKind::end) ? nullptr : "the end behind the peers";
  if (header.kind >= private_kind_first) return cursor.has_pending ? "the end" : nullptr;
  if (is(ChunkKind::end)) return nullptr;
  if (cursor.has_pending) return "the end, since inputs of an unfinished tick came before";
  if (is(ChunkKind::checkpoint)) {
    if (!cursor.has_checkpoint) return header.tick == first_tick ? nullptr : "the checkpoint at tick 0 first";
    return header.tick > cursor.last_checkpoint ? nullptr : "at most one checkpoint for a tick";
  }
  if (is(ChunkKind::ticks)) return cursor.has_checkpoint ? nullptr : "the checkpoint at tick 0 first";
  return "checkpoint, ticks or end";
}

Step TraceReader::Impl::read_private(const ChunkHeader& header) {
  const std::optional<ByteView> payload = read_payload(header, limits::chunk_size_max);
  if (!payload) return Step::stop;
  cursor.chain = extend_chain(header, {}, *payload, version);
  pass(header);
  return Step::passed;
}

Step TraceReader::Impl::read_end(const ChunkHeader& header) {
  const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
  if (!payload) return Step::stop;
  Result<EndRecord> decoded = decode_end(*payload, header.tick);
  if (!decoded) return damaged(cursor.offset, decoded.error().message);
  end = std::move(*decoded);
  cursor.chain = extend_chain(header, {}, *payload, version);
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
    // All ticks have been read, and the header locates the footer: reading continues, and the end reports the damage.
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
