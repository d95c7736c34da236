// Encodes and decodes the bodies of mark and note records.
// SPDX-License-Identifier: MIT
#include "replay/format/marks.h"

#include <algorithm>
#include <numeric>

#include "replay/format/chunk.h"

namespace ticktrue::replay {
namespace {

ByteView bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Indices into `ids`, sorted by id.
std::vector<std::size_t> order_of(const std::vector<std::uint32_t>& ids) {
  std::vector<std::size_t> order(ids.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return ids[a] < ids[b]; });
  return order;
}

std::size_t varint_size(std::uint64_t value) {
  std::size_t size = 1;
  for (; value >= 128; value >>= 7) ++size;
  return size;
}

}  // namespace

void encode_marks(const TickMarks& marks, const std::vector<std::uint32_t>& ids, ByteWriter& out) {
  out.u64(marks.trail);
  out.varint(marks.names.size());
  std::uint32_t next = 0;
  for (const std::size_t i : order_of(ids)) {
    out.varint(ids[i] - next);
    out.varint(marks.names[i].count);
    out.u32(marks.names[i].hash);
    next = ids[i] + 1;
  }
}

TickMarks decode_marks(ByteView body, const std::vector<std::string>& chunk_names) {
  ByteReader in(body);
  TickMarks marks;
  marks.trail = in.u64();
  const std::uint64_t count = in.varint();
  std::uint64_t id = 0;
  for (std::uint64_t i = 0; i < count; ++i, ++id) {
    id += in.varint();
    NameMarks& name = marks.names.emplace_back();
    name.name = chunk_names[static_cast<std::size_t>(id)];
    name.count = in.varint();
    name.hash = in.u32();
  }
  return marks;
}

void encode_mark_list(const MarkList& list, const std::vector<std::uint32_t>& ids, ByteWriter& out) {
  std::size_t size = 1;
  std::size_t count = 0;
  for (; count < list.marks.size(); ++count) {
    size += varint_size(ids[list.marks[count].name]) + 8;
    if (size > mark_list_size_max) break;
  }
  out.u8(list.is_cut || count < list.marks.size() ? 1 : 0);
  for (std::size_t i = 0; i < count; ++i) {
    out.varint(ids[list.marks[i].name]);
    out.u64(list.marks[i].value);
  }
}

void decode_mark_list(ByteView body, const std::vector<std::string>& chunk_names, MarkList& list) {
  ByteReader in(body);
  if (in.u8() != 0) list.is_cut = true;
  list.names = chunk_names;
  while (!in.at_end()) {
    Mark& mark = list.marks.emplace_back();
    mark.name = static_cast<std::uint32_t>(in.varint());
    mark.value = in.u64();
  }
}

void encode_note(const Note& note, ByteWriter& out) {
  out.text(note.topic);
  out.bytes(bytes_of(note.text));
}

Note decode_note(ByteView body) {
  ByteReader in(body);
  Note note;
  note.topic = in.text(topic_size_max);
  const ByteView text = in.bytes(in.remaining());
  note.text.assign(text.begin(), text.end());
  return note;
}

}  // namespace ticktrue::replay
