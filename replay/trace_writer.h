// Writes a trace while the simulation runs. The file is append-only and readable at any time.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "base/result.h"
#include "base/state/simulation.h"
#include "replay/file/file.h"
#include "replay/format/chunk.h"
#include "replay/format/trace.h"

namespace ticktrue::replay {

struct WriterOptions {
  bool overwrite = false;    // replace an existing file; false: an existing file is an error
  bool compress = true;      // compress checkpoints and images, if the build has zstd
  bool sync = true;          // fsync at checkpoints (at most once a second) and at the end, against power loss
  bool allow_third = false;  // allow format version 3 if the setup needs it; false: such a setup is refused
};

/// Order of calls: create, checkpoint (tick 0), then begin_tick and end_tick for each tick, checkpoint in between if
/// due, finish. Every error is final; the earlier bytes stay readable.
class TraceWriter {
 public:
  /// Creates the file and writes setup and build facts. With options.overwrite, an existing file is renamed to
  /// `<path>.old` until finish or discard.
  /// Errors: io (exists, unwritable), limit.
  static Result<TraceWriter> create(const std::string& path, const TraceSetup& setup, const BuildFacts& facts,
                                    const WriterOptions& options = {});
  /// The same with an existing output.
  static Result<TraceWriter> to(OutputFile file, const TraceSetup& setup, const BuildFacts& facts,
                                const WriterOptions& options);
  TraceWriter(TraceWriter&&) noexcept;
  TraceWriter& operator=(TraceWriter&&) noexcept;
  ~TraceWriter();  // leaves the file: truncated, unless finished

  /// Makes the trace begin at this tick. Requires: Feature::tail, no checkpoint yet.
  void begin_at(std::uint64_t tick, double time_s);

  /// Writes dt (if it changed) and inputs (if any) to the file. To be called before the tick runs.
  Status begin_tick(const TickInput& input);

  /// Writes a record outside the chain. Requires: a begun tick, the feature of the record.
  /// Errors: limit (too many such records in the chunk; nothing is written).
  Status bound_record(RecordTag tag, ByteView body);
  /// Writes the marks of the tick. If they exceed a limit of their chunk, a record says that they are left out.
  /// Requires: a begun tick, Feature::marks; at most once per tick.
  Status marks(const TickMarks& marks);
  /// Writes as many marks of the tick as fit. Requires: the same, and that the tick is stored in full.
  Status mark_list(const MarkList& list);
  /// Writes a note at once. Requires: a begun tick, Feature::notes.
  Status note(const Note& note);

  /// Writes the hashes of the tick. `stage_hashes` are used only if wants_stages(). `state`: after the tick; may be
  /// null unless wants_state().
  Status end_tick(std::uint64_t root_hash, std::span<const std::uint64_t> stage_hashes, const StateView* state);

  /// The same with an encoded image, for recovery.
  Status end_tick_encoded(std::uint64_t root_hash, std::span<const std::uint64_t> stage_hashes,
                          std::optional<ByteView> image, const StateCells* cells = nullptr);

  /// Whether the current or else the next tick is stored in full.
  bool wants_full() const;
  /// Whether this tick is stored with the hash after each of its stages.
  bool wants_stages() const;
  /// Whether this tick is stored with more than hashes.
  bool wants_state() const;

  /// Whether a checkpoint is due now, before the next begin_tick.
  bool wants_checkpoint() const;
  /// Requires: no begun tick; the first checkpoint at tick 0, later checkpoints ascending.
  Status checkpoint(const StateView& state, std::uint64_t root_hash);
  Status checkpoint_encoded(ByteView image, std::uint64_t root_hash);
  /// Writes the shown image of the last written state, of a checkpoint or a tick. Requires: Feature::shown.
  Status shown(ByteView bytes);
  /// Writes the save of the program for the last written checkpoint. Requires: Feature::saves, no tick begun since the
  /// checkpoint.
  Status save(ByteView bytes);

  /// Writes what is known about another player. Requires: Feature::peers, a checkpoint; after all ticks, in ascending
  /// order of players, all with the same recorder and tick. Errors: limit, io.
  Status peer(const PeerRecord& peer);

  /// Writes end record, index and footer and closes the file.
  Status finish(EndReason reason, const std::string& note);

  /// Removes the file and restores an overwritten file.
  void discard();

  /// To be called after an error of another call. Returns `error` with the fate of the file: without a complete tick
  /// the file is discarded, otherwise it stays, truncated.
  Error abandon(Error error);

  /// Whether a checkpoint has been written; ticks require one.
  bool has_checkpoint() const;

  std::uint64_t tick_count() const;
  std::uint64_t size() const;  // bytes written so far

 private:
  struct Impl;
  static Status check(const TraceSetup& setup, const BuildFacts& facts, const std::string& path,
                      const WriterOptions& options);
  explicit TraceWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ticktrue::replay
