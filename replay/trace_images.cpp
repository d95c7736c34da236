// Reads state images part by part. The file size bounds the bytes in memory and the decompressed bytes.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "base/limits.h"
#include "base/state/child_tables.h"
#include "replay/trace_reader_impl.h"

namespace ticktrue::replay {

Status ImageShape::pass(const StateSchema& schema, ByteView image, std::uint64_t image_size) {
  const auto wrong = [&](const std::string& what) { return Error{ErrorCode::corrupt, "state image: " + what, ""}; };
  while (table < schema.tables.size() && offset + 4 <= image.size()) {
    const std::uint64_t row_count = ByteReader(image.subspan(static_cast<std::size_t>(offset), 4)).u32();
    offset += 4 + row_count * schema.tables[table].row_size;
    if (offset > image_size)
      return wrong("table " + schema.tables[table].name + ": rows: found " + std::to_string(row_count) +
                   ", expected at most what an image of " + std::to_string(image_size) + " bytes holds");
    ++table;
  }
  if (image.size() == image_size && (table < schema.tables.size() || offset != image_size))
    return wrong("size: found " + std::to_string(image_size) + " bytes, expected " + std::to_string(offset) + " by " +
                 std::to_string(table) + " of " + std::to_string(schema.tables.size()) + " row counts");
  return {};
}

Status TraceReader::Impl::check_image_limits(const ImagePart& part, std::uint64_t part_end) const {
  const auto over = [](const char* what, std::uint64_t found, std::uint64_t max) {
    return Error{ErrorCode::limit,
                 std::string("state image: ") + what + ": found " + std::to_string(found) + ", expected at most " +
                     std::to_string(max) + " at this place of the file",
                 ""};
  };
  const std::uint64_t held = part.offset + part.size;
  if (held > limits::image_held_max(part_end)) return over("bytes", held, limits::image_held_max(part_end));
  const std::uint64_t unpacked = unpacked_size + part.size;
  if (unpacked > limits::images_unpacked_max(part_end))
    return over("bytes of all images", unpacked, limits::images_unpacked_max(part_end));
  return {};
}

Status TraceReader::Impl::check_shape(const ImagePart& part) {
  if (version < format_version_third) return cursor.shape.pass(setup.schema, image, part.image_size);
  if (part.offset == 0 && !image.empty()) {
    const bool is_image = cursor.part_kind == static_cast<std::uint8_t>(ChunkKind::image);
    cursor.base = is_image && composed.holds(cursor.tick - 1) ? ListBase::before : ListBase::nothing;
    // Reading began in the middle: the state before is unknown, and the list itself says what it is relative to.
    if (is_image && !cursor.state_is_known)
      cursor.base = image[0] == static_cast<std::uint8_t>(ListBase::before) ? ListBase::before : ListBase::nothing;
  }
  return cursor.list.pass(setup.schema, image, part.image_size, cursor.base);
}

Status TraceReader::Impl::take_image(std::uint64_t image_end) {
  if (version < format_version_third) return {};
  if (cursor.base == ListBase::nothing) {
    composed.take_whole(setup.schema, cursor.list, cursor.tick, image);
    cursor.state_is_known = true;
    return check_children(setup.schema, composed.tables());
  }
  if (!cursor.state_is_known) return {};
  const std::uint64_t size_max =
      std::min<std::uint64_t>(limits::state_image_size_max, limits::image_held_max(image_end));
  if (const Status status = composed.replace(setup.schema, cursor.list, cursor.tick, image, size_max); !status)
    return status;
  return check_children(setup.schema, composed.tables(), composed.listed());
}

StoredState TraceReader::Impl::stored_state() {
  if (version >= format_version_third) return {composed.tables(), composed.listed()};
  Result<std::vector<ImageTable>> split = split_image(setup.schema, image);
  TICKTRUE_ASSERT(split.has_value());  // the shape of each part was checked
  tables = std::move(*split);
  return {tables, all_tables};
}

Step TraceReader::Impl::read_image_part(const ChunkHeader& header) {
  const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
  if (!payload) return Step::stop;
  const auto wrong = [&](const std::string& what) {
    return damaged(cursor.offset, chunk_text(header.kind) + ": " + what);
  };
  const Result<ImagePart> part = decode_image_part(*payload, version);
  if (!part) return wrong(part.error().message);
  const ImagePart& before = cursor.part;
  const bool is_first = cursor.part_kind == 0;
  if (is_first ? part->offset != 0
               : part->offset != before.offset + before.size || part->image_size != before.image_size ||
                     part->root_hash != before.root_hash || bits_of(part->time_s) != bits_of(before.time_s))
    return wrong("state image: a part of another place or image");
  const std::uint64_t image_end = cursor.offset + whole_size(header);
  if (const Status status = check_image_limits(*part, image_end); !status) return wrong(status.error().message);
  if (is_first) {
    image.clear();
    image.reserve(static_cast<std::size_t>(std::min(part->image_size, limits::image_held_max(file.size()))));
    image_start = cursor;
    cursor.shape = {};
    cursor.list = {};
  }
  const std::size_t raw_offset = image.size();
  if (const Status status = unpack_image_part(*part, image); !status) return wrong(status.error().message);
  unpacked_size += part->size;
  cursor.part_kind = header.kind;
  if (const Status status = check_shape(*part); !status) return wrong(status.error().message);
  const std::uint64_t chain =
      extend_chain(header, payload->first(image_fields_size(version)), ByteView(image).subspan(raw_offset), version);
  cursor.part = *part;
  cursor.part.stored = {};
  const bool is_whole = part->offset + part->size == part->image_size;
  if (is_whole)
    if (const Status status = take_image(image_end); !status) return wrong(status.error().message);
  cursor.chain = chain;
  pass(header);
  if (!is_whole) return Step::passed;
  cursor.part_kind = 0;
  cursor.state_kind = header.kind;
  if (header.kind == static_cast<std::uint8_t>(ChunkKind::image)) {
    cursor.expects_image = false;
    return Step::image;
  }
  cursor.has_checkpoint = true;
  cursor.last_checkpoint = cursor.tick;
  if (is_sequential) seen.add({cursor.tick, image_start.offset});
  return Step::checkpoint;
}

}  // namespace ticktrue::replay
