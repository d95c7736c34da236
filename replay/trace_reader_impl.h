// The implementation of TraceReader, shared by its source files: reads chunks, returns records, scans.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "replay/file/file.h"
#include "replay/format/chunk.h"
#include "replay/format/payload.h"
#include "replay/format/table_list.h"
#include "replay/trace_reader.h"

namespace ticktrue::replay {

inline constexpr std::size_t read_ahead_size = 512u << 10;

/// What comes next in the file.
enum class Phase : std::uint8_t { body, index, footer, closed };

/// What reading one chunk gave.
enum class Step : std::uint8_t { passed, ticks, checkpoint, image, stop };

struct Fault {
  TraceCondition condition = TraceCondition::damaged;
  std::uint64_t offset = 0;
  std::string message;
};

/// Tracks the row counts of an image that is read in parts: a wrong count is found before the rest is read.
struct ImageShape {
  std::size_t table = 0;     // whose row count stands at `offset`
  std::uint64_t offset = 0;  // behind the last table: the size of the image

  /// Reads the row counts that stand in `image`, the bytes of the image so far. Errors: corrupt.
  Status pass(const StateSchema& schema, ByteView image, std::uint64_t image_size);
};

/// The complete read position: copied before a trial and restored afterwards.
struct Cursor {
  std::uint64_t offset = 0;  // of the next chunk
  std::uint32_t sequence = 0;
  std::uint64_t chain = 0;
  std::uint64_t tick = 0;  // ticks done before the next chunk
  Phase phase = Phase::body;
  bool has_checkpoint = false;
  std::uint64_t last_checkpoint = 0;

  // A state image whose parts are being read.
  std::uint8_t part_kind = 0;         // 0: none
  ImagePart part;                     // the part before; `stored` is not used
  ImageShape shape;                   // of the image, as far as it was read
  TableListShape list;                // the same, version 3
  ListBase base = ListBase::nothing;  // of the list
  bool state_is_known = true;         // false: read from the middle, so that lists of changes cannot be composed

  // Shown image and save of the state before.
  std::uint8_t state_kind = 0;    // of that state: checkpoint or image; 0: another chunk came since
  std::uint8_t content_kind = 0;  // whose parts are being read; 0: none
  ImagePart content_part;         // the part before
  bool has_shown = false;         // seen, whole
  bool has_save = false;
  bool has_gap = false;  // a chunk outside of the chain is damaged or missing
  std::size_t peer_count = 0;

  bool expects_image = false;  // the last tick said that its image follows
  bool has_pending = false;    // inputs of a tick without hash stand at the end of the last ticks chunk
  double pending_dt = 0;
  Bytes pending_inputs;
  std::vector<Note> pending_notes;  // behind the last tick
};

struct TicksScan;

struct TraceReader::Impl {
  InputFile file;
  std::string name;
  std::uint16_t version = format_version_first;
  TraceSetup setup;
  std::uint64_t first_tick = 0;  // of the first checkpoint
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
  bool is_searching = false;          // for intact ranges behind damage
  CheckpointIndex seen;
  std::vector<PeerRecord> peers;
  std::optional<EndRecord> end;
  std::uint64_t index_offset = 0;
  std::optional<std::uint64_t> index_check;

  // Window on the file.
  Bytes window;
  std::uint64_t window_offset = 0;
  std::uint64_t window_reads = 0;  // how often it was filled

  // Records of the current ticks chunk.
  Bytes records;
  std::size_t walk_offset = 0;
  std::size_t walk_end = 0;  // behind the last root record
  std::uint64_t walk_tick = 0;
  double walk_dt = 0;
  std::uint64_t walk_file_offset = 0;     // of records[0]
  bool walk_has_bound = true;             // false: damaged, and not given out
  std::vector<std::string> walk_names;    // of marks, of the chunk so far
  StateCells cells;                       // versions 1 and 2
  std::optional<CellLayout> cell_layout;  // from here on version 3, where the trace has cells
  ComposedCells walk_cells;
  ComposedCells checked_cells;

  Bytes image;
  std::vector<ImageTable> tables;         // of `image`, versions 1 and 2
  std::vector<std::uint32_t> all_tables;  // their numbers
  ComposedState composed;                 // version 3
  Bytes joined;                           // its tables as one image
  Bytes shown_bytes;
  Bytes save_bytes;
  std::uint64_t unpacked_size = 0;  // of images, since the last rewind
  Item item;
  std::uint64_t item_offset = 0;
  TraceTail tail;
  bool has_tail = false;

  explicit Impl(InputFile opened, std::string called) : file(std::move(opened)), name(std::move(called)) {}

  /// At most `size` bytes from `offset`; fewer where the file ends. Valid until the next call.
  ByteView view(std::uint64_t offset, std::size_t size);

