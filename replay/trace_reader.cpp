// Walks the chunks of a trace, proves each before anything of it is given out, and tells truncation from damage.
// SPDX-License-Identifier: MIT
#include "replay/trace_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <utility>

#include "base/assert.h"
#include "base/hash.h"
#include "base/limits.h"
#include "replay/chunk.h"
#include "replay/file.h"
#include "replay/payload.h"

namespace ticktrue::replay {
namespace {

constexpr std::size_t read_ahead_size = 512u << 10;
constexpr std::size_t ticks_view_size = 32u << 10;  // a usual ticks chunk: 1024 ticks of 11 bytes and their inputs
constexpr std::size_t footer_size = chunk_header_size + 24 + chunk_trailer_size;
constexpr std::size_t intact_range_count_max = 1'000;  // a report, not a map
// Behind damage every valid header is tried. A real trace needs one try for each damaged place; forged headers that
// lead nowhere must not make the search quadratic.
constexpr int failed_try_count_max = 4'096;

/// What comes next in the file.
enum class Phase : std::uint8_t { body, index, footer, closed };

/// What reading one chunk gave.
enum class Step : std::uint8_t { passed, ticks, checkpoint, image, stop };

struct Fault {
  TraceCondition condition = TraceCondition::damaged;
  std::uint64_t offset = 0;
  std::string message;
};

/// Everything that says where reading is: copied to try a place, put back afterwards.
struct Cursor {
  std::uint64_t offset = 0;  // of the next chunk
  std::uint32_t sequence = 0;
  std::uint64_t chain = 0;
  std::uint64_t tick = 0;  // ticks done before the next chunk
  Phase phase = Phase::body;
  bool has_checkpoint = false;
  std::uint64_t last_checkpoint = 0;

  // A state image whose parts are being read.
  std::uint8_t part_kind = 0;  // 0: none
  ImagePart part;              // the part before; `stored` is not used

  bool expects_image = false;  // the last tick said that its image follows
  bool has_pending = false;    // inputs of a tick without hash stand at the end of the last ticks chunk
  double pending_dt = 0;
  Bytes pending_inputs;
};

bool is_dt(double dt) {
  return std::isfinite(dt) && dt >= 0;
}

std::string hex16(std::uint64_t value) {
  return hex32(static_cast<std::uint32_t>(value)).substr(4);
}

std::string kind_name(std::uint8_t kind) {
  if (const ChunkKindInfo* info = chunk_kind_info(kind)) return std::string(info->name);
  return kind >= private_kind_first ? "private" : "unknown";
}

}  // namespace

struct TraceReader::Impl {
  InputFile file;
  std::string name;
  TraceSetup setup;
  FactsPayload facts;
  std::uint64_t facts_check = 0;
  std::uint64_t seed = 0;            // of header checks, from the setup on
  Cursor start;                      // after setup and build facts
  std::optional<Fault> start_fault;  // nothing behind the setup can be read
  std::optional<Fault> facts_fault;  // damaged build facts do not keep ticks from being read

  Cursor cursor;
  Cursor image_start;                 // where the last state image began
  std::optional<Fault> fault;         // why reading stopped
  std::optional<Fault> first_damage;  // damage that did not stop it
  bool is_sequential = true;          // read from the start, so that the index can be compared
  CheckpointIndex seen;
  std::optional<EndRecord> end;
  std::uint64_t index_offset = 0;
  std::optional<std::uint64_t> index_check;

  // Window on the file.
  Bytes window;
  std::uint64_t window_offset = 0;

  // Records of the ticks chunk that is being given out.
  Bytes records;
  std::size_t walk_offset = 0;
  std::size_t walk_end = 0;  // behind the last root record
  std::uint64_t walk_tick = 0;
  double walk_dt = 0;
  std::uint64_t walk_file_offset = 0;  // of records[0]

  Bytes image;
  Item item;
  std::uint64_t item_offset = 0;
  TraceTail tail;
  bool has_tail = false;

  explicit Impl(InputFile opened, std::string called) : file(std::move(opened)), name(std::move(called)) {}

  /// At most `size` bytes from `offset`; fewer where the file ends. Valid until the next call.
  ByteView view(std::uint64_t offset, std::size_t size) {
    const bool is_inside = offset >= window_offset && offset - window_offset <= window.size() &&
                           size <= window.size() - static_cast<std::size_t>(offset - window_offset);
    if (!is_inside) {
      file.read(offset, std::max(size, read_ahead_size), window);
      window_offset = offset;
    }
    const auto at = static_cast<std::size_t>(offset - window_offset);
    return ByteView(window).subspan(at, std::min(size, window.size() - at));
  }

  std::uint64_t remaining() const { return file.size() - cursor.offset; }
  static std::uint64_t whole_size(const ChunkHeader& header) {
    return std::uint64_t{chunk_header_size} + header.size + chunk_trailer_size;
  }

