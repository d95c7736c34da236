// Writes chunks and records without buffering: one system call each.
// SPDX-License-Identifier: MIT
#include "replay/trace_writer.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "base/assert.h"
#include "base/count_text.h"
#include "base/hash.h"
#include "base/limits.h"
#include "replay/file/file.h"
#include "replay/format/chunk.h"
#include "replay/format/payload.h"
#include "replay/format/peer.h"
#include "replay/format/table_list.h"

namespace ticktrue::replay {
namespace {

// A fast recording writes many checkpoints a second, and each sync takes milliseconds.
constexpr std::chrono::seconds sync_interval{1};

// Part of the limit for bound records of a chunk. It is reserved for the records that report left-out records: one for
// each tick.
constexpr std::size_t left_out_room = 128u << 10;
constexpr std::size_t record_frame_size_max = 8;  // tag, size, check
constexpr const char* left_out_topic = "ticktrue.left_out";

/// The caller must allow version 3 (WriterOptions::allow_third).
Error refuse_third(const TraceSetup& setup, const std::string& path) {
  if (setup.schema.tables.size() > limits::table_count_max)
    return {ErrorCode::limit,
            path + ": tables: found " + std::to_string(setup.schema.tables.size()) + ", expected at most " +
                std::to_string(limits::table_count_max) + ": a trace holds no more",
            "put rows of equal columns into one table, with a column that tells them apart"};
  return {ErrorCode::unsupported,
          path +
              ": setup: format version 3 is needed (features, stage_interval, a type above f64, child tables or "
              "shown columns), and this recording may use versions 1 and 2 alone",
          ""};
}

}  // namespace

struct TraceWriter::Impl {
  OutputFile file;
  WriterOptions options;
  // The parts of the setup that later calls need.
  TraceSetup setup;  // without the setup bytes of the simulation
  std::uint16_t version = format_version_first;
  std::optional<CellHasher> cell_hasher;  // with Detail::cells
  std::optional<CellLayout> cell_layout;  // with Detail::cells in version 3
  std::uint64_t setup_dt_bits = 0;

  std::uint64_t seed = 0;      // of header checks
  std::uint64_t chain = 0;     // after the last whole chunk
  std::uint32_t sequence = 0;  // of the next chunk
  std::uint64_t first_tick = 0;
  std::uint64_t tick_count = 0;
  double time_s = 0;  // simulated time of these ticks
  double tick_dt = 0;
  std::uint64_t size = 0;
  std::uint64_t unpacked_size = 0;  // total of all state images
  std::uint64_t facts_check = 0;
  CheckpointIndex index;
  std::uint64_t last_checkpoint = 0;  // tick of the last checkpoint; valid only if there is one
  std::chrono::steady_clock::time_point last_sync{};
  bool in_tick = false;
  std::optional<Error> failure;
  bool file_is_closed = false;

  // The open ticks chunk.
  bool is_open = false;
  Running running;
  std::uint64_t dt_bits = 0;
  std::uint32_t chunk_ticks = 0;
  std::size_t chunk_size = 0;    // without records outside the chain: they must not change where the next chunk begins
  std::size_t bound_size = 0;    // bytes of the records outside the chain
  std::size_t bound_in_out = 0;  // the part of `bound_size` in `out`
  std::map<std::string, std::uint32_t> mark_names;  // names of the chunk: name, id
  bool told_left_out = false;                       // the chunk has a record that notes were left out
  bool has_cells_before = false;                    // a tick of this chunk has cells
  StateCells cells_before;

  ByteWriter out;  // bytes that the current call writes
  Bytes image;
  StateCells cells;
  ByteWriter cells_out;

  // Version 3.
  LastState last;
  std::vector<std::uint32_t> changed;  // changed tables of the current state
  Bytes canonical;                     // rows of the state on a big-endian machine
  std::uint64_t held = 0;              // bytes of all tables of the last state, including its shown image and save

  explicit Impl(OutputFile opened) : file(std::move(opened)) {}

  Status flush() {
    const Status status = file.append(out.view());
    if (status) {
      size += out.size();
      if (is_open) chunk_size += out.size() - bound_in_out;
    } else {
      failure = status.error();
    }
    out.clear();
    bound_in_out = 0;
    return status;
  }

