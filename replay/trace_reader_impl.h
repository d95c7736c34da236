// The implementation of TraceReader, shared by its source files: reads chunks, returns records, scans the file.
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

/// The next part of the file.
enum class Phase : std::uint8_t { body, index, footer, closed };

/// The result of reading one chunk.
enum class Step : std::uint8_t { passed, ticks, checkpoint, image, stop };

struct Fault {
  TraceCondition condition = TraceCondition::damaged;
  std::uint64_t offset = 0;
  std::string message;
};

/// Tracks the row counts of an image that arrives in parts. A wrong count is found before later parts are read.
struct ImageShape {
  std::size_t table = 0;     // the row count of this table is at `offset`
  std::uint64_t offset = 0;  // after the last table: the size of the image

  /// Reads the row counts in `image`, the bytes of the image so far. Errors: corrupt.
  Status pass(const StateSchema& schema, ByteView image, std::uint64_t image_size);
};

/// The complete read position. A trial copies it first and restores it afterwards.
struct Cursor {
  std::uint64_t offset = 0;  // of the next chunk
  std::uint32_t sequence = 0;
  std::uint64_t chain = 0;
  std::uint64_t tick = 0;  // ticks done before the next chunk
  Phase phase = Phase::body;
  bool has_checkpoint = false;
  std::uint64_t last_checkpoint = 0;

  // A state image with unread parts.
  std::uint8_t part_kind = 0;         // 0: none
  ImagePart part;                     // the last part; `stored` is not used
  ImageShape shape;                   // of the part that was read
  TableListShape list;                // the same for version 3
  ListBase base = ListBase::nothing;  // of the list
  bool state_is_known = true;         // false: reading began in the middle, and lists of changes cannot be composed

  // Shown image and save of the last state.
  std::uint8_t state_kind = 0;    // the chunk kind of this state: checkpoint or image; 0: another chunk followed
  std::uint8_t content_kind = 0;  // the content with unread parts; 0: none
  ImagePart content_part;         // the last part
  bool has_shown = false;         // the whole shown image was read
  bool has_save = false;
  bool has_gap = false;  // a chunk outside the chain is damaged or missing
  std::size_t peer_count = 0;

  bool expects_image = false;  // the last tick announced its image
  bool has_pending = false;    // the last ticks chunk ends with the inputs of a tick without hash
  double pending_dt = 0;
  Bytes pending_inputs;
  std::vector<Note> pending_notes;  // after the last tick
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
  std::uint64_t seed = 0;            // of header checks, after the setup
  Cursor start;                      // after setup and build facts
  std::optional<Fault> start_fault;  // why nothing after the setup can be read
  std::optional<Fault> facts_fault;  // damaged build facts, which do not keep ticks from being read

  Cursor cursor;
  Cursor image_start;                 // the start of the last state image
  std::optional<Fault> fault;         // why reading stopped
  std::optional<Fault> first_damage;  // damage after which reading continued
  bool is_sequential = true;          // reading began at the start, so that the index can be compared
  bool is_searching = false;          // for intact ranges after damage
  CheckpointIndex seen;
  std::vector<PeerRecord> peers;
  std::optional<EndRecord> end;
  std::uint64_t index_offset = 0;
  std::optional<std::uint64_t> index_check;

  // Window on the file.
  Bytes window;
  std::uint64_t window_offset = 0;
  std::uint64_t window_reads = 0;  // number of reads into the window

  // Records of the current ticks chunk.
  Bytes records;
  std::size_t walk_offset = 0;
  std::size_t walk_end = 0;  // after the last root record
  std::uint64_t walk_tick = 0;
  double walk_dt = 0;
  std::uint64_t walk_file_offset = 0;     // of records[0]
  bool walk_has_bound = true;             // false: damaged, and not returned
  std::vector<std::string> walk_names;    // names of marks in the chunk so far
  StateCells cells;                       // versions 1 and 2
  std::optional<CellLayout> cell_layout;  // this and the following fields: version 3; set if the trace has cells
  ComposedCells walk_cells;
  ComposedCells checked_cells;

  Bytes image;
  std::vector<ImageTable> tables;         // of `image`, versions 1 and 2
  std::vector<std::uint32_t> all_tables;  // the numbers of all tables
  ComposedState composed;                 // version 3
  Bytes joined;                           // the composed tables as one image
  Bytes shown_bytes;
  Bytes save_bytes;
  std::uint64_t unpacked_size = 0;  // total of all images since the last rewind
  Item item;
  std::uint64_t item_offset = 0;
  TraceTail tail;
  bool has_tail = false;