  std::string chunk_text(std::uint8_t kind) const {
    return "chunk " + std::to_string(cursor.sequence) + " (" + kind_name(kind) + ")";
  }

  Step stop(TraceCondition condition, std::uint64_t offset, const std::string& what) {
    fault = Fault{condition, offset, "offset " + std::to_string(offset) + ": " + what};
    return Step::stop;
  }
  Step damaged(std::uint64_t offset, const std::string& what) { return stop(TraceCondition::damaged, offset, what); }
  Step truncated(const std::string& what) { return stop(TraceCondition::truncated, file.size(), what); }

  ChunkHeader expected_header() const {
    ChunkHeader header;
    header.sequence = cursor.sequence;
    header.tick = cursor.tick;
    header.chain = cursor.chain;
    return header;
  }

  /// The header at the cursor, if it is whole, right and the one that must come; else stops.
  std::optional<ChunkHeader> read_header(std::uint64_t header_seed) {
    const std::string place = "chunk " + std::to_string(cursor.sequence);
    const ByteView bytes = view(cursor.offset, chunk_header_size);
    if (bytes.size() < chunk_header_size) {
      if (may_begin_chunk(bytes, expected_header()))
        truncated("the file ends before " + place + " is whole: found " + std::to_string(bytes.size()) +
                  " bytes, expected at least " + std::to_string(chunk_header_size));
      else
        damaged(cursor.offset, place + ": header: found other bytes than a chunk begins with");
      return std::nullopt;
    }
    const std::optional<ChunkHeader> header = decode_chunk_header(bytes, header_seed);
    if (!header) {
      damaged(cursor.offset, place + ": header: its check does not match");
      return std::nullopt;
    }
    if (header->sequence != cursor.sequence)
      damaged(cursor.offset, place + ": order: found chunk " + std::to_string(header->sequence) + ", expected " +
                                 std::to_string(cursor.sequence));
    else if (header->chain != cursor.chain)
      damaged(cursor.offset,
              place + ": chain value: found " + hex64(header->chain) + ", expected " + hex64(cursor.chain));
    else if (header->tick != cursor.tick)
      damaged(cursor.offset, place + ": first tick: found " + std::to_string(header->tick) + ", expected " +
                                 std::to_string(cursor.tick));
    else
      return header;
    return std::nullopt;
  }

  /// The payload of a chunk with stated size, if all of it is there and right; else stops.
  std::optional<ByteView> read_payload(const ChunkHeader& header, std::size_t size_max) {
    if (header.size > size_max) {
      damaged(cursor.offset, chunk_text(header.kind) + ": size: found " + std::to_string(header.size) +
                                 ", expected at most " + std::to_string(size_max));
      return std::nullopt;
    }
    const std::uint64_t whole = whole_size(header);
    if (whole > remaining()) {
      truncated("the file ends inside " + chunk_text(header.kind) + ": found " + std::to_string(remaining()) +
                " bytes of it, expected " + std::to_string(whole));
      return std::nullopt;
    }
    const ByteView bytes = view(cursor.offset, static_cast<std::size_t>(whole));
    if (bytes.size() < whole) {
      truncated("cannot read " + chunk_text(header.kind));
      return std::nullopt;
    }
    const ByteView payload = bytes.subspan(chunk_header_size, header.size);
    const std::uint64_t expected = hash64(payload, header.check);
    const std::uint64_t found = ByteReader(bytes.last(chunk_trailer_size)).u64();
    if (found != expected) {
      damaged(cursor.offset,
              chunk_text(header.kind) + ": checksum: found " + hex64(found) + ", expected " + hex64(expected));
      return std::nullopt;
    }
    return payload;
  }

  void pass(const ChunkHeader& header) {
    cursor.offset += whole_size(header);
    ++cursor.sequence;
  }

  // ---- Setup and build facts ----

