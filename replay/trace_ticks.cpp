// Reads ticks chunks. Each record is verified before a tick of the chunk is returned.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "base/hash.h"
#include "base/limits.h"
#include "replay/format/bound_records.h"
#include "replay/trace_reader_impl.h"

namespace ticktrue::replay {
namespace {

constexpr std::size_t ticks_view_size = 32u << 10;  // an ordinary ticks chunk: 1024 ticks of 11 bytes, and inputs

std::string hex16(std::uint64_t value) {
  return hex32(static_cast<std::uint32_t>(value)).substr(4);
}

bool is_tag(std::uint8_t tag, RecordTag wanted) {
  return tag == static_cast<std::uint8_t>(wanted);
}

}  // namespace

/// The result of the records of a ticks chunk so far.
struct TicksScan {
  std::uint64_t tick = 0;
  double dt = 0;
  bool has_image = false;
  std::uint8_t last_tag = 0;  // in the tick: records of the chain are in the order of their tags
  bool is_pending = false;    // dt or inputs were read, the root hash was not
  std::size_t inputs_offset = 0;
  std::size_t inputs_size = 0;
  std::size_t ticks_end = chunk_header_size;  // after the last root record
  BoundRules bound;
  std::optional<Fault> bound_fault;  // damage to a record outside the chain
};

/// Returns why the record must not be in this tick; empty: it may. `offset`: of its body in the chunk.
std::string TraceReader::Impl::check_record(const Record& record, std::size_t offset, TicksScan& scan) {
  if (record.tag < bound_tag_first) {
    if (record.tag <= scan.last_tag)
      return "record order: found tag " + std::to_string(record.tag) + " after " + std::to_string(scan.last_tag);
    scan.last_tag = record.tag;
    scan.is_pending = scan.is_pending || record.tag <= static_cast<std::uint8_t>(RecordTag::inputs);
  }
  switch (static_cast<RecordTag>(record.tag)) {
    case RecordTag::dt:
      scan.dt = ByteReader(record.body).f64();
      return is_dt(scan.dt) ? "" : "dt: found no finite length of time";
    case RecordTag::inputs:
      scan.inputs_offset = offset;
      scan.inputs_size = record.body.size();
      return "";
    case RecordTag::stages:
      if (setup.has_stages(scan.tick) && record.body.size() == 8 * setup.stages.size()) return "";
      return "stage hashes: found " + std::to_string(record.body.size() / 8) + " where the setup has none or " +
             std::to_string(setup.stages.size());
    case RecordTag::cells:
      if (setup.detail == Detail::cells &&
          (cell_layout ? checked_cells.apply(*cell_layout, record.body) : check_cells(setup.schema, record.body)))
        return "";
      return "cells: found " + std::to_string(record.body.size()) +
             " bytes where the setup has no cells, or whose counts do not add up";
    case RecordTag::root_image:
      if (!setup.is_full(scan.tick)) return "image: found one of a tick not stored in full";
      scan.has_image = true;
      return "";
    default:
      return is_bound_tag(record.tag) ? scan.bound.check(record, setup, scan.tick) : "";
  }
}

/// To be called after a root record.
void TraceReader::Impl::end_scanned_tick(std::size_t tick_end, TicksScan& scan) {
  ++scan.tick;
  scan.ticks_end = tick_end;
  scan.last_tag = 0;
  scan.is_pending = false;
  scan.inputs_size = 0;
  scan.bound.end_tick();
}

/// Returns why the close record is wrong; empty: it is right.
std::string TraceReader::Impl::check_close(const Record& record, const TicksScan& scan) const {
  const std::uint32_t count = ByteReader(record.body).u32();
  if (count != scan.tick - cursor.tick)
    return "tick count: found " + std::to_string(count) + ", expected " + std::to_string(scan.tick - cursor.tick);
  if (scan.last_tag > static_cast<std::uint8_t>(RecordTag::inputs))
    return std::string("found ") + (is_tag(scan.last_tag, RecordTag::stages) ? "stage hashes" : "cells") +
           " without a root hash";
  return "";
}

Step TraceReader::Impl::read_ticks(const ChunkHeader& header) {
  Running running = begin_running(header, version);
  std::size_t at = chunk_header_size;  // of the next record
  TicksScan scan;
  scan.tick = cursor.tick;
  scan.dt = setup.dt;
  checked_cells.reset();
  std::size_t want = ticks_view_size;
  ByteView bytes = view(cursor.offset, want);
  const std::uint64_t reads = window_reads;
  for (;;) {
    const Record record = parse_record(bytes.subspan(at), &running, version);
    const std::uint64_t place = cursor.offset + at;
    const auto wrong = [&](const std::string& what) { return damaged(place, chunk_text(header.kind) + ": " + what); };
    if (record.fault == RecordFault::ends_early) {
      if (at + record.size > limits::chunk_size_max)
        return wrong("size: found more than " + std::to_string(limits::chunk_size_max) + " bytes");
      if (bytes.size() < want || place + record.size > file.size()) break;
      want = std::min(std::max(at + record.size, 2 * want), limits::chunk_size_max);
      bytes = view(cursor.offset, want);
      if (window_reads != reads && !is_as_read(bytes, at, header, running)) return changed(header);
      continue;
    }
    if (record.fault == RecordFault::bad_outside) {
      // No tick depends on this record: the chain values still prove the ticks.
      if (!scan.bound_fault) {
        wrong(fault_text(record));
        scan.bound_fault = std::exchange(fault, std::nullopt);
      }
    } else if (record.fault != RecordFault::none) {
      return wrong(fault_text(record));
    }
    const bool is_close = is_tag(record.tag, RecordTag::close);
    if (scan.has_image && !is_close && !is_bound_tag(record.tag))
      return wrong("found a record behind a tick with image, expected close");
    const auto body_offset = static_cast<std::size_t>(record.body.data() - bytes.data());
    at += record.size;
    if (is_close) {
      if (const std::string what = check_close(record, scan); !what.empty()) return wrong(what);
      if (scan.bound_fault) note_damage(*scan.bound_fault);
      set_ticks(bytes, scan.ticks_end, scan.tick, !scan.bound_fault);
      if (scan.is_pending) set_pending(scan.dt, bytes.subspan(scan.inputs_offset, scan.inputs_size));
      if (!scan.bound_fault) set_pending_notes(scan.dt, bytes.first(at - record.size).subspan(scan.ticks_end));
      cursor.offset += at;
      ++cursor.sequence;
      cursor.chain = running.chained;
      cursor.expects_image = scan.has_image;
      return walk_end > 0 ? Step::ticks : Step::passed;
    }
    if (is_bound_tag(record.tag) && scan.bound_fault) continue;
    if (const std::string what = check_record(record, body_offset, scan); !what.empty()) return wrong(what);
    if (!is_tag(record.tag, RecordTag::root) && !is_tag(record.tag, RecordTag::root_image)) continue;
    end_scanned_tick(at, scan);
    if (scan.tick > limits::tick_count_max)
      return wrong("tick count: found more than " + std::to_string(limits::tick_count_max));
  }
  // A wrong size can look like a truncated file. In this case an intact chunk follows.
  std::uint64_t behind = cursor.offset + at;
  const std::uint64_t cut = behind;
  if (find_header(behind))
    return damaged(cut, chunk_text(header.kind) + ": found a record that does not end before the next chunk");
  if (scan.bound_fault) {
    fault = scan.bound_fault;  // without the close record, no later tick is proven
    return Step::stop;
  }
  truncated("the file ends inside " + chunk_text(header.kind) + ": found " + std::to_string(scan.tick - cursor.tick) +
            " whole ticks of it");
  bytes = view(cursor.offset, at);
  if (!is_as_read(bytes, at, header, running)) return changed(header);
  set_ticks(bytes, scan.ticks_end, scan.tick, true);
  if (scan.is_pending) set_pending(scan.dt, bytes.subspan(scan.inputs_offset, scan.inputs_size));
  set_pending_notes(scan.dt, bytes.first(at).subspan(scan.ticks_end));
  return walk_end > 0 ? Step::ticks : Step::stop;
}

bool TraceReader::Impl::is_as_read(ByteView bytes, std::size_t size, const ChunkHeader& header,
                                   const Running& running) const {
  if (bytes.size() < size) return false;
  Running again = begin_running(header, version);
  std::size_t at = chunk_header_size;
  while (at < size) {
    const Record record = parse_record(bytes.first(size).subspan(at), &again, version);
    if (record.fault != RecordFault::none && record.fault != RecordFault::bad_outside) return false;
    at += record.size;
  }
  return again.chained == running.chained && again.outside == running.outside;
}

std::string TraceReader::Impl::fault_text(const Record& record) const {
  switch (record.fault) {
    case RecordFault::unknown_tag:
      return "record tag: found " + std::to_string(record.tag) + ", expected 1..6, 15" +
             (version >= format_version_third ? ", 64..67" : "") + " or 128..255";
    case RecordFault::bad_size:
      return "record size: found one that is not allowed for tag " + std::to_string(record.tag);
    default:
      if (!is_tag(record.tag, RecordTag::close))
        return "record check: found " + hex16(record.check_found) + ", expected " + hex16(record.check_expected);
      return std::string(record.fault == RecordFault::bad_outside ? "value of the records outside of the chain"
                                                                  : "chain value") +
             ": found " + hex64(record.check_found) + ", expected " + hex64(record.check_expected);
  }
}

void TraceReader::Impl::set_ticks(ByteView bytes, std::size_t ticks_end, std::uint64_t tick, bool has_bound) {
  records.assign(bytes.begin() + chunk_header_size, bytes.begin() + static_cast<std::ptrdiff_t>(ticks_end));
  walk_offset = 0;
  walk_end = records.size();
  walk_tick = cursor.tick;
  walk_dt = setup.dt;
  walk_file_offset = cursor.offset + chunk_header_size;
  walk_has_bound = has_bound;
  walk_names.clear();
  walk_cells.reset();
  cursor.tick = tick;
  cursor.pending_notes.clear();
}

void TraceReader::Impl::set_pending(double dt, ByteView inputs) {
  cursor.has_pending = true;
  cursor.pending_dt = dt;
  cursor.pending_inputs.assign(inputs.begin(), inputs.end());
}

void TraceReader::Impl::set_pending_notes(double dt, ByteView bytes) {
  cursor.pending_dt = dt;
  while (!bytes.empty()) {
    const Record record = parse_record(bytes, nullptr, version);
    if (record.fault != RecordFault::none) return;
    if (is_tag(record.tag, RecordTag::note)) cursor.pending_notes.push_back(decode_note(record.body));
    bytes = bytes.subspan(record.size);
  }
}

}  // namespace ticktrue::replay