  explicit Impl(InputFile opened, std::string called) : file(std::move(opened)), name(std::move(called)) {}

  /// At most `size` bytes from `offset`; fewer bytes: the file ends. Valid until the next call.
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

  /// The header at the cursor. Stops if the header is incomplete, wrong or out of order.
  std::optional<ChunkHeader> read_header(std::uint64_t header_seed);

  /// The payload of a chunk with a known size. Stops if the payload is incomplete or wrong.
  std::optional<ByteView> read_payload(const ChunkHeader& header, std::size_t size_max);

  void pass(const ChunkHeader& header);

  // ---- Setup and build facts ----

  Status read_start();
  /// Prepares the buffers in which states and cells are composed.
  void begin_states();
  /// Reads the tick of the first checkpoint of a trace that begins late.
  void find_first_tick();
  /// The fault that stopped reading the setup, as an error of open().
  Error start_error() const;
  void read_facts();
  /// Moves `offset` to the next valid header at or after it.
  std::optional<ChunkHeader> find_header(std::uint64_t& offset);

  // ---- Chunks ----

  Step read_chunk();
  /// Null: a chunk of this kind is allowed here. Otherwise the name of the expected kind.
  const char* wanted_kind(const ChunkHeader& header) const;
  Step read_private(const ChunkHeader& header);
  Step read_image_part(const ChunkHeader& header);
  /// Checks the part of a state image that was read so far.
  Status check_shape(const ImagePart& part);
  /// Stores a complete image.
  Status take_image(std::uint64_t image_end);
  /// Reads a part of a shown image or a save.
  Step read_content_part(const ChunkHeader& header);
  Step read_peer(const ChunkHeader& header);
  /// Continues after a chunk outside the chain with a damaged payload.
  Step lose(const ChunkHeader& header);
  /// After damage to a header: returns the next header, if only chunks outside the chain are missing before it.
  std::optional<ChunkHeader> find_behind_lost();
  /// Reads the shown image and the save after a state.
  void read_contents();
  std::optional<ByteView> shown_image() const {
    return cursor.has_shown ? std::optional<ByteView>(shown_bytes) : std::nullopt;
  }
  StoredState stored_state();
  /// Whether the part is within the limits for a file that ends after the part, at `part_end`.
  Status check_image_limits(const ImagePart& part, std::uint64_t part_end) const;
  /// Verifies a ticks chunk record by record and stores its records for walk(). At the end of a truncated file, the
  /// complete records are stored.
  Step read_ticks(const ChunkHeader& header);
  std::string check_record(const Record& record, std::size_t offset, TicksScan& scan);
  static void end_scanned_tick(std::size_t tick_end, TicksScan& scan);
  std::string check_close(const Record& record, const TicksScan& scan) const;
  /// Whether records that were read again still have the checks in `running`: another process may write to the file.
  /// `size`: bytes with the header.
  bool is_as_read(ByteView bytes, std::size_t size, const ChunkHeader& header, const Running& running) const;
  Step changed(const ChunkHeader& header) {
    return damaged(cursor.offset, chunk_text(header.kind) + ": the file changed while it was read");
  }
  std::string fault_text(const Record& record) const;
  void set_ticks(ByteView bytes, std::size_t ticks_end, std::uint64_t tick, bool has_bound);
  void set_pending(double dt, ByteView inputs);
  /// Stores the notes after the last root record of a ticks chunk. `dt`: of their tick.
  void set_pending_notes(double dt, ByteView bytes);
  Step read_end(const ChunkHeader& header);
  Step read_index(const ChunkHeader& header);
  Step read_footer(const ChunkHeader& header);
  void note_damage(Fault damage) {
    if (!first_damage) first_damage = std::move(damage);
  }

  // ---- Returning items ----

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

  /// Header and payload of footer and index; nothing: one of them is damaged.
  std::optional<ChunkHeader> footer_header(Footer& footer);
  std::optional<CheckpointIndex> read_index_directly();
  bool seek(std::uint64_t tick);
  std::optional<std::uint64_t> tick_count_hint();
};

}  // namespace ticktrue::replay
