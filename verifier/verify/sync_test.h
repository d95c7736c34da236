// Ticks of a walk run a second time, from a save on: what a rollback forgets shows there.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/state/second_run.h"
#include "base/state/simulation.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// The second run of a tick ended otherwise than the first, or there was none.
struct SyncFinding {
  std::uint64_t begin = 0;  // tick of the save from which both runs went on
  std::string reason;
  std::string hint;
  Divergence divergence;
};

/// What brings a simulation back to where a second run begins.
enum class BroughtBackBy : std::uint8_t { save, image };
/// The next step of a finding.
const char* sync_hint(BroughtBackBy by);

/// Drives the simulation of a walk: after so many ticks it is brought back to the state before them, and they run
/// again.
class SyncTest {
 public:
  /// `interval`: ticks that run twice at once, at least 1. The simulation must outlive this.
  SyncTest(Simulation& simulation, BroughtBackBy by, std::uint64_t interval, std::size_t row_count_max)
      : simulation_(simulation), by_(by), interval_(interval), row_count_max_(row_count_max) {}

  /// The walk begins, with `tick` ticks done and `time_s` simulated. False: finding().
  bool begin(std::uint64_t tick, double time_s);
  /// A tick of the first run has ended. False: finding().
  bool add(const TickInput& input);
  /// The walk has ended: the ticks that ran once run again. False: finding().
  bool finish();

  const std::optional<SyncFinding>& finding() const { return finding_; }
  std::uint64_t tick_count() const { return tick_count_; }               // that ran twice with the same state
  std::uint64_t missing_save_count() const { return missing_count_; }    // where the simulation had no save
  std::optional<std::uint64_t> last_load() const { return last_load_; }  // tick of the save that was loaded last

 private:
  bool open();
  bool run_again();
  bool bring_back();
  bool step_again(std::uint64_t tick);
  /// `first`: the state that the present one should be; null: there is none to compare with.
  bool fail(std::uint64_t tick, std::string reason, const KeptState* first, std::string_view stage = {});

  Simulation& simulation_;
  BroughtBackBy by_;
  std::uint64_t interval_;
  std::size_t row_count_max_;
  SecondRun ticks_;
  double begin_s_ = 0;      // simulated time where these begin
  std::uint64_t tick_ = 0;  // ticks done
  double time_s_ = 0;
  std::uint64_t run_count_ = 0;  // second runs done
  std::uint64_t tick_count_ = 0;
  std::uint64_t missing_count_ = 0;
  std::optional<std::uint64_t> last_load_;
  std::optional<SyncFinding> finding_;
};

}  // namespace ticktrue::verifier
