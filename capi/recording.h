// The recording side of a session: writes confirmed ticks into a trace.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "capi/tick.h"
#include "replay/box/box_writer.h"
#include "replay/trace_writer.h"
#include "verifier/report/report.h"

namespace ticktrue::capi {

struct RecordingOptions {
  std::string path;
  Identity identity;
  std::string title;
  double dt = 0;  // s
  replay::Detail detail = replay::Detail::root;
  std::uint64_t full_first = 0;
  std::uint64_t full_last = 0;
  std::uint32_t checkpoint_interval = 0;
  std::uint32_t features = 0;  // bits of replay::Feature
  Bytes setup;
  replay::WriterOptions writer;
  replay::BuildFacts facts;
  std::uint64_t box_size = 0;  // bytes; > 0: `path` is a black box
};

class Recording {
 public:
  explicit Recording(RecordingOptions options) : options_(std::move(options)) {}

  const RecordingOptions& options() const { return options_; }
  /// Requires: !is_started().
  void set_facts(replay::BuildFacts facts) { options_.facts = std::move(facts); }
  /// Whether the state and the hashes after each stage of this tick are stored.
  bool wants_stages(std::uint64_t tick) const;

  /// Whether the checkpoint after this number of ticks has a save.
  bool wants_save(std::uint64_t tick) const;

  /// Whether the shown columns after this tick are stored.
  bool wants_shown(std::uint64_t tick) const;

  bool is_box() const { return options_.box_size > 0; }
  /// Size of the file, bytes.
  std::uint64_t size() const { return box_ ? box_->file_size() : writer_ ? writer_->size() : 0; }

  /// Makes the trace store marks and notes. Requires: !is_started().
  void add_marks() {
    options_.features |=
        static_cast<std::uint32_t>(replay::Feature::marks) | static_cast<std::uint32_t>(replay::Feature::notes);
  }
  /// Whether the trace stores marks and notes.
  bool has_marks() const { return (options_.features & static_cast<std::uint32_t>(replay::Feature::marks)) != 0; }

  /// Creates the trace. `whole`: the schema with the shown columns; `contents`: of the first checkpoint.
  /// Errors: io, limit, usage (a value that is not finite).
  Status start(const StateView& state, const StateSchema& whole, const CheckpointContents& contents,
               const std::vector<std::string>& stages, const RowNamer& row_name);
  bool is_started() const { return writer_.has_value(); }

  /// Writes the inputs of a tick to the file. Errors: io, limit.
  Status begin(double dt, ByteView inputs);
  /// Writes a note of this tick to the file. Errors: io.
  Status note(const replay::Note& note);
  /// Writes the result of the tick. False: a value is not finite, and the trace is closed before this tick. Errors: io,
  /// limit.
  Result<bool> end(const DoneTick& tick, const RowNamer& row_name);

  /// Closes the trace. A recording without a tick leaves no file. Errors: io, usage.
  Status finish(replay::EndReason reason, const std::string& note);

  /// Adds the report of a sync test to this report.
  void add_finding(verifier::Report finding) { finding_ = std::move(finding); }
  bool has_finding() const { return finding_.has_value(); }

  std::string text() const;
  /// `desync`: a JSON object about the other players; may be empty.
  std::string json(const std::string& desync) const;
  bool is_finite() const { return reason_ != replay::EndReason::non_finite; }
  std::vector<std::string> warnings;
  std::vector<std::string> notes;

 private:
  Status write_bound(const BoundContents& bound, std::uint64_t tick);
  Status write_checkpoint(const StateView& state, std::uint64_t tick, const CheckpointContents& contents);
  Status begin_file(const StateView& state, const CheckpointContents& contents);
  /// Continues in the next slot of the box. Errors: io (a slot is too small for a checkpoint).
  Status begin_slot(const StateView& state, std::uint64_t tick, const CheckpointContents& contents);
  /// Whether the next tick might not fit into its slot.
  bool is_slot_low() const;
  Status write_due_checkpoint(const DoneTick& tick);
  std::string box_text() const;

  RecordingOptions options_;
  std::unique_ptr<replay::BoxWriter> box_;
  std::uint64_t box_written_ = 0;        // at the end of the last tick
  std::uint64_t box_checkpoint_ = 0;     // before the last checkpoint
  std::uint64_t tick_size_max_ = 0;      // the largest number of bytes of a tick
  std::uint64_t interval_size_max_ = 0;  // the largest number of bytes from a checkpoint to the next
  std::uint64_t box_gaps_ = 0;           // number of times that a write did not fit
  replay::TraceSetup setup_;
  std::optional<replay::TraceWriter> writer_;
  std::uint64_t first_root_ = 0;
  std::uint64_t root_ = 0;
  double time_s_ = 0;
  bool changed_ = false;
  bool closed_ = false;
  replay::EndReason reason_ = replay::EndReason::complete;
  std::string note_;
  std::uint64_t missing_saves_ = 0;  // checkpoints without a save
  std::optional<verifier::Report> finding_;
};

}  // namespace ticktrue::capi
