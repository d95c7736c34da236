// Writes traces that no recorder would write: any content, with valid checksums and chain values.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "replay/format/chunk.h"
#include "replay/format/payload.h"

namespace ticktrue::damage {

/// Appends chunks in any order and with any payload. `tick` and `sequence` advance as in a writer.
class Forger {
 public:
  explicit Forger(std::uint16_t version);

  void setup(ByteView payload);
  void facts(const replay::FactsPayload& facts);
  /// A chunk whose chain content is its payload: private kinds, end.
  void chunk(std::uint8_t kind, ByteView payload);
  /// An image of `image_size` bytes that begins with `head` and continues with zeros, as checkpoint or image chunks.
  /// Uses at most `size_max` bytes of the file.
  void image(replay::ChunkKind kind, std::uint64_t root_hash, ByteView head, std::uint64_t image_size, bool compress,
             std::size_t size_max);

  // Only in version 3:
  /// The next tick is `tick`.
  void begin_at(std::uint64_t tick) { tick_ = tick; }
  /// One part with these bytes, which claims to be the first of `image_size`.
  void list(replay::ChunkKind kind, ByteView bytes, std::uint64_t image_size, double time_s = 0,
            std::uint64_t root_hash = 1);
  void list(replay::ChunkKind kind, ByteView bytes) { list(kind, bytes, bytes.size()); }
  /// A chunk outside of the chain.
  void bound_chunk(replay::ChunkKind kind, ByteView payload);
  /// A shown image or a save in one part. `size`: the claimed size; 0: the size of `bytes`.
  void content(replay::ChunkKind kind, ByteView bytes, bool compress = false, std::uint64_t size = 0);

  void open_ticks();
  void record(replay::RecordTag tag, ByteView body);
  void close_ticks();

  void end(ByteView payload);
  void index(ByteView payload);
  void footer(std::uint64_t index_offset);
  /// Bytes without a chunk header or checksum.
  void raw(ByteView bytes) { out_.bytes(bytes); }

  std::size_t size() const { return out_.size(); }
  std::uint64_t tick() const { return tick_; }
  Bytes take() { return out_.take(); }

 private:
  replay::ChunkHeader header(std::uint8_t kind, std::size_t size);
  std::uint64_t put(replay::ChunkHeader header, ByteView payload);

  std::uint16_t version_;
  ByteWriter out_;
  std::uint64_t seed_;
  std::uint64_t chain_;
  replay::Running running_;
  std::uint32_t sequence_ = 0;
  std::uint64_t tick_ = 0;
  std::uint32_t chunk_ticks_ = 0;
  std::uint64_t facts_check_ = 0;
  std::uint64_t index_check_ = 0;
  std::uint64_t index_offset_ = 0;
};

/// The parts of a recording.
struct Recording {
  struct Checkpoint {
    std::uint64_t tick = 0;
    std::uint64_t root_hash = 0;
    Bytes image;
  };
  struct Tick {
    double dt = 0;
    Bytes inputs;
    std::uint64_t root_hash = 0;
    std::vector<std::uint64_t> stage_hashes;
    bool has_image = false;
    Bytes image;
    Bytes cells;
  };
  std::string path;
  replay::TraceSetup setup;
  std::vector<Checkpoint> checkpoints;
  std::vector<Tick> ticks;
};
Recording read_recording(const std::string& path);

struct Recipe {
  std::string_view name;
  std::string_view summary;
  Bytes (*forge)(const Recording& from, std::uint64_t seed);
};
/// A recipe makes at most this many bytes.
inline constexpr std::size_t forged_size_max = 1u << 20;
const std::vector<Recipe>& recipes();

}  // namespace ticktrue::damage
