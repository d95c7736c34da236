// The verifying side of a session: returns recorded inputs, compares each confirmed tick, makes the report.
// SPDX-License-Identifier: MIT
//
// The program runs once. Whether two runs of this build agree, which `ticktrue verify` finds by a second run, is not
// known here. The report states how to find out.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "capi/tick.h"
#include "replay/trace_reader.h"
#include "verifier/locate/compare_tick.h"
#include "verifier/report/report.h"

namespace ticktrue::capi {

/// A copy of a recorded tick, held until the tick is confirmed.
struct RecordedTick : verifier::StoredTick {
  std::optional<verifier::StoredCheckpoint> checkpoint;  // behind it
  bool is_not_finite = false;                            // the recording ended because of this tick
};

class Comparing {
 public:
  Comparing(replay::TraceReader reader, std::string file);

  const replay::TraceSetup& setup() const { return reader_.setup(); }

  /// Facts about the build of this program.
  void set_facts(replay::BuildFacts facts) { report_.here_build = std::move(facts); }
  /// Whether the program is the one that recorded. False: the report says what differs.
  bool check_identity(const Identity& identity);
  /// Compares columns, stages and the initial state. False: the report says what differs.
  bool start(const StateView& state, const std::vector<std::string>& stages, const RowNamer& row_name);

  /// The tick as recorded, or null when there are no more. Valid until compare() of that tick.
  const RecordedTick* at(std::uint64_t tick);

  /// Compares the next tick. False: it differs, and the report says where.
  bool compare(const DoneTick& done, const RowNamer& row_name);

  /// The inputs that a tick took are not those it was recorded with.
  void other_inputs(std::uint64_t tick, const std::string& what);

  /// Decides the verdict; later ticks are not compared. `ticks_run`: by the program.
  void finish(std::uint64_t ticks_run);
  const verifier::Report& report() const { return report_; }
  bool has_finding() const { return decided_; }

 private:
  bool read_until(std::uint64_t tick);
  void take_checkpoint(const replay::CheckpointRecord& checkpoint);
  void diverge(const RecordedTick& recorded, const DoneTick& done, const verifier::TickSide& expected,
               const verifier::TickSide& here, const RowNamer& row_name);
  void not_comparable(const std::string& reason, const std::string& hint);
  bool compare_non_finite(const RecordedTick& recorded, const DoneTick& done, const RowNamer& row_name);
  void note_addresses(const verifier::Divergence& divergence);
  void note_floats();

  replay::TraceReader reader_;
  verifier::TickComparer comparer_;
  verifier::Report report_;
  std::optional<verifier::StoredCheckpoint> initial_;  // the recorded initial state, once it was read
  std::deque<RecordedTick> ahead_;                     // read and not yet compared
  bool at_end_ = false;
  bool decided_ = false;
  bool changed_ = false;
  std::uint64_t first_root_ = 0;
  double last_dt_ = 0;
};

}  // namespace ticktrue::capi