  Status read_start() {
    const ByteView found = view(0, file_header_size);
    const std::size_t magic_size = std::min(found.size(), magic.size());
    if (!std::equal(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(magic_size), magic.begin()))
      return Error{ErrorCode::corrupt, name + ": offset 0: no trace: it does not begin with the mark of one",
                   "traces are made by `ticktrue record`"};
    if (found.size() < file_header_size)
      return Error{ErrorCode::truncated,
                   name + ": offset " + std::to_string(found.size()) + ": the file ends inside its header: found " +
                       std::to_string(found.size()) + " bytes, expected " + std::to_string(file_header_size),
                   ""};
    ByteReader in(found.subspan(magic.size()));
    const std::uint16_t version = in.u16();
    const std::uint16_t flags = in.u16();
    const std::uint32_t check = in.u32();
    if (check != static_cast<std::uint32_t>(hash64(found.first(12))))
      return Error{ErrorCode::corrupt, name + ": offset 8: file header: its check does not match", ""};
    if (version != format_version || flags != 0)
      return Error{ErrorCode::incompatible,
                   name + ": format version: found " + std::to_string(version) + " with flags " +
                       std::to_string(flags) + ", expected " + std::to_string(format_version) + " with flags 0",
                   version > format_version ? "use a newer ticktrue" : ""};

    cursor.offset = file_header_size;
    cursor.chain = chain_start();
    const std::optional<ChunkHeader> header = read_header(cursor.chain);
    if (!header) return start_error();
    if (header->kind != static_cast<std::uint8_t>(ChunkKind::setup)) {
      damaged(cursor.offset, chunk_text(header->kind) + ": kind: expected setup");
      return start_error();
    }
    const std::optional<ByteView> payload = read_payload(*header, limits::setup_size_max);
    if (!payload) return start_error();
    Result<TraceSetup> decoded = decode_setup(*payload);
    if (!decoded) {
      damaged(cursor.offset, decoded.error().message);
      return start_error();
    }
    setup = std::move(*decoded);
    cursor.chain = extend_chain(*header, {}, *payload);
    seed = cursor.chain;
    pass(*header);

    read_facts();
    if (!has_codec(facts.codec))
      return Error{ErrorCode::unsupported, name + ": build facts: state images are compressed with zstd",
                   "use a build with zstd"};
    start = cursor;
    start_fault = fault;
    window = {};  // it held the setup, which may be large
    rewind();
    return {};
  }

  /// The stop while reading the setup, as an error of open().
  Error start_error() const {
    const bool is_cut = fault->condition == TraceCondition::truncated;
    return {is_cut ? ErrorCode::truncated : ErrorCode::corrupt, name + ": " + fault->message,
            "without its setup nothing of a trace can be verified"};
  }

  void read_facts() {
    const std::optional<ChunkHeader> header = read_header(seed);
    if (header && header->kind == static_cast<std::uint8_t>(ChunkKind::facts)) {
      const std::optional<ByteView> payload = read_payload(*header, chunk_kind_info(header->kind)->payload_size_max);
      if (payload) {
        Result<FactsPayload> decoded = decode_facts(*payload);
        facts_check = hash64(*payload, header->check);
        if (decoded)
          facts = std::move(*decoded);
        else
          damaged(cursor.offset, decoded.error().message);
        pass(*header);
      } else if (fault->condition == TraceCondition::damaged && whole_size(*header) <= remaining()) {
        pass(*header);
      }
    } else if (header) {
      damaged(cursor.offset, chunk_text(header->kind) + ": kind: expected build facts");
    }
    if (!fault || fault->condition == TraceCondition::truncated) return;
    facts_fault = std::exchange(fault, std::nullopt);
    if (cursor.sequence == 2) return;
    // Its header is damaged: what follows is found by its own.
    std::uint64_t offset = cursor.offset;
    while (std::optional<ChunkHeader> next = find_header(offset)) {
      if (next->sequence == 2 && next->chain == cursor.chain && next->tick == 0) {
        cursor.offset = offset;
        cursor.sequence = 2;
        return;
      }
      ++offset;
    }
    fault = facts_fault;
  }

  /// Moves `offset` to the next valid header at or behind it.
  std::optional<ChunkHeader> find_header(std::uint64_t& offset) {
    while (offset + chunk_header_size <= file.size()) {
      const ByteView bytes = view(offset, read_ahead_size);
      if (bytes.size() < chunk_header_size) return std::nullopt;
      const std::size_t last = bytes.size() - chunk_header_size;
      std::size_t at = 0;
      while (at <= last) {
        const void* hit = std::memchr(bytes.data() + at, sync_marker[0], last - at + 1);
        if (hit == nullptr) {
          at = last + 1;
          break;
        }
        at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(hit) - bytes.data());
        if (const std::optional<ChunkHeader> header = decode_chunk_header(bytes.subspan(at), seed)) {
          offset += at;
          return header;
        }
        ++at;
      }
      offset += at;
    }
    return std::nullopt;
  }

  // ---- Chunks ----

  Step read_chunk() {
    if (fault) return Step::stop;
    if (cursor.phase == Phase::closed) {
      if (remaining() == 0) return stop(TraceCondition::complete, file.size(), "");
      return damaged(cursor.offset, "behind the footer: found " + std::to_string(remaining()) +
                                        " more bytes, expected the end of the file");
    }
    if (remaining() == 0)
      return truncated("the file ends before chunk " + std::to_string(cursor.sequence) + ": expected " +
                       (cursor.phase == Phase::body ? "more ticks or an end" : "index and footer"));
    const std::optional<ChunkHeader> header = read_header(seed);
    if (!header) return Step::stop;
    if (const char* wanted = wanted_kind(*header))
      return damaged(cursor.offset, chunk_text(header->kind) + ": kind: found " + std::to_string(header->kind) +
                                        ", expected " + wanted);
    if (header->kind >= private_kind_first) return read_private(*header);
    switch (static_cast<ChunkKind>(header->kind)) {
      case ChunkKind::ticks:
        return read_ticks(*header);
      case ChunkKind::checkpoint:
      case ChunkKind::image:
        return read_image_part(*header);
      case ChunkKind::end:
        return read_end(*header);
      case ChunkKind::index:
        return read_index(*header);
      default:
        return read_footer(*header);
    }
  }

