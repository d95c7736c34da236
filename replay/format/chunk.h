// The framing of a trace: file header, chunks with their checks and chain, and the records of a ticks chunk.
// SPDX-License-Identifier: MIT
//
// Format: docs/trace_format.md. Shared by writer and reader.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/bytes.h"
#include "base/limits.h"
#include "replay/format/trace.h"

namespace ticktrue::replay {

inline constexpr std::array<std::uint8_t, 8> magic{0x89, 'T', 'T', 'R', 0x0d, 0x0a, 0x1a, 0x0a};
inline constexpr std::array<std::uint8_t, 4> sync_marker{0xf5, 'T', 'T', 'C'};
inline constexpr std::size_t file_header_size = 16;
inline constexpr std::size_t chunk_header_size = 40;
inline constexpr std::size_t chunk_trailer_size = 8;
inline constexpr std::uint32_t streamed_size = 0xffffffffu;  // of a ticks chunk: its records mark its end

inline constexpr std::size_t cells_size_max = 128u << 10;      // 64 KiB of column hashes, 32 KiB of cells, counts
inline constexpr std::size_t cell_list_size_max = 512u << 10;  // of version 3: 256 KiB of column hashes
inline constexpr std::size_t input_size_max = 8u << 20;        // bytes of one tick: inputs_per_tick_max of 128 B
inline constexpr std::uint32_t chunk_tick_count = 1024;  // the writer closes a ticks chunk after this number of ticks
inline constexpr std::size_t chunk_close_size = 256u << 10;  // or of bytes
inline constexpr std::size_t image_part_size = 1u << 20;     // raw bytes of a state image in one chunk
inline constexpr std::size_t index_entry_count_max = 65'536;

// Limits of records outside the chain.
inline constexpr std::size_t bound_size_max = 4u << 20;  // bytes of these records in a chunk
inline constexpr std::size_t mark_name_count_max = 1'024;
inline constexpr std::size_t marks_size_max = 16u << 10;
inline constexpr std::size_t mark_list_size_max = 1u << 20;  // bytes in a tick
inline constexpr std::size_t topic_size_max = 64;
inline constexpr std::size_t note_body_size_max = 4'096;
inline constexpr std::size_t peer_count_max = 255;
inline constexpr std::size_t peer_root_count_max = 65'536;
inline constexpr std::size_t peer_row_count_max = 65'536;  // rows in all tables of a player
inline constexpr std::size_t peer_rows_size_max = 1u << 20;

enum class ChunkKind : std::uint8_t {
  setup = 1,
  facts,
  checkpoint,
  ticks,
  image,
  end,
  index,
  footer,
  shown,  // this and later kinds: version 3
  save,
  peer,
};
struct ChunkKindInfo {
  ChunkKind kind;
  std::string_view name;
  std::size_t payload_size_max;
};
inline constexpr std::array<ChunkKindInfo, 11> chunk_kinds{{
    {ChunkKind::setup, "setup", limits::setup_size_max},
    {ChunkKind::facts, "build facts", 4u << 20},
    {ChunkKind::checkpoint, "checkpoint", image_part_size + 64},
    {ChunkKind::ticks, "ticks", limits::chunk_size_max},
    {ChunkKind::image, "image", image_part_size + 64},
    {ChunkKind::end, "end", 64u << 10},
    {ChunkKind::index, "index", 2u << 20},
    {ChunkKind::footer, "footer", 24},
    {ChunkKind::shown, "shown", image_part_size + 64},
    {ChunkKind::save, "save", image_part_size + 64},
    {ChunkKind::peer, "peer", 4u << 20},
}};
/// Null: the kind is unknown or private.
const ChunkKindInfo* chunk_kind_info(std::uint8_t kind);
inline constexpr std::uint8_t private_kind_first = 0x80;  // readers skip kinds and tags from here on
inline constexpr std::uint8_t bound_tag_first = 64;       // tags from here to the private tags are outside the chain
constexpr bool is_bound_tag(std::uint8_t tag) {
  return tag >= bound_tag_first && tag < private_kind_first;
}

struct ChunkHeader {
  std::uint8_t kind = 0;
  std::uint32_t sequence = 0;
  std::uint32_t size = 0;   // bytes of the payload
  std::uint64_t tick = 0;   // number of ticks before this chunk
  std::uint64_t chain = 0;  // chain value before this chunk
  std::uint64_t check = 0;  // checksum of the fields above
};

void encode_file_header(ByteWriter& out, std::uint16_t version = format_version_first);
/// The chain value before the first chunk. It is also the seed of the header check of the setup chunk.
std::uint64_t chain_start(std::uint16_t version = format_version_first);

/// Appends the header and returns its check. `seed`: chain_start() for the setup, else the chain value after the setup.
std::uint64_t encode_chunk_header(const ChunkHeader& header, std::uint64_t seed, ByteWriter& out);
/// Nothing: the marker, the reserved bits or the check are wrong. Requires: chunk_header_size bytes.
std::optional<ChunkHeader> decode_chunk_header(ByteView bytes, std::uint64_t seed);
/// Whether the first bytes of a truncated header are valid. `knows_tick`: false if the header may have any tick.
bool may_begin_chunk(ByteView part, const ChunkHeader& expected, bool knows_tick = true);

/// The chain value after a chunk with this content: first `fields`, then `data`.
std::uint64_t extend_chain(const ChunkHeader& header, ByteView fields, ByteView data,
                           std::uint16_t version = format_version_first);

/// The checksum of the bytes of a shown image or a save.
std::uint64_t content_hash(ByteView bytes);

/// In the order of the records of a tick; `root` or `root_image` ends it.
enum class RecordTag : std::uint8_t {
  dt = 1,
  inputs = 2,
  stages = 3,
  cells = 4,
  root = 5,
  root_image = 6,  // a root hash; the image of the state follows in image chunks
  close = 15,
  name = 64,       // the next name of marks in the chunk
  marks = 65,      // counts and hashes of the marks in a tick
  mark_list = 66,  // each mark in a tick
  note = 67,       // a topic and its text
};

/// The values that each record of a ticks chunk updates.
struct Running {
  std::uint64_t chained = 0;  // hash of all records but bound records; after the close record the chain value
  std::uint64_t outside = 0;  // version 3: hash of the bound records and the close record
};
/// The initial values. Requires: the header with its check.
Running begin_running(const ChunkHeader& header, std::uint16_t version);

/// Appends a record (not `close`) and updates the running value. A tag with a size field gets the size first.
void append_record(RecordTag tag, ByteView body, std::uint64_t& running, ByteWriter& out);
/// Appends the record that closes a ticks chunk; `running` becomes the chain value after it.
void append_close(std::uint32_t tick_count, std::uint64_t& running, ByteWriter& out);
/// The same for version 3.
void append_close(std::uint32_t tick_count, Running& running, ByteWriter& out);

enum class RecordFault : std::uint8_t {
  none,
  ends_early,
  unknown_tag,
  bad_size,
  bad_check,
  bad_outside,  // the check of a bound record, or this check of a close record; the other checks are right
};
struct Record {
  RecordFault fault = RecordFault::none;
  std::uint8_t tag = 0;
  ByteView body;                  // without tag, size and check
  std::size_t size = 0;           // of the whole record; with ends_early: the least size that it can have
  std::uint64_t check_found = 0;  // with bad_check
  std::uint64_t check_expected = 0;
};
/// Parses the record at the start of `bytes`. With running values the record is checked. A valid record updates them. A
/// record with bad_outside updates them too, so that later records can be checked.
Record parse_record(ByteView bytes, Running* running, std::uint16_t version = format_version_first);

}  // namespace ticktrue::replay
