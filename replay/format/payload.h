// The payloads of chunks: setup, build facts, parts of state images, end, index, footer.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/cells.h"
#include "replay/format/trace.h"

namespace ticktrue::replay {

inline constexpr std::size_t fact_count_max = 256;
inline constexpr std::size_t fact_size_max = 4'096;  // bytes of a name or a value
inline constexpr std::size_t note_size_max = 4'096;

/// The encoding of the bytes of a state image.
enum class Codec : std::uint8_t { none = 0, zstd = 1 };
/// Whether this build reads and writes the codec.
bool has_codec(Codec codec);

/// Errors: limit, incompatible (parts that do not fit together). `place`: the begin of messages.
Status check_setup(const TraceSetup& setup, const std::string& place);
/// Encodes in the layout of version_of(setup).
void encode_setup(const TraceSetup& setup, ByteWriter& out);
/// Errors: corrupt.
Result<TraceSetup> decode_setup(ByteView payload, std::uint16_t version = format_version);

/// `codecs`: compression methods that state images of this file may use; not in the chain.
struct FactsPayload {
  Codec codec = Codec::none;
  BuildFacts facts;
};
Status check_facts(const BuildFacts& facts, const std::string& place);
void encode_facts(const FactsPayload& facts, ByteWriter& out);
Result<FactsPayload> decode_facts(ByteView payload);

/// One part of a state image. The chain covers its fields and its raw bytes, so it does not depend on the codec.
struct ImagePart {
  std::uint64_t root_hash = 0;
  std::uint64_t image_size = 0;
  std::uint64_t offset = 0;  // offset of this part in the image
  std::uint32_t size = 0;    // raw bytes
  double time_s = 0;         // version 3: simulated time before this state
  Codec codec = Codec::none;
  ByteView stored;
};
inline constexpr std::size_t image_part_fields_size = 28;  // bytes of the fields that the chain covers
inline constexpr std::size_t image_part_fields_size_third = 36;
constexpr std::size_t image_fields_size(std::uint16_t version) {
  return version >= format_version_third ? image_part_fields_size_third : image_part_fields_size;
}
/// Appends the part, compressed if this makes it smaller. Parts of shown images and saves have the layout of version 1,
/// with the content hash instead of the root hash.
void encode_image_part(const ImagePart& part, ByteView raw, bool compress, ByteWriter& out,
                       std::uint16_t version = format_version_first);
/// Errors: corrupt, limit.
Result<ImagePart> decode_image_part(ByteView payload, std::uint16_t version = format_version_first);
/// `what`: the begin of messages. Errors: corrupt, limit.
Result<ImagePart> decode_content_part(ByteView payload, const std::string& what, std::size_t size_max);
/// Appends the part's raw bytes, exactly part.size, to `out`. Errors: corrupt, unsupported.
Status unpack_image_part(const ImagePart& part, Bytes& out);

/// Encodes only the row cells, little-endian.
void encode_row_cells(const StateCells& cells, ByteWriter& out);
void encode_cells(const StateCells& cells, const StateSchema& schema, ByteWriter& out);
/// Whether the body is valid for a cells record of this schema.
bool check_cells(const StateSchema& schema, ByteView body);
/// Requires: check_cells returned true.
void decode_cells(const StateSchema& schema, ByteView body, StateCells& out);
StateCells decode_cells(const StateSchema& schema, ByteView body);

void encode_end(const EndRecord& end, ByteWriter& out);
/// Errors: corrupt. tick_count is in the header of the chunk.
Result<EndRecord> decode_end(ByteView payload, std::uint64_t tick_count);

struct IndexEntry {
  std::uint64_t tick = 0;
  std::uint64_t offset = 0;  // bytes from the start of the file to the header of the checkpoint's first chunk
  bool operator==(const IndexEntry&) const = default;
};
/// Every stride-th checkpoint. The stride bounds the size for recordings of any length.
struct CheckpointIndex {
  std::uint32_t stride = 1;
  std::vector<IndexEntry> entries;
  std::uint64_t checkpoint_count = 0;

  void add(const IndexEntry& entry);
};
void encode_index(const CheckpointIndex& index, ByteWriter& out);
/// Errors: corrupt.
Result<CheckpointIndex> decode_index(ByteView payload);

struct Footer {
  std::uint64_t index_offset = 0;
  std::uint64_t index_check = 0;  // trailers of the two chunks outside the chain
  std::uint64_t facts_check = 0;
};
void encode_footer(const Footer& footer, ByteWriter& out);
/// Errors: corrupt.
Result<Footer> decode_footer(ByteView payload);

}  // namespace ticktrue::replay