  ChunkHeader next_header(ChunkKind kind, std::size_t payload_size) {
    ChunkHeader header;
    header.kind = static_cast<std::uint8_t>(kind);
    header.sequence = sequence++;
    header.size = static_cast<std::uint32_t>(payload_size);
    header.tick = tick_count;
    header.chain = chain;
    return header;
  }

  /// Appends a chunk with its trailer to `out`; returns the trailer. Does not change the chain.
  std::uint64_t put_chunk(ChunkHeader header, ByteView payload) {
    header.check = encode_chunk_header(header, seed, out);
    out.bytes(payload);
    const std::uint64_t check = hash64(payload, header.check);
    out.u64(check);
    return check;
  }

  void open_chunk() {
    if (is_open) return;
    ChunkHeader header = next_header(ChunkKind::ticks, streamed_size);
    header.check = encode_chunk_header(header, seed, out);
    running = begin_running(header, version);
    is_open = true;
    dt_bits = setup_dt_bits;
    chunk_ticks = 0;
    chunk_size = bound_size = 0;
    mark_names.clear();
    told_left_out = false;
    has_cells_before = false;
  }

  /// Appends the close record of the open chunk to `out`.
  void close_chunk() {
    if (!is_open) return;
    if (version < format_version_third)
      append_close(chunk_ticks, running.chained, out);
    else
      append_close(chunk_ticks, running, out);
    chain = running.chained;
    is_open = false;
  }

  /// Whether a reader accepts the part even in the smallest possible file. `beside`: bytes in memory besides the image.
  bool may_compress(const ImagePart& part, std::uint64_t beside) const {
    return beside + part.offset + part.size <= limits::image_held_max(size) &&
           unpacked_size + part.size <= limits::images_unpacked_max(size);
  }

  Status write_image(ChunkKind kind, ByteView bytes, std::uint64_t root_hash) {
    ImagePart part;
    part.root_hash = root_hash;
    part.image_size = bytes.size();
    part.time_s = std::min(time_s, std::numeric_limits<double>::max());  // readers accept only a finite time
    // A reader of a list of changes also has the unchanged tables in memory.
    const std::uint64_t beside = held > bytes.size() ? held - bytes.size() : 0;
    do {
      part.size = static_cast<std::uint32_t>(std::min<std::size_t>(image_part_size, bytes.size()));
      const ByteView raw = bytes.first(part.size);
      bytes = bytes.subspan(part.size);
      ByteWriter payload;
      encode_image_part(part, raw, options.compress && may_compress(part, beside), payload, version);
      unpacked_size += part.size;
      const ChunkHeader header = next_header(kind, payload.size());
      put_chunk(header, payload.view());
      chain = extend_chain(header, payload.view().first(image_fields_size(version)), raw, version);
      if (const Status status = flush(); !status) return status;
      part.offset += part.size;
    } while (!bytes.empty());
    return {};
  }

  /// Writes a shown image or a save: these chunks are outside the chain.
  Status write_content(ChunkKind kind, ByteView bytes, std::size_t size_max) {
    TICKTRUE_ASSERT(!in_tick && !is_open && index.checkpoint_count > 0);
    if (failure) return *failure;
    if (bytes.size() > size_max)
      return Error{ErrorCode::limit,
                   file.path() + ": " + std::string(chunk_kind_info(static_cast<std::uint8_t>(kind))->name) +
                       ": bytes: found " + std::to_string(bytes.size()) + ", expected at most " +
                       std::to_string(size_max),
                   ""};
    ImagePart part;
    part.root_hash = content_hash(bytes);
    part.image_size = bytes.size();
    do {
      part.size = static_cast<std::uint32_t>(std::min<std::size_t>(image_part_size, bytes.size()));
      ByteWriter payload;
      encode_image_part(part, bytes.first(part.size), options.compress && may_compress(part, held), payload);
      bytes = bytes.subspan(part.size);
      unpacked_size += part.size;
      put_chunk(next_header(kind, payload.size()), payload.view());
      if (const Status status = flush(); !status) return status;
      part.offset += part.size;
    } while (!bytes.empty());
    held += part.image_size;
    return {};
  }