  /// Null if a chunk of this kind may come here, else what may.
  const char* wanted_kind(const ChunkHeader& header) const {
    const auto is = [&](ChunkKind kind) { return header.kind == static_cast<std::uint8_t>(kind); };
    if (cursor.phase == Phase::index) return is(ChunkKind::index) ? nullptr : "the index";
    if (cursor.phase == Phase::footer) return is(ChunkKind::footer) ? nullptr : "the footer";
    if (cursor.part_kind != 0) return header.kind == cursor.part_kind ? nullptr : "the next part of a state image";
    if (cursor.expects_image) return is(ChunkKind::image) ? nullptr : "the image of the last tick";
    if (header.kind >= private_kind_first) return cursor.has_pending ? "the end" : nullptr;
    if (is(ChunkKind::end)) return nullptr;
    if (cursor.has_pending) return "the end, since inputs of an unfinished tick came before";
    if (is(ChunkKind::checkpoint)) {
      if (!cursor.has_checkpoint) return header.tick == 0 ? nullptr : "the checkpoint at tick 0 first";
      return header.tick > cursor.last_checkpoint ? nullptr : "at most one checkpoint for a tick";
    }
    if (is(ChunkKind::ticks)) return cursor.has_checkpoint ? nullptr : "the checkpoint at tick 0 first";
    return "checkpoint, ticks or end";
  }

  Step read_private(const ChunkHeader& header) {
    const std::optional<ByteView> payload = read_payload(header, limits::chunk_size_max);
    if (!payload) return Step::stop;
    cursor.chain = extend_chain(header, {}, *payload);
    pass(header);
    return Step::passed;
  }

  Step read_image_part(const ChunkHeader& header) {
    const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
    if (!payload) return Step::stop;
    const Result<ImagePart> part = decode_image_part(*payload);
    if (!part) return damaged(cursor.offset, chunk_text(header.kind) + ": " + part.error().message);
    const ImagePart& before = cursor.part;
    const bool is_first = cursor.part_kind == 0;
    if (is_first ? part->offset != 0
                 : part->offset != before.offset + before.size || part->image_size != before.image_size ||
                       part->root_hash != before.root_hash)
      return damaged(cursor.offset, chunk_text(header.kind) + ": state image: a part of another place or image");
    if (is_first) {
      image.clear();
      image_start = cursor;
    }
    const std::size_t raw_offset = image.size();
    if (const Status status = unpack_image_part(*part, image); !status)
      return damaged(cursor.offset, chunk_text(header.kind) + ": " + status.error().message);
    cursor.chain = extend_chain(header, payload->first(image_part_fields_size), ByteView(image).subspan(raw_offset));
    pass(header);
    cursor.part = *part;
    cursor.part.stored = {};
    if (part->offset + part->size < part->image_size) {
      cursor.part_kind = header.kind;
      return Step::passed;
    }
    cursor.part_kind = 0;
    if (header.kind == static_cast<std::uint8_t>(ChunkKind::image)) {
      cursor.expects_image = false;
      return Step::image;
    }
    cursor.has_checkpoint = true;
    cursor.last_checkpoint = cursor.tick;
    if (is_sequential) seen.add({cursor.tick, image_start.offset});
    return Step::checkpoint;
  }

