// Encodes and decodes the log. Each part has a kind and a size, so that a truncated part is recognised.
// SPDX-License-Identifier: MIT
#include "replay/format/mark_log.h"

#include "base/limits.h"
#include "replay/format/mark_tally.h"

namespace ticktrue::replay {
namespace {

constexpr std::uint8_t kind_tick = 1;
constexpr std::uint8_t kind_list = 2;
constexpr std::size_t path_size_max = 4'096;

void put_part(std::uint8_t kind, const ByteWriter& body, ByteWriter& out) {
  out.u8(kind);
  out.varint(body.size());
  out.bytes(body.view());
}

/// Reads a count. A log with more than `max` elements is not from a session.
std::uint64_t read_count(ByteReader& in, std::uint64_t max) {
  const std::uint64_t count = in.varint();
  if (count > max) in.fail();
  return in.ok() ? count : 0;
}

/// Reads an index of one of `count` earlier elements.
std::uint32_t checked_index(ByteReader& in, std::uint64_t index, std::size_t count) {
  if (index >= count) in.fail();
  return in.ok() ? static_cast<std::uint32_t>(index) : 0;
}

LoggedTick read_tick(ByteReader& in) {
  LoggedTick tick;
  tick.tick = in.u64();
  if (in.u8() == 0) return tick;
  TickMarks& marks = tick.marks.emplace();
  marks.trail = in.u64();
  const std::uint64_t count = read_count(in, MarkTally::name_count_max);
  for (std::uint64_t i = 0; i < count && in.ok(); ++i) {
    NameMarks& name = marks.names.emplace_back();
    name.name = in.text(limits::name_size_max);
    name.count = in.varint();
    name.hash = in.u32();
  }
  return tick;
}

void read_stacks(ByteReader& in, std::size_t mark_count, MarkStacks& stacks) {
  const std::uint64_t module_count = read_count(in, listed_module_count_max);
  for (std::uint64_t i = 0; i < module_count && in.ok(); ++i) {
    LogModule& module = stacks.modules.emplace_back();
    module.path = in.text(path_size_max);
    module.base = in.u64();
  }
  const std::uint64_t stack_count = read_count(in, listed_stack_count_max);
  for (std::uint64_t i = 0; i < stack_count && in.ok(); ++i) {
    auto& stack = stacks.stacks.emplace_back();
    const std::uint64_t depth = read_count(in, listed_stack_depth_max);
    for (std::uint64_t k = 0; k < depth && in.ok(); ++k) {
      LogFrame& frame = stack.emplace_back();
      frame.module = checked_index(in, in.u32(), stacks.modules.size());
      frame.offset = in.u64();
    }
  }
  if (stack_count == 0) return;
  for (std::size_t i = 0; i < mark_count && in.ok(); ++i)
    stacks.of_marks.push_back(checked_index(in, in.varint(), stacks.stacks.size()));
}

LoggedList read_list(ByteReader& in) {
  LoggedList list;
  list.tick = in.u64();
  list.list.is_cut = in.u8() != 0;
  const std::uint64_t name_count = read_count(in, MarkTally::name_count_max);
  for (std::uint64_t i = 0; i < name_count && in.ok(); ++i) list.list.names.push_back(in.text(limits::name_size_max));
  const std::uint64_t mark_count = read_count(in, listed_mark_count_max);
  for (std::uint64_t i = 0; i < mark_count && in.ok(); ++i) {
    Mark& mark = list.list.marks.emplace_back();
    mark.name = checked_index(in, in.varint(), list.list.names.size());
    mark.value = in.u64();
  }
  read_stacks(in, list.list.marks.size(), list.stacks);
  return list;
}

}  // namespace

void encode_logged_tick(const LoggedTick& tick, ByteWriter& out) {
  ByteWriter body;
  body.u64(tick.tick);
  body.u8(tick.marks ? 1 : 0);
  if (tick.marks) {
    body.u64(tick.marks->trail);
    body.varint(tick.marks->names.size());
    for (const NameMarks& name : tick.marks->names) {
      body.text(name.name);
      body.varint(name.count);
      body.u32(name.hash);
    }
  }
  put_part(kind_tick, body, out);
}

void encode_logged_list(const LoggedList& list, ByteWriter& out) {
  ByteWriter body;
  body.u64(list.tick);
  body.u8(list.list.is_cut ? 1 : 0);
  body.varint(list.list.names.size());
  for (const std::string& name : list.list.names) body.text(name);
  body.varint(list.list.marks.size());
  for (const Mark& mark : list.list.marks) {
    body.varint(mark.name);
    body.u64(mark.value);
  }
  body.varint(list.stacks.modules.size());
  for (const LogModule& module : list.stacks.modules) {
    body.text(module.path);
    body.u64(module.base);
  }
  body.varint(list.stacks.stacks.size());
  for (const auto& stack : list.stacks.stacks) {
    body.varint(stack.size());
    for (const LogFrame& frame : stack) {
      body.u32(frame.module);
      body.u64(frame.offset);
    }
  }
  for (const std::uint32_t stack : list.stacks.of_marks) body.varint(stack);
  put_part(kind_list, body, out);
}

MarkLog decode_mark_log(ByteView bytes) {
  MarkLog log;
  ByteReader in(bytes);
  while (!in.at_end()) {
    const std::uint8_t kind = in.u8();
    const std::uint64_t size = in.varint();
    if (!in.ok() || size > in.remaining()) return log;
    ByteReader body(in.bytes(static_cast<std::size_t>(size)));
    if (kind == kind_tick) {
      LoggedTick tick = read_tick(body);
      if (!body.ok() || !body.at_end() || (!log.ticks.empty() && tick.tick <= log.ticks.back().tick)) return log;
      log.ticks.push_back(std::move(tick));
    } else if (kind == kind_list) {
      LoggedList list = read_list(body);
      if (!body.ok() || !body.at_end()) return log;
      log.list = std::move(list);
    } else {
      return log;
    }
  }
  return log;
}

}  // namespace ticktrue::replay