  std::uint64_t remaining() const { return file.size() - cursor.offset; }
  static std::uint64_t whole_size(const ChunkHeader& header) {
    return std::uint64_t{chunk_header_size} + header.size + chunk_trailer_size;
  }

  std::string chunk_text(std::uint8_t kind) const;

  Step stop(TraceCondition condition, std::uint64_t offset, const std::string& what);
  Step damaged(std::uint64_t offset, const std::string& what) { return stop(TraceCondition::damaged, offset, what); }
  Step truncated(const std::string& what) { return stop(TraceCondition::truncated, file.size(), what); }

  ChunkHeader expected_header() const;

  /// The header at the cursor, if it is whole, right and the one that must come; else stops.
  std::optional<ChunkHeader> read_header(std::uint64_t header_seed);

  /// The payload of a chunk with stated size, if all of it is there and right; else stops.
  std::optional<ByteView> read_payload(const ChunkHeader& header, std::size_t size_max);

  void pass(const ChunkHeader& header);

  // ---- Setup and build facts ----

  Status read_start();
  /// Prepares what states and cells are composed in.
  void begin_states();
  /// Reads the tick of the first checkpoint of a trace that begins late.
  void find_first_tick();
  /// The stop while reading the setup, as an error of open().
  Error start_error() const;
  void read_facts();
  /// Moves `offset` to the next valid header at or behind it.
  std::optional<ChunkHeader> find_header(std::uint64_t& offset);

  // ---- Chunks ----

  Step read_chunk();
  /// Null if a chunk of this kind may come here, else what may.
  const char* wanted_kind(const ChunkHeader& header) const;
  Step read_private(const ChunkHeader& header);
  Step read_image_part(const ChunkHeader& header);
  /// Checks what was read of a state image so far.
  Status check_shape(const ImagePart& part);
  /// Takes over an image that was read whole.
  Status take_image(std::uint64_t image_end);
  /// A part of a shown image or of a save.
  Step read_content_part(const ChunkHeader& header);
  Step read_peer(const ChunkHeader& header);
  /// Goes on behind a chunk outside of the chain whose payload is damaged.
  Step lose(const ChunkHeader& header);
  /// After damage to a header: the next one, if all that is missing before it is outside of the chain.
  std::optional<ChunkHeader> find_behind_lost();
  /// Reads the shown image and the save that stand behind a state.
  void read_contents();
  std::optional<ByteView> shown_image() const {
    return cursor.has_shown ? std::optional<ByteView>(shown_bytes) : std::nullopt;
  }
  StoredState stored_state();
  /// Whether the part, which ends at `end` in the file, is within the limits for a file of that size.
  Status check_image_limits(const ImagePart& part, std::uint64_t part_end) const;
  /// Verifies a ticks chunk record by record and stores its records for walk(). At the end of a truncated file the
  /// complete records are stored.
  Step read_ticks(const ChunkHeader& header);
  std::string check_record(const Record& record, std::size_t offset, TicksScan& scan);
  static void end_scanned_tick(std::size_t tick_end, TicksScan& scan);
  std::string check_close(const Record& record, const TicksScan& scan) const;
  /// Whether records that were read again, `size` bytes with the header, are still those whose checks gave `running`:
  /// others may write to the file.
  bool is_as_read(ByteView bytes, std::size_t size, const ChunkHeader& header, const Running& running) const;
  Step changed(const ChunkHeader& header) {
    return damaged(cursor.offset, chunk_text(header.kind) + ": the file changed while it was read");
  }
  std::string fault_text(const Record& record) const;
  void set_ticks(ByteView bytes, std::size_t ticks_end, std::uint64_t tick, bool has_bound);
  void set_pending(double dt, ByteView inputs);
  /// Takes over the notes among the records behind the last root record of a ticks chunk. `dt`: of that tick.
  void set_pending_notes(double dt, ByteView bytes);
  Step read_end(const ChunkHeader& header);
  Step read_index(const ChunkHeader& header);
  Step read_footer(const ChunkHeader& header);
  void note_damage(Fault damage) {
    if (!first_damage) first_damage = std::move(damage);
  }

  // ---- Giving out ----

  void rewind();
  const Item& next();
  /// Returns the next tick of the verified chunk in `records`.
  const Item& walk();
  const StateCells* read_cells(ByteView body);
  void read_bound(const Record& part, TickRecord& record);
  void make_tail();
  /// Finds the intact ranges after the damage at the cursor.
  std::vector<IntactRange> find_intact();
  /// Sets the cursor to a header with a valid check, independent of earlier chunks.
  void resume_at(std::uint64_t offset, const ChunkHeader& header);

  // ---- Seeking ----

  /// Header and payload of the footer and the index, if both are right.
  std::optional<ChunkHeader> footer_header(Footer& footer);
  std::optional<CheckpointIndex> read_index_directly();
  bool seek(std::uint64_t tick);
  std::optional<std::uint64_t> tick_count_hint();
};

}  // namespace ticktrue::replay
