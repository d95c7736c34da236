// Fuzzes what stands behind the checksums of a trace: every check is made right before the reader sees the bytes.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "base/hash.h"
#include "replay/format/chunk.h"
#include "replay/format/payload.h"
#include "tests/fuzz/trace_reading.h"

namespace {

using namespace ticktrue;

/// Goes through the chunks as a writer would and puts in what only a writer knows: sequence, ticks, chain and checks.
/// Kinds, sizes, records and payloads stay as they are; behind a chunk without sense all stays as it is.
class Forger {
 public:
  explicit Forger(ByteView bytes) : bytes_(bytes.begin(), bytes.end()) {}

  Bytes take() {
    if (bytes_.size() < replay::file_header_size) return std::move(bytes_);
    ByteWriter header;
    replay::encode_file_header(header);
    put(0, header.view());
    offset_ = replay::file_header_size;
    while (forge_chunk()) {
    }
    return std::move(bytes_);
  }

 private:
  void put(std::size_t offset, ByteView part) {
    std::copy(part.begin(), part.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  void put_u64(std::size_t offset, std::uint64_t value) {
    ByteWriter out;
    out.u64(value);
    put(offset, out.view());
  }

  bool forge_chunk() {
    if (bytes_.size() - offset_ < replay::chunk_header_size) return false;
    ByteReader in(ByteView(bytes_).subspan(offset_ + 4));
    replay::ChunkHeader header;
    header.kind = in.u8();
    in.bytes(7);
    header.size = in.u32();
    header.sequence = sequence_++;
    header.tick = tick_;
    header.chain = chain_;
    const bool is_ticks = header.kind == static_cast<std::uint8_t>(replay::ChunkKind::ticks);
    if (is_ticks) header.size = replay::streamed_size;
    ByteWriter out;
    header.check = replay::encode_chunk_header(header, seed_, out);
    put(offset_, out.view());
    offset_ += replay::chunk_header_size;
    return is_ticks ? forge_records(header.check) : forge_payload(header);
  }

  bool forge_records(std::uint64_t running) {
    std::uint64_t tick_count = 0;
    for (;;) {
      const replay::Record record = replay::parse_record(ByteView(bytes_).subspan(offset_), nullptr);
      if (record.fault != replay::RecordFault::none) return false;
      const auto tag = static_cast<replay::RecordTag>(record.tag);
      if (tag == replay::RecordTag::root || tag == replay::RecordTag::root_image) ++tick_count;
      if (tag == replay::RecordTag::close) {
        ByteWriter count;
        count.u32(static_cast<std::uint32_t>(tick_count));
        put(offset_ + 1, count.view());
      }
      const std::size_t check_size = tag == replay::RecordTag::close ? 8 : 2;
      running = hash64(ByteView(bytes_).subspan(offset_, record.size - check_size), running);
      offset_ += record.size;
      ByteWriter check;
      check.u64(running);
      put(offset_ - check_size, check.view().first(check_size));
      if (tag != replay::RecordTag::close) continue;
      tick_ += tick_count;
      chain_ = running;
      return true;
    }
  }

  bool forge_payload(const replay::ChunkHeader& header) {
    if (header.size > bytes_.size() - offset_ || bytes_.size() - offset_ - header.size < replay::chunk_trailer_size)
      return false;
    const ByteView payload = ByteView(bytes_).subspan(offset_, header.size);
    const std::uint64_t trailer = hash64(payload, header.check);
    using replay::ChunkKind;
    switch (static_cast<ChunkKind>(header.kind)) {
      case ChunkKind::checkpoint:
      case ChunkKind::image: {
        const auto part = replay::decode_image_part(payload);
        Bytes raw;
        if (part && replay::unpack_image_part(*part, raw))
          chain_ = replay::extend_chain(header, payload.first(replay::image_part_fields_size), raw);
        break;
      }
      case ChunkKind::facts:
      case ChunkKind::index:
      case ChunkKind::footer:
        break;
      default:
        chain_ = replay::extend_chain(header, {}, payload);
        if (sequence_ == 1) seed_ = chain_;
        break;
    }
    offset_ += header.size;
    put_u64(offset_, trailer);
    offset_ += replay::chunk_trailer_size;
    return true;
  }

  Bytes bytes_;
  std::size_t offset_ = 0;
  std::uint32_t sequence_ = 0;
  std::uint64_t tick_ = 0;
  std::uint64_t chain_ = replay::chain_start();
  std::uint64_t seed_ = replay::chain_start();
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes forged = Forger({data, size}).take();
  ticktrue::fuzz::read_in_every_way(forged);
  return 0;
}