  /// The bytes of the state after `ticks_done` ticks: an image, or in version 3 a list of tables. Valid until the next
  /// call.
  ByteView encode_state(const StateView& state, ChunkKind kind, std::uint64_t ticks_done) {
    if (version >= format_version_third) return encode_tables(canonical_tables(state, canonical), kind, ticks_done);
    encode_image(state, image);
    return image;
  }
  Result<ByteView> encode_state(ByteView whole, ChunkKind kind, std::uint64_t ticks_done) {
    if (version < format_version_third) return whole;
    const Result<std::vector<ImageTable>> tables = split_image(setup.schema, whole);
    if (!tables) return tables.error();
    return encode_tables(*tables, kind, ticks_done);
  }
  ByteView encode_tables(std::span<const ImageTable> tables, ChunkKind kind, std::uint64_t ticks_done) {
    const bool is_whole = kind == ChunkKind::checkpoint || ticks_done == 0 || !last.holds(ticks_done - 1);
    last.find_changed(tables, is_whole, changed);
    encode_table_list(is_whole ? ListBase::nothing : ListBase::before, tables, changed, image);
    held = 0;
    for (const ImageTable& table : tables) held += row_count_size + table.rows.size();
    // Only the image of the next tick needs the last state.
    if (setup.is_full(ticks_done))
      last.keep(tables, changed, is_whole, ticks_done);
    else
      last.forget();
    return image;
  }

  Status sync(bool now) {
    if (!options.sync) return {};
    const auto time = std::chrono::steady_clock::now();
    if (!now && last_sync.time_since_epoch().count() != 0 && time - last_sync < sync_interval) return {};
    last_sync = time;
    const Status status = file.sync();
    if (!status) failure = status.error();
    return status;
  }

  Status check_image_size(std::uint64_t bytes) const {
    if (bytes <= limits::state_image_size_max) return {};
    return Error{ErrorCode::limit,
                 file.path() + ": state image: size: found " + std::to_string(bytes) + ", expected at most " +
                     std::to_string(limits::state_image_size_max),
                 ""};
  }

  Status write_checkpoint(ByteView bytes, std::uint64_t root_hash) {
    TICKTRUE_ASSERT(!in_tick);
    TICKTRUE_ASSERT(index.checkpoint_count == 0 ? tick_count == first_tick : tick_count > last_checkpoint);
    if (failure) return *failure;
    if (const Status status = check_image_size(std::max<std::uint64_t>(bytes.size(), held)); !status) return status;
    close_chunk();
    index.add({tick_count, size + out.size()});
    last_checkpoint = tick_count;
    if (const Status status = write_image(ChunkKind::checkpoint, bytes, root_hash); !status) return status;
    return sync(false);
  }

  void append_cells(const StateCells& of_state) {
    cells_out.clear();
    if (cell_layout) {
      encode_cell_list(*cell_layout, of_state, has_cells_before ? &cells_before : nullptr, cells_out);
      cells_before = of_state;
      has_cells_before = true;
    } else {
      encode_cells(of_state, setup.schema, cells_out);
    }
    append_record(RecordTag::cells, cells_out.view(), running.chained, out);
  }

  void put_bound(RecordTag tag, ByteView body) {
    const std::size_t start = out.size();
    append_record(tag, body, running.outside, out);
    bound_in_out += out.size() - start;
    bound_size += out.size() - start;
  }

  bool has_bound_room(std::size_t body_size) const {
    return bound_size + body_size + record_frame_size_max + left_out_room <= bound_size_max;
  }

  void put_left_out(const std::string& what) {
    if (!setup.has(Feature::notes)) return;
    ByteWriter body;
    encode_note({left_out_topic, what}, body);
    put_bound(RecordTag::note, body.view());
  }

