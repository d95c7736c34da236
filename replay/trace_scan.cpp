// Finds chunks without reading all earlier ones: after damage by their sync markers, at a checkpoint by the index.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

#include "base/assert.h"
#include "base/hash.h"
#include "base/limits.h"
#include "replay/trace_reader_impl.h"

namespace ticktrue::replay {
namespace {

constexpr std::size_t footer_size = chunk_header_size + 24 + chunk_trailer_size;
constexpr std::size_t intact_range_count_max = 1'000;  // a report lists no more
// After damage, each valid header is tried. A real trace needs one try for each damaged place. The limit keeps forged
// headers without usable chunks from making the search quadratic.
constexpr int failed_try_count_max = 4'096;

}  // namespace

std::optional<ChunkHeader> TraceReader::Impl::find_header(std::uint64_t& offset) {
  while (offset + chunk_header_size <= file.size()) {
    const ByteView bytes = view(offset, read_ahead_size);
    if (bytes.size() < chunk_header_size) return std::nullopt;
    const std::size_t last = bytes.size() - chunk_header_size;
    std::size_t at = 0;
    while (at <= last) {
      const void* hit = std::memchr(bytes.data() + at, sync_marker[0], last - at + 1);
      if (hit == nullptr) {
        at = last + 1;
        break;
      }
      at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(hit) - bytes.data());
      if (const std::optional<ChunkHeader> header = decode_chunk_header(bytes.subspan(at), seed)) {
        offset += at;
        return header;
      }
      ++at;
    }
    offset += at;
  }
  return std::nullopt;
}

std::vector<IntactRange> TraceReader::Impl::find_intact() {
  const Cursor saved_cursor = cursor;
  const auto saved_fault = std::exchange(fault, std::nullopt);
  const auto saved_end = end;
  const auto saved_damage = first_damage;
  const bool saved_sequential = std::exchange(is_sequential, false);
  is_searching = true;
  std::vector<IntactRange> ranges;
  std::uint64_t offset = cursor.offset + 1;
  int failed_try_count = 0;
  while (ranges.size() < intact_range_count_max && failed_try_count < failed_try_count_max) {
    const std::optional<ChunkHeader> header = find_header(offset);
    if (!header) break;
    resume_at(offset, *header);
    IntactRange range;
    bool has_ticks = false;
    bool is_whole = false;
    std::optional<std::uint64_t> checkpoint;  // the first checkpoint in this range
    for (;;) {
      const std::uint64_t tick_before = cursor.tick;
      const Step step = read_chunk();
      if (step == Step::stop || fault) break;  // an incomplete chunk
      is_whole = true;
      if (step == Step::ticks) {
        if (!has_ticks) range.first_tick = tick_before;
        has_ticks = true;
        range.last_tick = cursor.tick - 1;
      }
      if (step == Step::checkpoint && !checkpoint) checkpoint = cursor.tick;
    }
    fault.reset();
    if (has_ticks) {
      range.has_checkpoint = checkpoint && *checkpoint <= range.last_tick;
      ranges.push_back(range);
    }
    if (!is_whole) ++failed_try_count;
    offset = std::max(cursor.offset, offset + 1);
  }
  walk_offset = walk_end = 0;
  cursor = saved_cursor;
  fault = saved_fault;
  end = saved_end;
  first_damage = saved_damage;
  is_sequential = saved_sequential;
  is_searching = false;
  return ranges;
}

void TraceReader::Impl::resume_at(std::uint64_t offset, const ChunkHeader& header) {
  cursor = Cursor{};
  cursor.offset = offset;
  cursor.sequence = header.sequence;
  cursor.chain = header.chain;
  cursor.tick = header.tick;
  cursor.has_checkpoint = true;
  const bool is_checkpoint = header.kind == static_cast<std::uint8_t>(ChunkKind::checkpoint);
  cursor.state_is_known = is_checkpoint;
  if (is_checkpoint && header.tick == first_tick) cursor.has_checkpoint = false;
  if (is_checkpoint && header.tick > 0) cursor.last_checkpoint = header.tick - 1;
  if (header.kind == static_cast<std::uint8_t>(ChunkKind::index)) cursor.phase = Phase::index;
  if (header.kind == static_cast<std::uint8_t>(ChunkKind::footer)) cursor.phase = Phase::footer;
  if (header.kind == static_cast<std::uint8_t>(ChunkKind::image)) cursor.expects_image = true;
}

