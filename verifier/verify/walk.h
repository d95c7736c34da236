// Walks one segment of a trace: simulates from a start and compares each tick and checkpoint with the records.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/state/simulation.h"
#include "verifier/locate/compare_tick.h"
#include "verifier/report/report.h"
#include "verifier/verify/trace_source.h"
#include "verifier/verify/verify.h"

namespace ticktrue::verifier {

/// Where a run begins: the state from the setup (tick 0, not loaded), or a loaded checkpoint.
struct Start {
  std::uint64_t tick = 0;
  double time_s = 0;
  bool loaded = false;
  Bytes image;  // if loaded
  Bytes save;   // if loaded; empty: the trace has none
  std::uint64_t root_hash = 0;
};
Start start_at(const replay::CheckpointRecord& checkpoint, double time_s);

/// The setup and options of one verification; constant while it runs.
struct WalkContext {
  const replay::TraceSetup& setup;
  const VerifyOptions& options;
};

/// The findings of a walk, for the report. `decided`: the verdict is final.
struct Findings {
  bool decided = false;
  Verdict verdict = Verdict::incomplete;
  std::string reason;
  std::string hint;
  std::optional<Divergence> divergence;
  std::vector<std::string> warnings;
  std::vector<std::string> notes;
  std::optional<NonFinite> non_finite;

  void decide(Verdict found, std::string why, std::string next = "");
  void not_reproducible(const std::string& why);
  /// Sets the verdict for a tick whose Simulation::step returned an error.
  void undone(const Error& error);
  void warn_unreadable(std::uint64_t tick, const Error& error);
};

/// The names of rows in the state here. The simulation must outlive the result.
RowNamer names_of(const Simulation& simulation);

/// A new simulation from the setup; null: the setup is refused, and `findings` has the reason.
std::unique_ptr<Simulation> make_simulation(const WalkContext& context, Findings& findings);
/// A simulation in the state of `start`; null: this is refused, and `findings` has the reason.
std::unique_ptr<Simulation> begin_at(const WalkContext& context, const Start& start, Findings& findings);
/// Whether runs begin with the saves of the trace, which the simulation loads itself. Otherwise they begin with the
/// images of checkpoints.
bool loads_saves(const WalkContext& context);
/// Whether a run can begin at the checkpoint. Requires: the simulation can load.
bool is_start(const WalkContext& context, const replay::CheckpointRecord& checkpoint);
/// Whether the simulation can load states.
bool can_load(const WalkContext& context, Findings& findings);
/// Sets the verdict if loading is required and not supported.
void refuse_loading(const WalkContext& context, Findings& findings);

/// Describes the divergence between the recorded tick `expected` and the tick of this build. The detail depends on what
/// the trace stores of the tick. Can add warnings to `findings`.
Divergence describe_mismatch(const WalkContext& context, Simulation& simulation, const StoredTick& expected,
                             double time_s, const TickSide& got, Findings& findings);
/// Fills tables, rows and lanes from two images. Warns if the expected image is unreadable.
void describe_lanes(const WalkContext& context, Simulation& simulation, ByteView expected, ByteView got,
                    Divergence& divergence, Findings& findings);

/// Whether any state has changed, except in the table `world`, whose tick and time always change.
class ChangeWatch {
 public:
  void begin(const StateView& state);
  void update(const StateView& state);
  bool changed() const { return changed_; }

 private:
  std::vector<Bytes> first_;
  bool changed_ = false;
};

enum class WalkEnd : std::uint8_t {
  end_of_trace,
  reached_stop,  // the checkpoint at the end of the segment, or the last tick requested
  mismatch,      // a tick has another hash: `mismatch` describes it, and the verdict is not decided yet
  stopped,       // another finding
  abandoned,     // Segment::is_abandoned returned true
};

/// A tick whose result differs from the recorded one.
struct Mismatch {
  StoredTick expected;
  TickPart part = TickPart::root_hash;    // the differing part
  Bytes got;                              // image of the state here
  std::vector<std::uint64_t> got_stages;  // hashes after the stages here; empty unless stored for the tick
  Divergence divergence;
};

/// The result of walking one segment.
struct WalkResult {
  WalkEnd end = WalkEnd::stopped;
  Findings findings;
  std::optional<Mismatch> mismatch;
  std::uint64_t tick = 0;  // number of ticks before the end of the walk
  double time_s = 0;       // simulated at `tick`
  double last_tick_s = 0;  // simulated at the end of the last tick compared, as in reports
  std::uint64_t ticks_compared = 0;
  std::uint64_t checkpoints_compared = 0;
  ComparedParts compared;                  // of these ticks
  std::optional<std::uint64_t> root_hash;  // of the last state that matched
  bool changed = false;                    // some state outside the table `world` has changed
  std::uint64_t last_checkpoint = 0;       // tick of the last checkpoint on the way, or of the start
  double last_checkpoint_s = 0;            // simulated time there
  std::optional<TraceEnd> trace_end;       // where the end was read
  std::optional<Start> boundary;           // the checkpoint at which the walk stopped
  // With Segment::sync_ticks.
  std::optional<std::uint64_t> sync_begin;      // the finding is of a second run: it began there
  std::optional<std::uint64_t> sync_last_load;  // tick of the state that was loaded last
  std::uint64_t sync_tick_count = 0;            // ticks that ran twice with the same state
  std::uint64_t sync_missing_saves = 0;         // times that there was no save
};

struct Segment {
  Start start;
  std::uint64_t stop = std::numeric_limits<std::uint64_t>::max();  // the walk ends at its checkpoint, which is compared
  std::uint64_t count_from = 0;                                    // ticks from here on count as compared
  bool counts = true;                                              // false: nothing counts
  bool counts_load = true;             // whether comparing the loaded state with the checkpoint counts
  std::uint64_t sync_ticks = 0;        // as in the options
  std::function<bool()> is_abandoned;  // asked once a tick; may be empty
  std::function<void(std::uint64_t ticks_done)> progress;  // may be empty
};

/// Walks the segment. Requires: `source` is directly after the checkpoint of the start, or at its beginning.
WalkResult walk(const WalkContext& context, TraceSource& source, const Segment& segment);

}  // namespace ticktrue::verifier