  /// Proves a ticks chunk record by record and keeps its records for walk(). At the end of a truncated file the
  /// records up to the cut are kept.
  Step read_ticks(const ChunkHeader& header) {
    std::uint64_t running = header.check;
    std::size_t at = chunk_header_size;  // of the next record
    std::size_t ticks_end = at;          // behind the last root record
    std::uint64_t tick = cursor.tick;
    double dt = setup.dt;
    bool has_image = false;
    std::uint8_t last_tag = 0;  // in the tick: records come in the order of their tags
    bool is_pending = false;    // dt or inputs came, the root hash not yet
    std::size_t inputs_offset = 0, inputs_size = 0;
    std::size_t want = ticks_view_size;
    ByteView bytes = view(cursor.offset, want);
    for (;;) {
      const Record record = parse_record(bytes.subspan(at), &running);
      const std::uint64_t place = cursor.offset + at;
      if (record.fault == RecordFault::ends_early) {
        if (at + record.size > limits::chunk_size_max)
          return damaged(place, chunk_text(header.kind) + ": size: found more than " +
                                    std::to_string(limits::chunk_size_max) + " bytes");
        if (bytes.size() < want || place + record.size > file.size()) break;
        want = std::min(std::max(at + record.size, 2 * want), limits::chunk_size_max);
        bytes = view(cursor.offset, want);
        continue;
      }
      if (record.fault != RecordFault::none) return damaged(place, chunk_text(header.kind) + ": " + fault_text(record));
      if (has_image && record.tag != static_cast<std::uint8_t>(RecordTag::close))
        return damaged(place, chunk_text(header.kind) + ": found a record behind a tick with image, expected close");
      if (record.tag < private_kind_first && record.tag != static_cast<std::uint8_t>(RecordTag::close)) {
        if (record.tag <= last_tag)
          return damaged(place, chunk_text(header.kind) + ": record order: found tag " + std::to_string(record.tag) +
                                    " after " + std::to_string(last_tag));
        last_tag = record.tag;
        is_pending = is_pending || record.tag <= static_cast<std::uint8_t>(RecordTag::inputs);
      }
      const std::size_t body_offset = static_cast<std::size_t>(record.body.data() - bytes.data());
      at += record.size;
      switch (static_cast<RecordTag>(record.tag)) {
        case RecordTag::dt:
          dt = ByteReader(record.body).f64();
          if (!is_dt(dt)) return damaged(place, chunk_text(header.kind) + ": dt: found no finite length of time");
          break;
        case RecordTag::inputs:
          inputs_offset = body_offset;
          inputs_size = record.body.size();
          break;
        case RecordTag::stages:
          if (!is_full(tick) || record.body.size() != 8 * setup.stages.size())
            return damaged(place, chunk_text(header.kind) + ": stage hashes: found " +
                                      std::to_string(record.body.size() / 8) + " where the setup has none or " +
                                      std::to_string(setup.stages.size()));
          break;
        case RecordTag::root_image:
          if (!is_full(tick))
            return damaged(place, chunk_text(header.kind) + ": image: found one of a tick not stored in full");
          has_image = true;
          [[fallthrough]];
        case RecordTag::root:
          ++tick;
          if (tick > limits::tick_count_max)
            return damaged(place, chunk_text(header.kind) + ": tick count: found more than " +
                                      std::to_string(limits::tick_count_max));
          ticks_end = at;
          last_tag = 0;
          is_pending = false;
          inputs_size = 0;
          break;
        case RecordTag::close: {
          const std::uint32_t count = ByteReader(record.body).u32();
          if (count != tick - cursor.tick)
            return damaged(place, chunk_text(header.kind) + ": tick count: found " + std::to_string(count) +
                                      ", expected " + std::to_string(tick - cursor.tick));
          if (last_tag > static_cast<std::uint8_t>(RecordTag::inputs))
            return damaged(place, chunk_text(header.kind) + ": found stage hashes without a root hash");
          keep_ticks(bytes, ticks_end, tick);
          if (is_pending) keep_pending(dt, bytes.subspan(inputs_offset, inputs_size));
          cursor.offset += at;
          ++cursor.sequence;
          cursor.chain = running;
          cursor.expects_image = has_image;
          return walk_end > 0 ? Step::ticks : Step::passed;
        }
        default:
          break;  // private
      }
    }
    // A flipped size can pretend a cut: then a whole chunk follows behind it.
    std::uint64_t behind = cursor.offset + at;
    const std::uint64_t cut = behind;
    if (find_header(behind))
      return damaged(cut, chunk_text(header.kind) + ": found a record that does not end before the next chunk");
    truncated("the file ends inside " + chunk_text(header.kind) + ": found " + std::to_string(tick - cursor.tick) +
              " whole ticks of it");
    bytes = view(cursor.offset, at);
    if (bytes.size() < at) return Step::stop;  // the file shrank meanwhile
    keep_ticks(bytes, ticks_end, tick);
    if (is_pending) keep_pending(dt, bytes.subspan(inputs_offset, inputs_size));
    return walk_end > 0 ? Step::ticks : Step::stop;
  }

  bool is_full(std::uint64_t tick) const {
    return setup.detail == Detail::full && setup.full_first <= tick && tick <= setup.full_last;
  }

  static std::string fault_text(const Record& record) {
    switch (record.fault) {
      case RecordFault::unknown_tag:
        return "record tag: found " + std::to_string(record.tag) + ", expected 1..3, 5, 6, 15 or 128..255";
      case RecordFault::bad_size:
        return "record size: found one that is not allowed for tag " + std::to_string(record.tag);
      default:
        if (record.tag != static_cast<std::uint8_t>(RecordTag::close))
          return "record check: found " + hex16(record.check_found) + ", expected " + hex16(record.check_expected);
        return "chain value: found " + hex64(record.check_found) + ", expected " + hex64(record.check_expected);
    }
  }

