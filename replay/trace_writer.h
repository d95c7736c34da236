// Writes a trace while the simulation runs: append-only, readable at every moment.
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
  bool overwrite = false;    // replace an existing file; else it is an error
  bool compress = true;      // checkpoints and images with zstd where the build has it
  bool sync = true;          // fsync at checkpoints (at most one a second) and at the end (power loss)
  bool allow_third = false;  // format version 3 where the setup needs it: not all of it is built yet
};

/// Order of calls: create, checkpoint (tick 0), then begin_tick / end_tick for each tick, checkpoint in between where
/// due, finish. Any error is final; what was written before it stays readable.
class TraceWriter {
 public:
  /// Creates the file and writes setup and build facts. With options.overwrite an existing file is kept as
  /// `<path>.old` until finish or discard.
  /// Errors: io (exists, unwritable), limit.
  static Result<TraceWriter> create(const std::string& path, const TraceSetup& setup, const BuildFacts& facts,
                                    const WriterOptions& options = {});
  /// The same with an output that is there already.
  static Result<TraceWriter> to(OutputFile file, const TraceSetup& setup, const BuildFacts& facts,
                                const WriterOptions& options);
  TraceWriter(TraceWriter&&) noexcept;
  TraceWriter& operator=(TraceWriter&&) noexcept;
  ~TraceWriter();  // leaves the file as it is: truncated, unless finished

  /// The trace begins with so many ticks done. Requires: Feature::tail, no checkpoint yet.
  void begin_at(std::uint64_t tick, double time_s);

  /// Hands dt (if it changed) and inputs (if any) to the operating system. Call before the tick runs.
  Status begin_tick(const TickInput& input);

  /// Hands a record outside of the chain to the operating system. Requires: a tick begun, the feature.
  /// Errors: limit (those of the chunk are too many; nothing is written).
  Status bound_record(RecordTag tag, ByteView body);
  /// Hands the marks of the tick to the operating system. Where they pass a limit of their chunk, it is written that
  /// they are left out. Requires: a tick begun, Feature::marks; once a tick.
  Status marks(const TickMarks& marks);
  /// Each mark of the tick, as many as fit. Requires: the same, and that the tick is stored in full.
  Status mark_list(const MarkList& list);
  /// Hands a note to the operating system at once. Requires: a tick begun, Feature::notes.
  Status note(const Note& note);

  /// Hands the hashes of the tick to the operating system. `stage_hashes` count only where they are stored
  /// (wants_stages()), `state`, after the tick, also with detail cells (wants_state()); else it may be null.
  Status end_tick(std::uint64_t root_hash, std::span<const std::uint64_t> stage_hashes, const StateView* state);

  /// The same with an encoded image, for recovery.
  Status end_tick_encoded(std::uint64_t root_hash, std::span<const std::uint64_t> stage_hashes,
                          std::optional<ByteView> image, const StateCells* cells = nullptr);

  /// Whether the tick that is in flight or begins next is to be stored in full.
  bool wants_full() const;
  /// Whether the hash after each of its stages is stored.
  bool wants_stages() const;
  /// Whether more than hashes is stored of that tick.
  bool wants_state() const;

  /// Whether a checkpoint is due now, before the next begin_tick.
  bool wants_checkpoint() const;
  /// Requires: no tick begun; the first at tick 0, later ones ascending.
  Status checkpoint(const StateView& state, std::uint64_t root_hash);
  Status checkpoint_encoded(ByteView image, std::uint64_t root_hash);
  /// The shown image of the state that was written last, as a checkpoint or with a tick. Requires: Feature::shown.
  Status shown(ByteView bytes);
  /// What brings the program back to the state of the checkpoint that was written last. Requires: Feature::saves, no
  /// tick begun since.
  Status save(ByteView bytes);

  /// What is known of another player. Behind all ticks; players ascend, and all have the same recorder and tick.
  /// Requires: Feature::peers, a checkpoint. Errors: limit, io.
  Status peer(const PeerRecord& peer);

  /// Writes end record, index and footer and closes the file.
  Status finish(EndReason reason, const std::string& note);

  /// Removes the file (and puts an overwritten one back): as if it had never been created.
  void discard();

  /// After an error of one of these calls: `error` with what becomes of the file. Without a whole tick it is discarded,
  /// else it stays, truncated.
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
