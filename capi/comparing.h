// The verifying side of a session: returns recorded inputs, compares each confirmed tick, and makes the report.
// SPDX-License-Identifier: MIT
// The program runs once, so the session cannot tell whether two runs of this build agree. `ticktrue verify` finds this
// by a second run. The report states how to find out.
// known here. The report states how to find out.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "capi/tick.h"
#include "replay/trace_reader.h"
#include "verifier/locate/compare_tick.h"
#include "verifier/report/report.h"
#include "verifier/verify/trace_source.h"

namespace ticktrue::capi {

/// The range of a verification, from the options.
struct CompareRange {
  std::uint64_t from = 0;           // the first tick that counts as compared
  std::optional<std::uint64_t> to;  // the last tick
};

/// The second run of a tick ended in another state than the first run.
struct SecondRunFinding {
  std::uint64_t begin = 0;  // tick of the save at which both runs began
  std::string reason;
  verifier::Divergence divergence;
};

/// A copy of a recorded tick, stored until the tick is confirmed.
struct RecordedTick : verifier::StoredTick {
  std::optional<verifier::StoredCheckpoint> checkpoint;  // after the tick
  std::optional<Bytes> save;                             // of that checkpoint
  std::optional<Bytes> shown;                            // the shown image after the tick
  std::optional<replay::TickMarks> marks;                // nothing: the tick has no marks
  bool has_bound = true;                                 // false: it is unknown whether the tick has marks
  bool is_not_finite = false;                            // the recording ended because of this tick
};

class Comparing {
 public:
  Comparing(replay::TraceReader reader, std::string file, CompareRange range);

  const replay::TraceSetup& setup() const { return source_.setup(); }

  /// Facts about the build of this program.
  void set_facts(replay::BuildFacts facts) { report_.here_build = std::move(facts); }
  /// Whether this program is the one that recorded. False: the report says what differs.
  bool check_identity(const Identity& identity);
  std::uint64_t first_tick() const { return source_.first_tick(); }
  bool has_marks() const { return setup().has(replay::Feature::marks); }
  bool has_saves() const { return setup().has(replay::Feature::saves); }
  void set_mode(const std::string& mode) { report_.mode = mode; }

  /// Moves to the last checkpoint with a save at or before `tick`. False: there is none, and the position is unchanged.
  bool seek(std::uint64_t tick);
  /// The tick at which the run begins.
  std::uint64_t begin_tick() const { return begin_ ? begin_->tick : 0; }
  /// The save that brings the program to this tick; null: the run begins with the setup.
  const Bytes* begin_save() const { return begin_save_ ? &*begin_save_ : nullptr; }
  /// The save of the checkpoint at tick 0, for a run that begins with the setup; null: none. Requires: check_begin().
  const Bytes* first_save() const { return first_save_ ? &*first_save_ : nullptr; }

  /// Compares columns and stages. False: the report says what differs.
  bool start(const StateView& state, const std::vector<std::string>& stages);
  /// Compares the state at which the run begins. False: the report says what differs.
  bool check_begin(const StateView& state, const RowNamer& row_name);

  /// The recorded save after this tick, which is not compared yet; nothing: the trace has none there.
  std::optional<Bytes> save_behind(std::uint64_t tick);

  /// The recorded tick; null: there are no more. Valid until compare() of this tick.
  const RecordedTick* at(std::uint64_t tick);

  /// Compares the next tick. False: it differs, and the report says where. `whole`: the schema of this program with the
  /// shown columns.
  bool compare(const DoneTick& done, const StateSchema& whole, const RowNamer& row_name);
  /// Notes shown columns that differ from the recorded ones. They change no verdict.
  void note_shown_schema(const StateSchema& whole);

  /// Reports that a tick took other inputs than the recorded ones.
  void other_inputs(std::uint64_t tick, const std::string& what);

  /// Decides the verdict; later ticks are not compared. `ticks_run`: ticks that the program ran.
  void finish(std::uint64_t ticks_run);

  /// Reports that two runs of this program differ, and that the first run matched the recording.
  void second_run_differs(SecondRunFinding finding);
  /// Sets the verdict of an incomplete run that otherwise matches. `reason` is one line.
  void not_whole(const std::string& reason, const std::string& hint);
  void refuse(const std::string& reason, const std::string& hint) { not_comparable(reason, hint); }
  void note(std::string text) { report_.notes.push_back(std::move(text)); }
  const verifier::Report& report() const { return report_; }
  bool has_finding() const { return decided_; }

 private:
  bool read_until(std::uint64_t tick);
  void count(std::uint64_t tick);
  /// Ticks of the range that were left out between the first and the last compared tick; empty: none.
  std::string gaps() const;
  bool is_behind_range() const { return range_.to && next_ > *range_.to; }
  void take_checkpoint(const replay::CheckpointRecord& checkpoint);
  void diverge(const RecordedTick& recorded, const DoneTick& done, const verifier::TickSide& expected,
               const verifier::TickSide& here, const RowNamer& row_name);
  void not_comparable(const std::string& reason, const std::string& hint);
  bool compare_non_finite(const RecordedTick& recorded, const DoneTick& done, const RowNamer& row_name);
  void compare_marks(const RecordedTick& recorded, const DoneTick& done);
  void note_shown(const Bytes* recorded, const Bytes* here, const StateSchema& whole);
  void note_addresses(const verifier::Divergence& divergence);
  void note_floats();

  verifier::OwnedReaderSource source_;
  verifier::TickComparer comparer_;
  verifier::Report report_;
  CompareRange range_;
  std::optional<verifier::StoredCheckpoint> initial_;  // the recorded initial state, after it was read
  std::optional<Bytes> first_save_;                    // the save after it
  std::optional<verifier::StoredCheckpoint> begin_;    // the checkpoint at which the run begins; nothing: the setup
  std::optional<Bytes> begin_save_;
  std::uint64_t next_ = 0;                                        // the next tick to compare
  std::vector<std::pair<std::uint64_t, std::uint64_t>> counted_;  // compared: first tick, one after the last
  std::deque<RecordedTick> ahead_;                                // read and not compared yet
  bool at_end_ = false;
  bool decided_ = false;
  bool changed_ = false;
  std::uint64_t first_root_ = 0;
  double last_dt_ = 0;
};

}  // namespace ticktrue::capi