std::optional<ChunkHeader> TraceReader::Impl::footer_header(Footer& footer) {
  if (file.size() < footer_size) return std::nullopt;
  const ByteView bytes = view(file.size() - footer_size, footer_size);
  if (bytes.size() < footer_size) return std::nullopt;
  const std::optional<ChunkHeader> header = decode_chunk_header(bytes, seed);
  if (!header || header->kind != static_cast<std::uint8_t>(ChunkKind::footer) || header->size != 24)
    return std::nullopt;
  const ByteView payload = bytes.subspan(chunk_header_size, header->size);
  if (ByteReader(bytes.last(chunk_trailer_size)).u64() != hash64(payload, header->check)) return std::nullopt;
  const Result<Footer> decoded = decode_footer(payload);
  if (!decoded) return std::nullopt;
  footer = *decoded;
  return header;
}

std::optional<CheckpointIndex> TraceReader::Impl::read_index_directly() {
  Footer footer;
  if (!footer_header(footer)) return std::nullopt;
  if (footer.index_offset >= file.size()) return std::nullopt;
  const ByteView head = view(footer.index_offset, chunk_header_size);
  if (head.size() < chunk_header_size) return std::nullopt;
  const std::optional<ChunkHeader> header = decode_chunk_header(head, seed);
  const ChunkKindInfo& info = *chunk_kind_info(static_cast<std::uint8_t>(ChunkKind::index));
  if (!header || header->kind != static_cast<std::uint8_t>(info.kind) || header->size > info.payload_size_max)
    return std::nullopt;
  const ByteView bytes = view(footer.index_offset, chunk_header_size + header->size + chunk_trailer_size);
  if (bytes.size() < chunk_header_size + header->size + chunk_trailer_size) return std::nullopt;
  const ByteView payload = bytes.subspan(chunk_header_size, header->size);
  if (hash64(payload, header->check) != footer.index_check) return std::nullopt;
  Result<CheckpointIndex> index = decode_index(payload);
  if (!index) return std::nullopt;
  return std::move(*index);
}

bool TraceReader::Impl::seek(std::uint64_t tick) {
  rewind();
  std::optional<Cursor> found;
  bool is_exact = false;
  if (const std::optional<CheckpointIndex> index = read_index_directly()) {
    const auto after =
        std::upper_bound(index->entries.begin(), index->entries.end(), tick,
                         [](std::uint64_t wanted, const IndexEntry& entry) { return wanted < entry.tick; });
    if (after == index->entries.begin()) return false;
    const IndexEntry& entry = *std::prev(after);
    const ByteView head = view(entry.offset, chunk_header_size);
    const std::optional<ChunkHeader> header =
        head.size() < chunk_header_size ? std::nullopt : decode_chunk_header(head, seed);
    if (header && header->kind == static_cast<std::uint8_t>(ChunkKind::checkpoint) && header->tick == entry.tick) {
      resume_at(entry.offset, *header);
      found = cursor;
      is_exact = index->stride == 1;
    }
  }
  // Without an index, or between its entries, checkpoints are found by reading the chunks.
  is_sequential = false;
  while (!is_exact && cursor.tick <= tick) {
    const Step step = read_chunk();
    if (step == Step::stop) break;
    if (step == Step::checkpoint && cursor.tick <= tick) found = image_start;
  }
  const Cursor target = found.value_or(start);
  rewind();  // reading finds the faults of the search again
  if (!found) return false;
  fault.reset();
  cursor = target;
  is_sequential = false;
  item_offset = cursor.offset;
  return true;
}

std::optional<std::uint64_t> TraceReader::Impl::tick_count_hint() {
  Footer footer;
  const std::optional<ChunkHeader> header = footer_header(footer);
  if (!header) return std::nullopt;
  return header->tick;
}

}  // namespace ticktrue::replay
