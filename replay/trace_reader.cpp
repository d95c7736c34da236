// Opens a trace and returns its ticks and checkpoints in file order.
// SPDX-License-Identifier: MIT
#include "replay/trace_reader.h"

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "base/hash.h"
#include "base/limits.h"
#include "replay/box/box_layout.h"
#include "replay/trace_reader_impl.h"

namespace ticktrue::replay {
Status TraceReader::Impl::read_start() {
  const ByteView found = view(0, file_header_size);
  if (is_box(found))
    return Error{ErrorCode::incompatible, name + ": a black box, expected a trace",
                 "`ticktrue recover " + name + " -o saved.ttr` makes a trace of it"};
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
  version = in.u16();
  const std::uint16_t flags = in.u16();
  const std::uint32_t check = in.u32();
  if (check != static_cast<std::uint32_t>(hash64(found.first(12))))
    return Error{ErrorCode::corrupt, name + ": offset 8: file header: its check does not match", ""};
  if (version < format_version_first || version > format_version || flags != 0)
    return Error{ErrorCode::incompatible,
                 name + ": format version: found " + std::to_string(version) + " with flags " + std::to_string(flags) +
                     ", expected " + std::to_string(format_version_first) + ".." + std::to_string(format_version) +
                     " with flags 0",
                 version > format_version ? "use a newer ticktrue" : ""};

  cursor.offset = file_header_size;
  cursor.chain = chain_start(version);
  const std::optional<ChunkHeader> header = read_header(cursor.chain);
  if (!header) return start_error();
  if (header->kind != static_cast<std::uint8_t>(ChunkKind::setup)) {
    damaged(cursor.offset, chunk_text(header->kind) + ": kind: expected setup");
    return start_error();
  }
  const std::optional<ByteView> payload = read_payload(*header, limits::setup_size_max);
  if (!payload) return start_error();
  Result<TraceSetup> decoded = decode_setup(*payload, version);
  if (!decoded) {
    damaged(cursor.offset, decoded.error().message);
    return start_error();
  }
  setup = std::move(*decoded);
  cursor.chain = extend_chain(*header, {}, *payload, version);
  seed = cursor.chain;
  pass(*header);
  begin_states();

  read_facts();
  if (!has_codec(facts.codec))
    return Error{ErrorCode::unsupported, name + ": build facts: state images are compressed with zstd",
                 "use a build with zstd"};
  find_first_tick();
  start = cursor;
  start_fault = fault;
  window = {};  // frees the setup, which can be large
  rewind();
  return {};
}

void TraceReader::Impl::begin_states() {
  for (std::uint32_t t = 0; t < setup.schema.tables.size(); ++t) all_tables.push_back(t);
  if (version < format_version_third) return;
  composed.reset(setup.schema.tables.size());
  if (setup.detail == Detail::cells) cell_layout.emplace(setup.schema);
}

void TraceReader::Impl::find_first_tick() {
  if (!setup.has(Feature::tail) || fault || remaining() < chunk_header_size) return;
  const std::optional<ChunkHeader> header = decode_chunk_header(view(cursor.offset, chunk_header_size), seed);
  if (!header || header->kind != static_cast<std::uint8_t>(ChunkKind::checkpoint)) return;
  if (header->tick <= limits::tick_count_max) first_tick = cursor.tick = header->tick;
}

Error TraceReader::Impl::start_error() const {
  const bool is_cut = fault->condition == TraceCondition::truncated;
  return {is_cut ? ErrorCode::truncated : ErrorCode::corrupt, name + ": " + fault->message,
          "without its setup nothing of a trace can be verified"};
}

void TraceReader::Impl::read_facts() {
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
  // The header is damaged: later chunks are found by their own headers.
  std::uint64_t offset = cursor.offset;
  while (std::optional<ChunkHeader> next = find_header(offset)) {
    if (next->sequence == 2 && next->chain == cursor.chain && (next->tick == 0 || setup.has(Feature::tail))) {
      cursor.offset = offset;
      cursor.sequence = 2;
      return;
    }
    ++offset;
  }
  fault = facts_fault;
}

void TraceReader::Impl::rewind() {
  cursor = start;
  fault = start_fault;
  first_damage = facts_fault;
  is_sequential = true;
  seen = {};
  peers.clear();
  unpacked_size = 0;
  composed.reset(setup.schema.tables.size());
  end.reset();
  index_check.reset();
  walk_offset = walk_end = 0;
  tail = {};
  has_tail = false;
  item_offset = cursor.offset;
  item = std::monostate{};
}

const TraceReader::Item& TraceReader::Impl::next() {
  for (;;) {
    if (walk_offset < walk_end) return walk();
    switch (read_chunk()) {
      case Step::checkpoint: {
        CheckpointRecord record;
        record.tick = cursor.tick;
        record.root_hash = cursor.part.root_hash;
        record.image = image;
        if (version >= format_version_third) {
          record.time_s = cursor.part.time_s;
          join_image(composed.tables(), joined);
          record.image = joined;
          read_contents();
          record.shown = shown_image();
          if (cursor.has_save) record.save = ByteView(save_bytes);
        }
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

/// Decodes the cells of a checked record.
const StateCells* TraceReader::Impl::read_cells(ByteView body) {
  if (!cell_layout) {
    decode_cells(setup.schema, body, cells);
    return &cells;
  }
  const bool is_right = walk_cells.apply(*cell_layout, body);
  TICKTRUE_ASSERT(is_right);
  return &walk_cells.cells();
}

/// Reads a checked record outside the chain.
void TraceReader::Impl::read_bound(const Record& part, TickRecord& record) {
  record.bound.push_back({part.tag, part.body});
  switch (static_cast<RecordTag>(part.tag)) {
    case RecordTag::name:
      walk_names.emplace_back(part.body.begin(), part.body.end());
      return;
    case RecordTag::marks:
      record.marks = decode_marks(part.body, walk_names);
      return;
    case RecordTag::mark_list:
      if (!record.mark_list) record.mark_list.emplace();
      decode_mark_list(part.body, walk_names, *record.mark_list);
      return;
    default:
      record.notes.push_back(decode_note(part.body));
  }
}

const TraceReader::Item& TraceReader::Impl::walk() {
  if (!std::holds_alternative<TickRecord>(item)) item = TickRecord{};
  TickRecord& record = std::get<TickRecord>(item);
  record.tick = walk_tick++;
  record.inputs = {};
  record.stage_hashes.clear();
  record.image.reset();
  record.shown.reset();
  record.cells = nullptr;
  record.bound.clear();
  record.has_bound = walk_has_bound;
  record.marks.reset();
  record.mark_list.reset();
  record.notes.clear();
  for (;;) {
    const Record part = parse_record(ByteView(records).subspan(walk_offset), nullptr, version);
    TICKTRUE_ASSERT(part.fault == RecordFault::none);
    walk_offset += part.size;
    ByteReader in(part.body);
    const auto tag = static_cast<RecordTag>(part.tag);
    if (tag == RecordTag::dt) walk_dt = in.f64();
    if (tag == RecordTag::inputs) record.inputs = part.body;
    if (tag == RecordTag::cells) record.cells = read_cells(part.body);
    if (is_bound_tag(part.tag) && walk_has_bound) read_bound(part, record);
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
        record.image = stored_state();
        read_contents();
        record.shown = shown_image();
        item_offset = cursor.offset;
      }
    }
    return item;
  }
}

void TraceReader::Impl::make_tail() {
  if (std::exchange(has_tail, true)) return;
  tail.ticks_intact = cursor.tick;
  tail.end = end;
  tail.peers = peers;
  if (cursor.has_pending) {
    tail.has_pending_inputs = true;
    tail.pending_inputs = cursor.pending_inputs;
  }
  if (cursor.has_pending || !cursor.pending_notes.empty()) tail.pending_dt = cursor.pending_dt;
  tail.pending_notes = cursor.pending_notes;
  const Fault& shown = first_damage ? *first_damage : *fault;
  tail.condition = shown.condition;
  tail.offset = shown.offset;
  tail.message = shown.condition == TraceCondition::complete ? "" : shown.message;
  if (fault->condition == TraceCondition::damaged && cursor.phase == Phase::body) tail.intact_after = find_intact();
}

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
std::uint64_t TraceReader::first_tick() const {
  return impl_->first_tick;
}
Status TraceReader::check_from_start() const {
  if (impl_->first_tick == 0) return {};
  return Error{ErrorCode::incompatible,
               impl_->name + ": begins at tick " + std::to_string(impl_->first_tick) + ": cannot be run from its setup",
               "verify begins at its first checkpoint; show and diff take it as well"};
}
std::uint64_t TraceReader::size() const {
  return impl_->file.size();
}
Status TraceReader::check_unchanged() const {
  return impl_->file.check_unchanged(impl_->name);
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