  void keep_ticks(ByteView bytes, std::size_t ticks_end, std::uint64_t tick) {
    records.assign(bytes.begin() + chunk_header_size, bytes.begin() + static_cast<std::ptrdiff_t>(ticks_end));
    walk_offset = 0;
    walk_end = records.size();
    walk_tick = cursor.tick;
    walk_dt = setup.dt;
    walk_file_offset = cursor.offset + chunk_header_size;
    cursor.tick = tick;
  }

  void keep_pending(double dt, ByteView inputs) {
    cursor.has_pending = true;
    cursor.pending_dt = dt;
    cursor.pending_inputs.assign(inputs.begin(), inputs.end());
  }

  Step read_end(const ChunkHeader& header) {
    const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
    if (!payload) return Step::stop;
    Result<EndRecord> decoded = decode_end(*payload, header.tick);
    if (!decoded) return damaged(cursor.offset, decoded.error().message);
    end = std::move(*decoded);
    cursor.chain = extend_chain(header, {}, *payload);
    pass(header);
    cursor.phase = Phase::index;
    return Step::passed;
  }

  Step read_index(const ChunkHeader& header) {
    const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
    index_offset = cursor.offset;
    if (payload) {
      index_check = hash64(*payload, header.check);
      const Result<CheckpointIndex> index = decode_index(*payload);
      if (!index)
        damaged(cursor.offset, index.error().message);
      else if (is_sequential && (index->stride != seen.stride || index->entries != seen.entries))
        damaged(cursor.offset, "index: found other places than the checkpoints have");
    }
    if (fault) {
      // All ticks were read by now, and the header says where the footer is: go on, and report it at the end.
      if (fault->condition == TraceCondition::truncated || whole_size(header) > remaining()) return Step::stop;
      note_damage(*std::exchange(fault, std::nullopt));
    }
    pass(header);
    cursor.phase = Phase::footer;
    return Step::passed;
  }

  Step read_footer(const ChunkHeader& header) {
    const std::optional<ByteView> payload = read_payload(header, chunk_kind_info(header.kind)->payload_size_max);
    if (!payload) return Step::stop;
    const Result<Footer> footer = decode_footer(*payload);
    if (!footer) return damaged(cursor.offset, footer.error().message);
    if (footer->index_offset != index_offset || (index_check && footer->index_check != *index_check))
      return damaged(cursor.offset, "footer: found the place or checksum of another index");
    if (!facts_fault && footer->facts_check != facts_check)
      return damaged(cursor.offset, "footer: build facts: found checksum " + hex64(facts_check) + ", expected " +
                                        hex64(footer->facts_check) + " (they belong to another recording)");
    pass(header);
    cursor.phase = Phase::closed;
    return Step::passed;
  }

  void note_damage(Fault damage) {
    if (!first_damage) first_damage = std::move(damage);
  }

  // ---- Giving out ----

  void rewind() {
    cursor = start;
    fault = start_fault;
    first_damage = facts_fault;
    is_sequential = true;
    seen = {};
    end.reset();
    index_check.reset();
    walk_offset = walk_end = 0;
    tail = {};
    has_tail = false;
    item_offset = cursor.offset;
    item = std::monostate{};
  }

  const Item& next() {
    for (;;) {
      if (walk_offset < walk_end) return walk();
      switch (read_chunk()) {
        case Step::checkpoint: {
          CheckpointRecord record;
          record.tick = cursor.tick;
          record.root_hash = cursor.part.root_hash;
          record.image = image;
          item_offset = cursor.offset;
          return item = record;
        }
        case Step::stop:
          make_tail();
          item_offset = cursor.offset;
          return item = std::monostate{};
        default:
          break;
      }
    }
  }

  /// Gives out the next tick of the chunk in `records`, which is proven.
  const Item& walk() {
    if (!std::holds_alternative<TickRecord>(item)) item = TickRecord{};
    TickRecord& record = std::get<TickRecord>(item);
    record.tick = walk_tick++;
    record.inputs = {};
    record.stage_hashes.clear();
    record.image.reset();
    for (;;) {
      const Record part = parse_record(ByteView(records).subspan(walk_offset), nullptr);
      TICKTRUE_ASSERT(part.fault == RecordFault::none);
      walk_offset += part.size;
      ByteReader in(part.body);
      const auto tag = static_cast<RecordTag>(part.tag);
      if (tag == RecordTag::dt) walk_dt = in.f64();
      if (tag == RecordTag::inputs) record.inputs = part.body;
      if (tag == RecordTag::stages)
        while (!in.at_end()) record.stage_hashes.push_back(in.u64());
      if (tag != RecordTag::root && tag != RecordTag::root_image) continue;
      record.dt = walk_dt;
      record.root_hash = in.u64();
      item_offset = walk_file_offset + walk_offset;
      if (tag == RecordTag::root_image) {
        Step step = read_chunk();
        while (step == Step::passed) step = read_chunk();
        if (step == Step::image) {
          record.image = ByteView(image);
          item_offset = cursor.offset;
        }
      }
      return item;
    }
  }

