// Writes chunks and records with valid checksums and chain values around any content.
// SPDX-License-Identifier: MIT
#include "tests/damage/forger.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <variant>

#include "base/hash.h"
#include "replay/trace_reader.h"

namespace ticktrue::damage {

using replay::ChunkHeader;
using replay::ChunkKind;
using replay::RecordTag;

Forger::Forger(std::uint16_t version) : version_(version), seed_(replay::chain_start(version)), chain_(seed_) {
  replay::encode_file_header(out_, version);
}

ChunkHeader Forger::header(std::uint8_t kind, std::size_t size) {
  ChunkHeader header;
  header.kind = kind;
  header.sequence = sequence_++;
  header.size = static_cast<std::uint32_t>(size);
  header.tick = tick_;
  header.chain = chain_;
  return header;
}

std::uint64_t Forger::put(ChunkHeader header, ByteView payload) {
  header.check = replay::encode_chunk_header(header, seed_, out_);
  out_.bytes(payload);
  const std::uint64_t check = hash64(payload, header.check);
  out_.u64(check);
  return check;
}

void Forger::setup(ByteView payload) {
  const ChunkHeader made = header(static_cast<std::uint8_t>(ChunkKind::setup), payload.size());
  put(made, payload);
  seed_ = chain_ = replay::extend_chain(made, {}, payload, version_);
}

void Forger::facts(const replay::FactsPayload& facts) {
  ByteWriter payload;
  replay::encode_facts(facts, payload);
  facts_check_ = put(header(static_cast<std::uint8_t>(ChunkKind::facts), payload.size()), payload.view());
}

void Forger::chunk(std::uint8_t kind, ByteView payload) {
  const ChunkHeader made = header(kind, payload.size());
  put(made, payload);
  chain_ = replay::extend_chain(made, {}, payload, version_);
}

void Forger::image(ChunkKind kind, std::uint64_t root_hash, ByteView head, std::uint64_t image_size, bool compress,
                   std::size_t size_max) {
  static const Bytes zeros(replay::image_part_size);
  static ByteWriter packed_zeros;  // the part of zeros is packed once and used thousands of times
  Bytes raw;
  replay::ImagePart part;
  part.root_hash = root_hash;
  part.image_size = image_size;
  if (!compress) image_size = std::min<std::uint64_t>(image_size, 256u << 10);
  part.image_size = image_size;
  do {
    part.size = static_cast<std::uint32_t>(std::min<std::uint64_t>(replay::image_part_size, image_size - part.offset));
    const bool is_zero = part.offset >= head.size();
    raw.assign(zeros.begin(), zeros.begin() + part.size);
    if (!is_zero) {
      const ByteView piece = head.subspan(static_cast<std::size_t>(part.offset));
      std::copy_n(piece.begin(), std::min<std::size_t>(piece.size(), part.size), raw.begin());
    }
    ByteWriter payload;
    if (is_zero && compress && part.size == replay::image_part_size) {
      if (packed_zeros.size() == 0) replay::encode_image_part({}, zeros, true, packed_zeros);
      payload.u64(part.root_hash);
      payload.u64(part.image_size);
      payload.u64(part.offset);
      payload.u32(part.size);
      if (version_ >= replay::format_version_third) payload.f64(part.time_s);
      payload.bytes(packed_zeros.view().subspan(replay::image_part_fields_size));
    } else {
      replay::encode_image_part(part, raw, compress, payload, version_);
    }
    const ChunkHeader made = header(static_cast<std::uint8_t>(kind), payload.size());
    put(made, payload.view());
    chain_ = replay::extend_chain(made, payload.view().first(replay::image_fields_size(version_)), raw, version_);
    part.offset += part.size;
  } while (part.offset < image_size && out_.size() < size_max);
}

void Forger::list(ChunkKind kind, ByteView bytes, std::uint64_t image_size, double time_s, std::uint64_t root_hash) {
  replay::ImagePart part;
  part.root_hash = root_hash;
  part.image_size = image_size;
  part.size = static_cast<std::uint32_t>(bytes.size());
  part.time_s = time_s;
  ByteWriter payload;
  replay::encode_image_part(part, bytes, false, payload, version_);
  const ChunkHeader made = header(static_cast<std::uint8_t>(kind), payload.size());
  put(made, payload.view());
  chain_ = replay::extend_chain(made, payload.view().first(replay::image_fields_size(version_)), bytes, version_);
}

void Forger::bound_chunk(ChunkKind kind, ByteView payload) {
  put(header(static_cast<std::uint8_t>(kind), payload.size()), payload);
}

void Forger::content(ChunkKind kind, ByteView bytes, bool compress, std::uint64_t size) {
  replay::ImagePart part;
  part.root_hash = replay::content_hash(bytes);
  part.image_size = size == 0 ? bytes.size() : size;
  part.size = static_cast<std::uint32_t>(bytes.size());
  ByteWriter payload;
  replay::encode_image_part(part, bytes, compress, payload);
  bound_chunk(kind, payload.view());
}

void Forger::open_ticks() {
  ChunkHeader made = header(static_cast<std::uint8_t>(ChunkKind::ticks), replay::streamed_size);
  made.check = replay::encode_chunk_header(made, seed_, out_);
  running_ = replay::begin_running(made, version_);
  chunk_ticks_ = 0;
}

void Forger::record(RecordTag tag, ByteView body) {
  const bool is_bound =
      version_ >= replay::format_version_third && replay::is_bound_tag(static_cast<std::uint8_t>(tag));
  replay::append_record(tag, body, is_bound ? running_.outside : running_.chained, out_);
  if (tag != RecordTag::root && tag != RecordTag::root_image) return;
  ++chunk_ticks_;
  ++tick_;
}

void Forger::close_ticks() {
  if (version_ >= replay::format_version_third)
    replay::append_close(chunk_ticks_, running_, out_);
  else
    replay::append_close(chunk_ticks_, running_.chained, out_);
  chain_ = running_.chained;
}

void Forger::end(ByteView payload) {
  chunk(static_cast<std::uint8_t>(ChunkKind::end), payload);
}

void Forger::index(ByteView payload) {
  index_offset_ = out_.size();
  index_check_ = put(header(static_cast<std::uint8_t>(ChunkKind::index), payload.size()), payload);
}

void Forger::footer(std::uint64_t index_offset) {
  ByteWriter payload;
  replay::encode_footer({index_offset == 0 ? index_offset_ : index_offset, index_check_, facts_check_}, payload);
  put(header(static_cast<std::uint8_t>(ChunkKind::footer), payload.size()), payload.view());
}

Recording read_recording(const std::string& path) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(path);
  if (!reader) {
    std::fprintf(stderr, "forged_check: error: %s\n", reader.error().message.c_str());
    std::exit(2);
  }
  Recording recording;
  recording.path = path;
  recording.setup = reader->setup();
  for (;;) {
    const replay::TraceReader::Item& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) return recording;
    if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
      recording.checkpoints.push_back(
          {checkpoint->tick, checkpoint->root_hash, Bytes(checkpoint->image.begin(), checkpoint->image.end())});
      continue;
    }
    const auto& record = std::get<replay::TickRecord>(item);
    Recording::Tick tick;
    tick.dt = record.dt;
    tick.inputs.assign(record.inputs.begin(), record.inputs.end());
    tick.root_hash = record.root_hash;
    tick.stage_hashes = record.stage_hashes;
    tick.has_image = record.image.has_value();
    if (record.image) tick.image = record.image->joined();
    if (record.cells != nullptr) {
      ByteWriter cells;
      replay::encode_cells(*record.cells, recording.setup.schema, cells);
      tick.cells = cells.take();
    }
    recording.ticks.push_back(std::move(tick));
  }
}

}  // namespace ticktrue::damage
