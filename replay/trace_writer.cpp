// Writes chunks and records, each with one call of the operating system, unbuffered.
// SPDX-License-Identifier: MIT
#include "replay/trace_writer.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "base/assert.h"
#include "base/hash.h"
#include "base/limits.h"
#include "replay/file/file.h"
#include "replay/format/chunk.h"
#include "replay/format/payload.h"

namespace ticktrue::replay {
namespace {

// A fast recording passes many checkpoints a second, and each sync costs milliseconds.
constexpr std::chrono::seconds sync_interval{1};

}  // namespace

struct TraceWriter::Impl {
  OutputFile file;
  WriterOptions options;
  // Of the setup: what later calls need.
  Detail detail = Detail::root;
  std::optional<CellHasher> cell_hasher;  // with Detail::cells
  StateSchema schema;                     // with Detail::cells
  std::uint64_t full_first = 0;
  std::uint64_t full_last = 0;
  std::uint32_t checkpoint_interval = 0;
  std::size_t stage_count = 0;
  std::uint64_t setup_dt_bits = 0;

  std::uint64_t seed = 0;      // of header checks
  std::uint64_t chain = 0;     // after the last whole chunk
  std::uint32_t sequence = 0;  // of the next chunk
  std::uint64_t tick_count = 0;
  std::uint64_t size = 0;
  std::uint64_t unpacked_size = 0;  // of all state images
  std::uint64_t facts_check = 0;
  CheckpointIndex index;
  std::uint64_t last_checkpoint = 0;  // tick; counts only if there is one
  std::chrono::steady_clock::time_point last_sync{};
  bool in_tick = false;
  std::optional<Error> failure;
  bool file_is_closed = false;

  // The open ticks chunk.
  bool is_open = false;
  std::uint64_t running = 0;
  std::uint64_t dt_bits = 0;
  std::uint32_t chunk_ticks = 0;
  std::size_t chunk_size = 0;

  ByteWriter out;  // what the current call hands over
  Bytes image;
  StateCells cells;
  ByteWriter cells_out;

  explicit Impl(OutputFile opened) : file(std::move(opened)) {}

  Status flush() {
    const Status status = file.append(out.view());
    if (status) {
      size += out.size();
      if (is_open) chunk_size += out.size();
    } else {
      failure = status.error();
    }
    out.clear();
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
    running = encode_chunk_header(next_header(ChunkKind::ticks, streamed_size), seed, out);
    is_open = true;
    dt_bits = setup_dt_bits;
    chunk_ticks = 0;
    chunk_size = 0;
  }

  /// Appends the closing record of the open chunk to `out`.
  void close_chunk() {
    if (!is_open) return;
    append_close(chunk_ticks, running, out);
    chain = running;
    is_open = false;
  }

  /// Whether a reader accepts the part even in the smallest possible file.
  bool may_compress(const ImagePart& part) const {
    return part.offset + part.size <= limits::image_held_max(size) &&
           unpacked_size + part.size <= limits::images_unpacked_max(size);
  }