  /// The ids of these names in the open chunk. A new name gets a record. Nothing: the names do not fit.
  std::optional<std::vector<std::uint32_t>> put_names(const std::vector<const std::string*>& names) {
    std::size_t new_size = 0;
    std::size_t count = mark_names.size();
    for (const std::string* name : names) {
      if (mark_names.count(*name) != 0) continue;
      new_size += name->size() + record_frame_size_max;
      ++count;
    }
    if (count > mark_name_count_max || !has_bound_room(new_size)) return std::nullopt;
    std::vector<std::uint32_t> ids;
    for (const std::string* name : names) {
      const auto [at, is_new] = mark_names.emplace(*name, static_cast<std::uint32_t>(mark_names.size()));
      if (is_new) put_bound(RecordTag::name, {reinterpret_cast<const std::uint8_t*>(name->data()), name->size()});
      ids.push_back(at->second);
    }
    return ids;
  }

  /// False: the marks exceed a limit, and at most names are written.
  bool put_marks(const TickMarks& marks) {
    if (marks.is_left_out()) return false;
    std::vector<const std::string*> names;
    for (const NameMarks& name : marks.names) names.push_back(&name.name);
    const auto ids = put_names(names);
    if (!ids) return false;
    ByteWriter body;
    encode_marks(marks, *ids, body);
    if (body.size() > marks_size_max || !has_bound_room(body.size())) return false;
    put_bound(RecordTag::marks, body.view());
    return true;
  }

