// Reads chunks outside the chain: shown images, saves, peers. Damage to them is reported and loses no tick.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include "base/hash.h"
#include "base/limits.h"
#include "replay/format/identity.h"
#include "replay/format/peer.h"
#include "replay/trace_reader_impl.h"

namespace ticktrue::replay {

std::optional<ChunkHeader> TraceReader::Impl::find_behind_lost() {
  if (version < format_version_third || is_searching || cursor.phase != Phase::body ||
      fault->condition != TraceCondition::damaged)
    return std::nullopt;
  // Each chunk in the chain changes the chain value. An equal value proves that no such chunk is missing.
  std::uint64_t offset = cursor.offset;
  while (const std::optional<ChunkHeader> header = find_header(offset)) {
    if (header->chain == cursor.chain && header->tick == cursor.tick && header->sequence >= cursor.sequence) {
      note_damage(*std::exchange(fault, std::nullopt));
      cursor.offset = offset;
      cursor.sequence = header->sequence;
      cursor.content_kind = 0;
      cursor.has_gap = true;
      return header;
    }
    ++offset;
  }
  return std::nullopt;
}

Step TraceReader::Impl::lose(const ChunkHeader& header) {
  if (fault->condition == TraceCondition::truncated || whole_size(header) > remaining()) return Step::stop;
  note_damage(*std::exchange(fault, std::nullopt));
  cursor.content_kind = 0;
  cursor.has_gap = true;
  pass(header);
  return Step::passed;
}

Step TraceReader::Impl::read_content_part(const ChunkHeader& header) {
  const bool is_save = header.kind == static_cast<std::uint8_t>(ChunkKind::save);
  const std::string what = is_save ? "save" : "shown image";
  const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
  if (!payload) return lose(header);
  const auto wrong = [&](const std::string& why) {
    return damaged(cursor.offset, chunk_text(header.kind) + ": " + why);
  };
  const Result<ImagePart> part =
      decode_content_part(*payload, what, is_save ? limits::save_size_max : limits::shown_size_max);
  if (!part) return wrong(part.error().message);
  const bool is_first = cursor.content_kind == 0;
  if (is_first && part->offset != 0 && cursor.has_gap) {  // the first parts were lost
    pass(header);
    return Step::passed;
  }
  const ImagePart& before = cursor.content_part;
  if (is_first ? part->offset != 0
               : part->offset != before.offset + before.size || part->image_size != before.image_size ||
                     part->root_hash != before.root_hash)
    return wrong(what + ": a part of another place or content");
  Bytes& content = is_save ? save_bytes : shown_bytes;
  // The size of all content of one state is limited as a sum.
  ImagePart all = *part;
  all.offset += composed.size() + (is_save && cursor.has_shown ? shown_bytes.size() : 0);
  if (const Status status = check_image_limits(all, cursor.offset + whole_size(header)); !status)
    return wrong(what + ": " + status.error().message);
  if (is_first) content.clear();
  if (const Status status = unpack_image_part(*part, content); !status)
    return wrong(what + ": " + status.error().message);
  unpacked_size += part->size;
  const bool is_whole = part->offset + part->size == part->image_size;
  if (is_whole && content_hash(content) != part->root_hash)
    return wrong(what + ": content hash: found " + hex64(part->root_hash) + ", expected " +
                 hex64(content_hash(content)));
  pass(header);
  cursor.content_kind = is_whole ? 0 : header.kind;
  cursor.content_part = *part;
  cursor.content_part.stored = {};
  if (is_whole) (is_save ? cursor.has_save : cursor.has_shown) = true;
  return Step::passed;
}

Step TraceReader::Impl::read_peer(const ChunkHeader& header) {
  ++cursor.peer_count;
  const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
  if (!payload) return lose(header);
  Result<PeerRecord> peer = decode_peer(setup.schema, *payload);
  if (!peer) return damaged(cursor.offset, chunk_text(header.kind) + ": " + peer.error().message);
  if (!is_searching) {
    if (!peers.empty() && peer->player <= peers.back().player)
      return damaged(cursor.offset, chunk_text(header.kind) + ": peer: player: found " + std::to_string(peer->player) +
                                        " behind " + std::to_string(peers.back().player) + ", expected them ascending");
    if (!peers.empty() && (peer->recorder != peers.back().recorder || peer->tick != peers.back().tick))
      return damaged(cursor.offset,
                     chunk_text(header.kind) + ": peer: found another recorder or tick than those before have");
    if (!peer->tables.empty() && peer->session_identity != session_identity(setup))
      return damaged(cursor.offset, chunk_text(header.kind) + ": peer: rows: found those of another game");
    peers.push_back(std::move(*peer));
  }
  pass(header);
  return Step::passed;
}

void TraceReader::Impl::read_contents() {
  if (!setup.has(Feature::shown) && !setup.has(Feature::saves)) return;
  while (!fault && remaining() >= chunk_header_size) {
    const std::optional<ChunkHeader> header = decode_chunk_header(view(cursor.offset, chunk_header_size), seed);
    if (!header || (header->kind != static_cast<std::uint8_t>(ChunkKind::shown) &&
                    header->kind != static_cast<std::uint8_t>(ChunkKind::save)))
      return;
    // A header that does not belong here would make the search skip everything up to its place.
    if (header->chain != cursor.chain || header->tick != cursor.tick || header->sequence < cursor.sequence) return;
    if (read_chunk() == Step::stop) return;
  }
}

}  // namespace ticktrue::replay
