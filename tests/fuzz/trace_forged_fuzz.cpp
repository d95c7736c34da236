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
    const std::uint16_t version = ByteReader(ByteView(bytes_).subspan(replay::magic.size())).u16();
    if (version > replay::format_version_first && version <= replay::format_version) version_ = version;
    seed_ = chain_ = replay::chain_start(version_);
    ByteWriter header;
    replay::encode_file_header(header, version_);
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
    return is_ticks ? forge_records(replay::begin_running(header, version_)) : forge_payload(header);
  }

  bool forge_records(replay::Running running) {
    std::uint64_t tick_count = 0;
    for (;;) {
      const replay::Record record = replay::parse_record(ByteView(bytes_).subspan(offset_), nullptr, version_);
      if (record.fault != replay::RecordFault::none) return false;
      const auto tag = static_cast<replay::RecordTag>(record.tag);
      if (tag == replay::RecordTag::root || tag == replay::RecordTag::root_image) ++tick_count;
      if (tag == replay::RecordTag::close) {
        ByteWriter count;
        count.u32(static_cast<std::uint32_t>(tick_count));
        put(offset_ + 1, count.view());
      }
      const bool is_close = tag == replay::RecordTag::close;
      const bool is_third = version_ >= replay::format_version_third;
      const std::size_t checks_size = !is_close ? 2 : is_third ? 16 : 8;
      const ByteView checked = ByteView(bytes_).subspan(offset_, record.size - checks_size);
      const bool is_bound = is_third && replay::is_bound_tag(record.tag);
      if (is_bound || (is_third && is_close)) running.outside = hash64(checked, running.outside);
      if (!is_bound) running.chained = hash64(checked, running.chained);
      offset_ += record.size;
      ByteWriter checks;
      if (is_bound || (is_third && is_close)) checks.u64(running.outside);
      if (!is_bound) checks.u64(running.chained);
      put(offset_ - checks_size, checks.view().first(checks_size));
      if (!is_close) continue;
      tick_ += tick_count;
      chain_ = running.chained;
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
        const auto part = replay::decode_image_part(payload, version_);
        Bytes raw;
        if (part && replay::unpack_image_part(*part, raw))
          chain_ = replay::extend_chain(header, payload.first(replay::image_fields_size(version_)), raw, version_);
        break;
      }
      case ChunkKind::facts:
      case ChunkKind::index:
      case ChunkKind::footer:
      case ChunkKind::shown:
      case ChunkKind::save:
      case ChunkKind::peer:
        break;
      default:
        chain_ = replay::extend_chain(header, {}, payload, version_);
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
  std::uint16_t version_ = replay::format_version_first;
  std::uint64_t chain_ = 0;
  std::uint64_t seed_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes forged = Forger({data, size}).take();
  ticktrue::fuzz::read_in_every_way(forged);
  return 0;
}