  Status write_tick(std::uint64_t root_hash, std::span<const std::uint64_t> stage_hashes, std::optional<ByteView> bytes,
                    const StateCells* of_state) {
    TICKTRUE_ASSERT(in_tick);
    if (failure) return *failure;
    if (bytes)
      if (const Status status = check_image_size(std::max<std::uint64_t>(bytes->size(), held)); !status) return status;
    open_chunk();
    if (setup.has_stages(tick_count) && !stage_hashes.empty()) {
      TICKTRUE_ASSERT(stage_hashes.size() == setup.stages.size());
      ByteWriter body;
      for (const std::uint64_t hash : stage_hashes) body.u64(hash);
      append_record(RecordTag::stages, body.view(), running.chained, out);
    }
    if (setup.detail == Detail::cells && of_state != nullptr) append_cells(*of_state);
    const bool has_image = setup.is_full(tick_count) && bytes.has_value();
    ByteWriter body;
    body.u64(root_hash);
    append_record(has_image ? RecordTag::root_image : RecordTag::root, body.view(), running.chained, out);
    in_tick = false;
    ++tick_count;
    ++chunk_ticks;
    if (has_image || chunk_ticks == chunk_tick_count || chunk_size + out.size() - bound_in_out >= chunk_close_size)
      close_chunk();
    if (const Status status = flush(); !status) {
      --tick_count;  // the tick is not in the file
      return status;
    }
    time_s += tick_dt;
    return has_image ? write_image(ChunkKind::image, *bytes, root_hash) : Status();
  }
};

TraceWriter::TraceWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TraceWriter::TraceWriter(TraceWriter&&) noexcept = default;
TraceWriter& TraceWriter::operator=(TraceWriter&&) noexcept = default;
TraceWriter::~TraceWriter() = default;

Result<TraceWriter> TraceWriter::create(const std::string& path, const TraceSetup& setup, const BuildFacts& facts,
                                        const WriterOptions& options) {
  if (const Status status = check(setup, facts, path, options); !status) return status.error();
  Result<OutputFile> file = OutputFile::create(path, options.overwrite);
  if (!file) return file.error();
  return to(std::move(*file), setup, facts, options);
}

Status TraceWriter::check(const TraceSetup& setup, const BuildFacts& facts, const std::string& path,
                          const WriterOptions& options) {
  if (const Status status = check_setup(setup, path); !status) return status.error();
  if (const Status status = check_facts(facts, path); !status) return status.error();
  if (version_of(setup) == format_version_third && !options.allow_third) return refuse_third(setup, path);
  return {};
}

Result<TraceWriter> TraceWriter::to(OutputFile file, const TraceSetup& setup, const BuildFacts& facts,
                                    const WriterOptions& options) {
  if (const Status status = check(setup, facts, file.path(), options); !status) return status.error();
  const std::uint16_t version = version_of(setup);
  auto impl = std::make_unique<Impl>(std::move(file));
  impl->options = options;
  impl->options.compress = options.compress && has_codec(Codec::zstd);
  impl->version = version;
  impl->seed = impl->chain = chain_start(version);
  if (setup.detail == Detail::cells) impl->cell_hasher.emplace(setup.schema);
  if (setup.detail == Detail::cells && version == format_version_third) impl->cell_layout.emplace(setup.schema);
  impl->setup = setup;
  impl->setup.setup = {};
  impl->setup_dt_bits = bits_of(setup.dt);

  encode_file_header(impl->out, version);
  ByteWriter payload;
  encode_setup(setup, payload);
  const ChunkHeader setup_header = impl->next_header(ChunkKind::setup, payload.size());
  impl->put_chunk(setup_header, payload.view());
  impl->chain = extend_chain(setup_header, {}, payload.view(), version);
  impl->seed = impl->chain;

  payload.clear();
  encode_facts({impl->options.compress ? Codec::zstd : Codec::none, facts}, payload);
  impl->facts_check = impl->put_chunk(impl->next_header(ChunkKind::facts, payload.size()), payload.view());
  const Status status = impl->flush();
  TraceWriter writer(std::move(impl));
  if (!status) return writer.abandon(status.error());
  return writer;
}

Status TraceWriter::begin_tick(const TickInput& input) {
  Impl& impl = *impl_;
  TICKTRUE_ASSERT(!impl.in_tick && impl.index.checkpoint_count > 0);
  if (impl.failure) return *impl.failure;
  if (input.inputs.size() > input_size_max)
    return Error{ErrorCode::limit,
                 impl.file.path() + ": tick " + std::to_string(impl.tick_count) + ": bytes of inputs: found " +
                     std::to_string(input.inputs.size()) + ", expected at most " + std::to_string(input_size_max),
                 "spread the inputs over several ticks"};
  if (impl.tick_count >= limits::tick_count_max)
    return Error{ErrorCode::limit, impl.file.path() + ": tick count: reached " + std::to_string(impl.tick_count), ""};
  impl.in_tick = true;
  impl.tick_dt = input.dt;
  const std::uint64_t dt_bits = bits_of(input.dt);
  if (dt_bits == (impl.is_open ? impl.dt_bits : impl.setup_dt_bits) && input.inputs.empty()) return {};
  impl.open_chunk();
  if (dt_bits != impl.dt_bits) {
    ByteWriter body;
    body.u64(dt_bits);
    append_record(RecordTag::dt, body.view(), impl.running.chained, impl.out);
    impl.dt_bits = dt_bits;
  }
  if (!input.inputs.empty()) append_record(RecordTag::inputs, input.inputs, impl.running.chained, impl.out);
  return impl.flush();
}

Status TraceWriter::end_tick(std::uint64_t root_hash, std::span<const std::uint64_t> stage_hashes,
                             const StateView* state) {
  Impl& impl = *impl_;
  if (state == nullptr || !wants_state()) return impl.write_tick(root_hash, stage_hashes, std::nullopt, nullptr);
  if (impl.cell_hasher) {
    impl.cell_hasher->hash(*state, 0, impl.cells);
    return impl.write_tick(root_hash, stage_hashes, std::nullopt, &impl.cells);
  }
  return impl.write_tick(root_hash, stage_hashes, impl.encode_state(*state, ChunkKind::image, impl.tick_count + 1),
                         nullptr);
}

Status TraceWriter::end_tick_encoded(std::uint64_t root_hash, std::span<const std::uint64_t> stage_hashes,
                                     std::optional<ByteView> image, const StateCells* cells) {
  Impl& impl = *impl_;
  if (image && impl.setup.is_full(impl.tick_count)) {
    const Result<ByteView> encoded = impl.encode_state(*image, ChunkKind::image, impl.tick_count + 1);
    if (!encoded) return encoded.error();
    image = *encoded;
  }
  return impl.write_tick(root_hash, stage_hashes, image, cells);
}

void TraceWriter::begin_at(std::uint64_t tick, double time_s) {
  Impl& impl = *impl_;
  TICKTRUE_ASSERT(impl.setup.has(Feature::tail) && impl.index.checkpoint_count == 0);
  impl.first_tick = impl.tick_count = tick;
  impl.time_s = time_s;
}

Status TraceWriter::bound_record(RecordTag tag, ByteView body) {
  Impl& impl = *impl_;
  TICKTRUE_ASSERT(impl.in_tick && impl.version == format_version_third);
  if (impl.failure) return *impl.failure;
  impl.open_chunk();
  if (impl.bound_size + body.size() + record_frame_size_max > bound_size_max)
    return Error{ErrorCode::limit,
                 impl.file.path() + ": tick " + std::to_string(impl.tick_count) +
                     ": notes and marks: reached the limit of a chunk",
                 ""};
  impl.put_bound(tag, body);
  return impl.flush();
}

Status TraceWriter::marks(const TickMarks& marks) {
  Impl& impl = *impl_;
  TICKTRUE_ASSERT(impl.in_tick && impl.setup.has(Feature::marks));
  if (impl.failure) return *impl.failure;
  impl.open_chunk();
  if (!impl.put_marks(marks)) {
    ByteWriter body;
    encode_marks({}, {}, body);
    impl.put_bound(RecordTag::marks, body.view());
    if (!marks.is_left_out()) impl.put_left_out("marks of this tick, of " + count_text(marks.names.size(), "name"));
  }
  return impl.flush();
}

Status TraceWriter::mark_list(const MarkList& list) {
  Impl& impl = *impl_;
  TICKTRUE_ASSERT(impl.in_tick && impl.setup.has(Feature::marks) && impl.setup.is_full(impl.tick_count));
  if (impl.failure) return *impl.failure;
  impl.open_chunk();
  // The names that the list uses.
  std::vector<bool> is_used(list.names.size());
  for (const Mark& mark : list.marks) is_used[mark.name] = true;
  std::vector<const std::string*> used;
  for (std::size_t i = 0; i < is_used.size(); ++i)
    if (is_used[i]) used.push_back(&list.names[i]);
  const auto used_ids = impl.put_names(used);
  if (!used_ids) return impl.flush();
  std::vector<std::uint32_t> ids(list.names.size());
  for (std::size_t i = 0, at = 0; i < is_used.size(); ++i)
    if (is_used[i]) ids[i] = (*used_ids)[at++];
  ByteWriter body;
  encode_mark_list(list, ids, body);
  if (impl.has_bound_room(body.size()))
    impl.put_bound(RecordTag::mark_list, body.view());
  else
    impl.put_left_out("list of " + count_text(list.marks.size(), "mark") + " of this tick");
  return impl.flush();
}

Status TraceWriter::note(const Note& note) {
  Impl& impl = *impl_;
  TICKTRUE_ASSERT(impl.in_tick && impl.setup.has(Feature::notes));
  TICKTRUE_ASSERT(!note.topic.empty() && note.topic.size() <= topic_size_max && note.text.size() <= note_body_size_max);
  if (impl.failure) return *impl.failure;
  impl.open_chunk();
  ByteWriter body;
  encode_note(note, body);
  if (impl.has_bound_room(body.size())) {
    impl.put_bound(RecordTag::note, body.view());
  } else if (!std::exchange(impl.told_left_out, true)) {
    impl.put_left_out("notes from here on");
  }
  return impl.flush();
}

bool TraceWriter::wants_full() const {
  return impl_->setup.is_full(impl_->tick_count);
}

bool TraceWriter::wants_stages() const {
  return impl_->setup.has_stages(impl_->tick_count);
}

bool TraceWriter::wants_state() const {
  return impl_->cell_hasher.has_value() || wants_full();
}

bool TraceWriter::wants_checkpoint() const {
  if (impl_->index.checkpoint_count == 0) return true;
  const std::uint32_t interval = impl_->setup.checkpoint_interval;
  return interval != 0 && impl_->tick_count % interval == 0 && impl_->tick_count != impl_->last_checkpoint;
}

Status TraceWriter::checkpoint(const StateView& state, std::uint64_t root_hash) {
  return impl_->write_checkpoint(impl_->encode_state(state, ChunkKind::checkpoint, impl_->tick_count), root_hash);
}

Status TraceWriter::checkpoint_encoded(ByteView image, std::uint64_t root_hash) {
  const Result<ByteView> encoded = impl_->encode_state(image, ChunkKind::checkpoint, impl_->tick_count);
  if (!encoded) return encoded.error();
  return impl_->write_checkpoint(*encoded, root_hash);
}

Status TraceWriter::shown(ByteView bytes) {
  TICKTRUE_ASSERT(impl_->setup.has(Feature::shown));
  return impl_->write_content(ChunkKind::shown, bytes, limits::shown_size_max);
}

Status TraceWriter::save(ByteView bytes) {
  TICKTRUE_ASSERT(impl_->setup.has(Feature::saves) && impl_->tick_count == impl_->last_checkpoint);
  return impl_->write_content(ChunkKind::save, bytes, limits::save_size_max);
}

Status TraceWriter::peer(const PeerRecord& peer) {
  Impl& impl = *impl_;
  TICKTRUE_ASSERT(impl.setup.has(Feature::peers) && impl.index.checkpoint_count > 0);
  if (impl.failure) return *impl.failure;
  if (const Status status = check_peer(peer, impl.file.path()); !status) return status;
  ByteWriter payload;
  encode_peer(peer, payload);
  const std::size_t size_max = chunk_kind_info(static_cast<std::uint8_t>(ChunkKind::peer))->payload_size_max;
  if (payload.size() > size_max)
    return Error{ErrorCode::limit,
                 impl.file.path() + ": player " + std::to_string(peer.player) + ": bytes: found " +
                     std::to_string(payload.size()) + ", expected at most " + std::to_string(size_max),
                 ""};
  impl.close_chunk();
  impl.put_chunk(impl.next_header(ChunkKind::peer, payload.size()), payload.view());
  return impl.flush();
}

Status TraceWriter::finish(EndReason reason, const std::string& note) {
  Impl& impl = *impl_;
  if (impl.failure) return *impl.failure;
  impl.close_chunk();
  ByteWriter payload;
  encode_end({reason, impl.tick_count, note}, payload);
  const ChunkHeader end_header = impl.next_header(ChunkKind::end, payload.size());
  impl.put_chunk(end_header, payload.view());
  impl.chain = extend_chain(end_header, {}, payload.view(), impl.version);

  Footer footer;
  footer.index_offset = impl.size + impl.out.size();
  footer.facts_check = impl.facts_check;
  payload.clear();
  encode_index(impl.index, payload);
  footer.index_check = impl.put_chunk(impl.next_header(ChunkKind::index, payload.size()), payload.view());
  payload.clear();
  encode_footer(footer, payload);
  impl.put_chunk(impl.next_header(ChunkKind::footer, payload.size()), payload.view());
  if (const Status status = impl.flush(); !status) return status;
  if (const Status status = impl.sync(true); !status) return status;
  impl.file_is_closed = true;
  const Status status = impl.file.commit();
  if (!status) impl.failure = status.error();
  return status;
}

void TraceWriter::discard() {
  impl_->file.discard();
}

Error TraceWriter::abandon(Error error) {
  OutputFile& file = impl_->file;
  if (impl_->file_is_closed || !file.check_in_place()) return error;  // another program may own the file by now
  const auto add = [&](const std::string& text) { error.hint += (error.hint.empty() ? "" : "; ") + text; };
  if (impl_->tick_count == impl_->first_tick) {
    const bool had_old = !file.old_path().empty();
    discard();
    add(had_old ? "no tick was recorded: the file from before is back"
                : "no tick was recorded: no file was left behind");
    return error;
  }
  add(std::to_string(impl_->tick_count - impl_->first_tick) + " ticks are whole in it: `ticktrue recover` saves them");
  if (!file.old_path().empty()) add("the file from before is " + file.old_path());
  return error;
}

bool TraceWriter::has_checkpoint() const {
  return impl_->index.checkpoint_count > 0;
}

std::uint64_t TraceWriter::tick_count() const {
  return impl_->tick_count;
}
std::uint64_t TraceWriter::size() const {
  return impl_->size;
}

}  // namespace ticktrue::replay
