// Finds the chunks of a whole trace by walking it as the format says, without the reader.
// SPDX-License-Identifier: MIT
#include "tests/replay/toy_traces.h"

#include "replay/format/chunk.h"

namespace ticktrue::test {

std::vector<ChunkPlace> chunk_places(ByteView trace) {
  std::vector<ChunkPlace> places;
  std::size_t offset = replay::file_header_size;
  const std::uint16_t version = ByteReader(trace.subspan(replay::magic.size())).u16();
  std::uint64_t seed = replay::chain_start(version);
  while (offset < trace.size()) {
    const auto header = replay::decode_chunk_header(trace.subspan(offset), seed);
    REQUIRE(header);
    std::size_t size = replay::chunk_header_size;
    if (header->size == replay::streamed_size) {
      std::uint8_t tag = 0;
      while (tag != static_cast<std::uint8_t>(replay::RecordTag::close)) {
        const replay::Record record = replay::parse_record(trace.subspan(offset + size), nullptr, version);
        REQUIRE(record.fault == replay::RecordFault::none);
        tag = record.tag;
        size += record.size;
      }
    } else {
      size += header->size + replay::chunk_trailer_size;
    }
    places.push_back({header->kind, offset, size});
    if (places.size() == 1)
      seed =
          replay::extend_chain(*header, {}, trace.subspan(offset + replay::chunk_header_size, header->size), version);
    offset += size;
  }
  return places;
}

}  // namespace ticktrue::test