  void make_tail() {
    if (std::exchange(has_tail, true)) return;
    tail.ticks_intact = cursor.tick;
    tail.end = end;
    if (cursor.has_pending) {
      tail.has_pending_inputs = true;
      tail.pending_dt = cursor.pending_dt;
      tail.pending_inputs = cursor.pending_inputs;
    }
    const Fault& shown = first_damage ? *first_damage : *fault;
    tail.condition = shown.condition;
    tail.offset = shown.offset;
    tail.message = shown.condition == TraceCondition::complete ? "" : shown.message;
    if (fault->condition == TraceCondition::damaged && cursor.phase == Phase::body) tail.intact_after = find_intact();
  }

  /// What is whole behind the damage at the cursor.
  std::vector<IntactRange> find_intact() {
    const Cursor kept_cursor = cursor;
    const auto kept_fault = std::exchange(fault, std::nullopt);
    const auto kept_end = end;
    const auto kept_damage = first_damage;
    const bool kept_sequential = std::exchange(is_sequential, false);
    std::vector<IntactRange> ranges;
    std::uint64_t offset = cursor.offset + 1;
    int failed_try_count = 0;
    while (ranges.size() < intact_range_count_max && failed_try_count < failed_try_count_max) {
      const std::optional<ChunkHeader> header = find_header(offset);
      if (!header) break;
      resume_at(offset, *header);
      IntactRange range;
      bool has_ticks = false;
      bool is_whole = false;
      std::optional<std::uint64_t> checkpoint;  // the first in this range
      for (;;) {
        const std::uint64_t first_tick = cursor.tick;
        const Step step = read_chunk();
        if (step == Step::stop || fault) break;  // a chunk that is cut off is not whole
        is_whole = true;
        if (step == Step::ticks) {
          if (!has_ticks) range.first_tick = first_tick;
          has_ticks = true;
          range.last_tick = cursor.tick - 1;
        }
        if (step == Step::checkpoint && !checkpoint) checkpoint = cursor.tick;
      }
      fault.reset();
      if (has_ticks) {
        range.has_checkpoint = checkpoint && *checkpoint <= range.last_tick;
        ranges.push_back(range);
      }
      if (!is_whole) ++failed_try_count;
      offset = std::max(cursor.offset, offset + 1);
    }
    walk_offset = walk_end = 0;
    cursor = kept_cursor;
    fault = kept_fault;
    end = kept_end;
    first_damage = kept_damage;
    is_sequential = kept_sequential;
    return ranges;
  }
  /// Puts the cursor at a header whose check is right, whatever came before it.
  void resume_at(std::uint64_t offset, const ChunkHeader& header) {
    cursor = Cursor{};
    cursor.offset = offset;
    cursor.sequence = header.sequence;
    cursor.chain = header.chain;
    cursor.tick = header.tick;
    cursor.has_checkpoint = true;
    const bool is_checkpoint = header.kind == static_cast<std::uint8_t>(ChunkKind::checkpoint);
    if (is_checkpoint && header.tick == 0) cursor.has_checkpoint = false;
    if (is_checkpoint && header.tick > 0) cursor.last_checkpoint = header.tick - 1;
    if (header.kind == static_cast<std::uint8_t>(ChunkKind::index)) cursor.phase = Phase::index;
    if (header.kind == static_cast<std::uint8_t>(ChunkKind::footer)) cursor.phase = Phase::footer;
    if (header.kind == static_cast<std::uint8_t>(ChunkKind::image)) cursor.expects_image = true;
  }

  // ---- Seeking ----

  /// Header and payload of the footer and the index, if both are right.
  std::optional<ChunkHeader> footer_header(Footer& footer) {
    if (file.size() < footer_size) return std::nullopt;
    const ByteView bytes = view(file.size() - footer_size, footer_size);
    if (bytes.size() < footer_size) return std::nullopt;
    const std::optional<ChunkHeader> header = decode_chunk_header(bytes, seed);
    if (!header || header->kind != static_cast<std::uint8_t>(ChunkKind::footer) || header->size != 24)
      return std::nullopt;
    const ByteView payload = bytes.subspan(chunk_header_size, header->size);
    if (ByteReader(bytes.last(chunk_trailer_size)).u64() != hash64(payload, header->check)) return std::nullopt;
    const Result<Footer> decoded = decode_footer(payload);
    if (!decoded) return std::nullopt;
    footer = *decoded;
    return header;
  }