  Status write_image(ChunkKind kind, ByteView bytes, std::uint64_t root_hash) {
    ImagePart part;
    part.root_hash = root_hash;
    part.image_size = bytes.size();
    do {
      part.size = static_cast<std::uint32_t>(std::min<std::size_t>(image_part_size, bytes.size()));
      const ByteView raw = bytes.first(part.size);
      bytes = bytes.subspan(part.size);
      ByteWriter payload;
      encode_image_part(part, raw, options.compress && may_compress(part), payload);
      unpacked_size += part.size;
      const ChunkHeader header = next_header(kind, payload.size());
      put_chunk(header, payload.view());
      chain = extend_chain(header, payload.view().first(image_part_fields_size), raw);
      if (const Status status = flush(); !status) return status;
      part.offset += part.size;
    } while (!bytes.empty());
    return {};
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

  Status check_image_size(std::size_t bytes) const {
    if (bytes <= limits::state_image_size_max) return {};
    return Error{ErrorCode::limit,
                 file.path() + ": state image: size: found " + std::to_string(bytes) + ", expected at most " +
                     std::to_string(limits::state_image_size_max),
                 ""};
  }

  bool wants_full() const { return detail == Detail::full && full_first <= tick_count && tick_count <= full_last; }

  Status write_checkpoint(ByteView bytes, std::uint64_t root_hash) {
    TICKTRUE_ASSERT(!in_tick);
    TICKTRUE_ASSERT(index.checkpoint_count == 0 ? tick_count == 0 : tick_count > last_checkpoint);
    if (failure) return *failure;
    if (const Status status = check_image_size(bytes.size()); !status) return status;
    close_chunk();
    index.add({tick_count, size + out.size()});
    last_checkpoint = tick_count;
    if (const Status status = write_image(ChunkKind::checkpoint, bytes, root_hash); !status) return status;
    return sync(false);
  }

  Status write_tick(std::uint64_t root_hash, std::span<const std::uint64_t> stage_hashes, std::optional<ByteView> bytes,
                    ByteView cells_body) {
    TICKTRUE_ASSERT(in_tick);
    if (failure) return *failure;
    if (bytes)
      if (const Status status = check_image_size(bytes->size()); !status) return status;
    open_chunk();
    const bool is_full = wants_full();
    if (is_full && !stage_hashes.empty()) {
      TICKTRUE_ASSERT(stage_hashes.size() == stage_count);
      ByteWriter body;
      for (const std::uint64_t hash : stage_hashes) body.u64(hash);
      append_record(RecordTag::stages, body.view(), running, out);
    }
    if (detail == Detail::cells && !cells_body.empty()) append_record(RecordTag::cells, cells_body, running, out);
    const bool has_image = is_full && bytes.has_value();
    ByteWriter body;
    body.u64(root_hash);
    append_record(has_image ? RecordTag::root_image : RecordTag::root, body.view(), running, out);
    in_tick = false;
    ++tick_count;
    ++chunk_ticks;
    if (has_image || chunk_ticks == chunk_tick_count || chunk_size + out.size() >= chunk_close_size) close_chunk();
    if (const Status status = flush(); !status) {
      --tick_count;  // it is not in the file
      return status;
    }
    return has_image ? write_image(ChunkKind::image, *bytes, root_hash) : Status();
  }
};

TraceWriter::TraceWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TraceWriter::TraceWriter(TraceWriter&&) noexcept = default;
TraceWriter& TraceWriter::operator=(TraceWriter&&) noexcept = default;
TraceWriter::~TraceWriter() = default;

Result<TraceWriter> TraceWriter::create(const std::string& path, const TraceSetup& setup, const BuildFacts& facts,
                                        const WriterOptions& options) {
  if (const Status status = check_setup(setup, path); !status) return status.error();
  if (const Status status = check_facts(facts, path); !status) return status.error();
  Result<OutputFile> file = OutputFile::create(path, options.overwrite);
  if (!file) return file.error();
  auto impl = std::make_unique<Impl>(std::move(*file));
  impl->options = options;
  impl->options.compress = options.compress && has_codec(Codec::zstd);
  impl->detail = setup.detail;
  const std::uint16_t version = detail_info(setup.detail).format_version;
  impl->seed = impl->chain = chain_start(version);
  if (setup.detail == Detail::cells) {
    impl->schema = setup.schema;
    impl->cell_hasher.emplace(setup.schema);
  }
  impl->full_first = setup.full_first;
  impl->full_last = setup.full_last;
  impl->checkpoint_interval = setup.checkpoint_interval;
  impl->stage_count = setup.stages.size();
  impl->setup_dt_bits = bits_of(setup.dt);

  encode_file_header(impl->out, version);
  ByteWriter payload;
  encode_setup(setup, payload);
  const ChunkHeader setup_header = impl->next_header(ChunkKind::setup, payload.size());
  impl->put_chunk(setup_header, payload.view());
  impl->chain = extend_chain(setup_header, {}, payload.view());
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
  const std::uint64_t dt_bits = bits_of(input.dt);
  if (dt_bits == (impl.is_open ? impl.dt_bits : impl.setup_dt_bits) && input.inputs.empty()) return {};
  impl.open_chunk();
  if (dt_bits != impl.dt_bits) {
    ByteWriter body;
    body.u64(dt_bits);
    append_record(RecordTag::dt, body.view(), impl.running, impl.out);
    impl.dt_bits = dt_bits;
  }
  if (!input.inputs.empty()) append_record(RecordTag::inputs, input.inputs, impl.running, impl.out);
  return impl.flush();
}

Status TraceWriter::end_tick(std::uint64_t root_hash, std::span<const std::uint64_t> stage_hashes,
                             const StateView* state) {
  Impl& impl = *impl_;
  if (state == nullptr || !wants_state()) return impl.write_tick(root_hash, stage_hashes, std::nullopt, {});
  if (impl.cell_hasher) {
    impl.cell_hasher->hash(*state, 0, impl.cells);
    impl.cells_out.clear();
    encode_cells(impl.cells, impl.schema, impl.cells_out);
    return impl.write_tick(root_hash, stage_hashes, std::nullopt, impl.cells_out.view());
  }
  encode_image(*state, impl.image);
  return impl.write_tick(root_hash, stage_hashes, ByteView(impl.image), {});
}

Status TraceWriter::end_tick_encoded(std::uint64_t root_hash, std::span<const std::uint64_t> stage_hashes,
                                     std::optional<ByteView> image, ByteView cells) {
  return impl_->write_tick(root_hash, stage_hashes, image, cells);
}

bool TraceWriter::wants_full() const {
  return impl_->wants_full();
}

bool TraceWriter::wants_state() const {
  return impl_->cell_hasher.has_value() || impl_->wants_full();
}

bool TraceWriter::wants_checkpoint() const {
  if (impl_->index.checkpoint_count == 0) return true;
  return impl_->checkpoint_interval != 0 && impl_->tick_count % impl_->checkpoint_interval == 0 &&
         impl_->tick_count != impl_->last_checkpoint;
}

Status TraceWriter::checkpoint(const StateView& state, std::uint64_t root_hash) {
  encode_image(state, impl_->image);
  return impl_->write_checkpoint(impl_->image, root_hash);
}

Status TraceWriter::checkpoint_encoded(ByteView image, std::uint64_t root_hash) {
  return impl_->write_checkpoint(image, root_hash);
}

Status TraceWriter::finish(EndReason reason, const std::string& note) {
  Impl& impl = *impl_;
  if (impl.failure) return *impl.failure;
  impl.close_chunk();
  ByteWriter payload;
  encode_end({reason, impl.tick_count, note}, payload);
  const ChunkHeader end_header = impl.next_header(ChunkKind::end, payload.size());
  impl.put_chunk(end_header, payload.view());
  impl.chain = extend_chain(end_header, {}, payload.view());

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
  if (impl_->file_is_closed || !file.check_in_place()) return error;  // it may be another program's by now
  const auto add = [&](const std::string& text) { error.hint += (error.hint.empty() ? "" : "; ") + text; };
  if (impl_->tick_count == 0) {
    const bool had_old = !file.old_path().empty();
    discard();
    add(had_old ? "no tick was recorded: the file from before is back"
                : "no tick was recorded: no file was left behind");
    return error;
  }
  add(std::to_string(impl_->tick_count) + " ticks are whole in it: `ticktrue recover` saves them");
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