  std::optional<CheckpointIndex> read_index_directly() {
    Footer footer;
    if (!footer_header(footer)) return std::nullopt;
    if (footer.index_offset >= file.size()) return std::nullopt;
    const ByteView head = view(footer.index_offset, chunk_header_size);
    if (head.size() < chunk_header_size) return std::nullopt;
    const std::optional<ChunkHeader> header = decode_chunk_header(head, seed);
    const ChunkKindInfo& info = *chunk_kind_info(static_cast<std::uint8_t>(ChunkKind::index));
    if (!header || header->kind != static_cast<std::uint8_t>(info.kind) || header->size > info.payload_size_max)
      return std::nullopt;
    const ByteView bytes = view(footer.index_offset, chunk_header_size + header->size + chunk_trailer_size);
    if (bytes.size() < chunk_header_size + header->size + chunk_trailer_size) return std::nullopt;
    const ByteView payload = bytes.subspan(chunk_header_size, header->size);
    if (hash64(payload, header->check) != footer.index_check) return std::nullopt;
    Result<CheckpointIndex> index = decode_index(payload);
    if (!index) return std::nullopt;
    return std::move(*index);
  }

  bool seek(std::uint64_t tick) {
    rewind();
    std::optional<Cursor> found;
    bool is_exact = false;
    if (const std::optional<CheckpointIndex> index = read_index_directly()) {
      const auto after =
          std::upper_bound(index->entries.begin(), index->entries.end(), tick,
                           [](std::uint64_t wanted, const IndexEntry& entry) { return wanted < entry.tick; });
      if (after == index->entries.begin()) return false;
      const IndexEntry& entry = *std::prev(after);
      const ByteView head = view(entry.offset, chunk_header_size);
      const std::optional<ChunkHeader> header =
          head.size() < chunk_header_size ? std::nullopt : decode_chunk_header(head, seed);
      if (header && header->kind == static_cast<std::uint8_t>(ChunkKind::checkpoint) && header->tick == entry.tick) {
        resume_at(entry.offset, *header);
        found = cursor;
        is_exact = index->stride == 1;
      }
    }
    // Without an index, or between its entries, the chunks themselves say where checkpoints are.
    is_sequential = false;
    while (!is_exact && cursor.tick <= tick) {
      const Step step = read_chunk();
      if (step == Step::stop) break;
      if (step == Step::checkpoint && cursor.tick <= tick) found = image_start;
    }
    const Cursor target = found.value_or(start);
    rewind();  // what the search met is met again by reading on
    if (!found) return false;
    fault.reset();
    cursor = target;
    is_sequential = false;
    item_offset = cursor.offset;
    return true;
  }

  std::optional<std::uint64_t> tick_count_hint() {
    Footer footer;
    const std::optional<ChunkHeader> header = footer_header(footer);
    if (!header) return std::nullopt;
    return header->tick;
  }
};

TraceReader::TraceReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TraceReader::TraceReader(TraceReader&&) noexcept = default;
TraceReader& TraceReader::operator=(TraceReader&&) noexcept = default;
TraceReader::~TraceReader() = default;

Result<TraceReader> TraceReader::open(const std::string& path, std::uint64_t size_max) {
  Result<InputFile> file = InputFile::open(path);
  if (!file) return file.error();
  file->cut(size_max);
  auto impl = std::make_unique<Impl>(std::move(*file), path);
  if (const Status status = impl->read_start(); !status) return status.error();
  return TraceReader(std::move(impl));
}

Result<TraceReader> TraceReader::open_bytes(ByteView bytes, const std::string& name) {
  auto impl = std::make_unique<Impl>(InputFile::of_bytes(bytes), name);
  if (const Status status = impl->read_start(); !status) return status.error();
  return TraceReader(std::move(impl));
}

const TraceSetup& TraceReader::setup() const {
  return impl_->setup;
}
const BuildFacts& TraceReader::facts() const {
  return impl_->facts.facts;
}
const std::string& TraceReader::name() const {
  return impl_->name;
}
std::uint64_t TraceReader::size() const {
  return impl_->file.size();
}
bool TraceReader::is_compressed() const {
  return impl_->facts.codec != Codec::none;
}

const TraceReader::Item& TraceReader::next() {
  return impl_->next();
}
std::uint64_t TraceReader::offset() const {
  return impl_->item_offset;
}

const TraceTail& TraceReader::tail() const {
  TICKTRUE_ASSERT(impl_->fault.has_value());
  return impl_->tail;
}

bool TraceReader::seek(std::uint64_t tick) {
  return impl_->seek(tick);
}
void TraceReader::rewind() {
  impl_->rewind();
}
std::optional<std::uint64_t> TraceReader::tick_count_hint() const {
  return impl_->tick_count_hint();
}

}  // namespace ticktrue::replay
