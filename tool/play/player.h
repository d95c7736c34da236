// Plays a trace forwards and backwards by re-simulation, and stores which ticks agreed with the recording.
// SPDX-License-Identifier: MIT
//
// Verified: the root hash of every tick that was run here. Not verified: ticks that were skipped by seeking to a
// checkpoint, and what only `ticktrue verify` compares (checkpoints, stored images).
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"
#include "replay/trace_reader.h"
#include "verifier/report/report.h"

namespace ticktrue::play {

enum class Match : std::uint8_t { unknown, same, different };

class Player {
 public:
  /// Reads the trace once: inputs, hashes and checkpoints. Of a truncated or damaged trace it reads the intact part.
  /// Errors: what TraceReader::open, scene_of and make_engine refuse; incomplete (no tick is intact); limit.
  static Result<std::unique_ptr<Player>> open(const std::string& path);

  const std::string& path() const { return path_; }
  const engine::Engine& engine() const { return *engine_; }
  const replay::TraceSetup& setup() const { return reader_->setup(); }
  const replay::TraceTail& tail() const { return tail_; }
  std::uint64_t tick_count() const { return dt_.size(); }

  /// Ticks done: the state shown is the one at the end of tick `position() - 1`.
  std::uint64_t position() const { return position_; }
  /// Runs or seeks until `target` ticks are done, the first difference is met (if `stop_at_difference`), the inputs are
  /// refused, or `is_late` says so; then it is to be called again. `target` beyond the end counts as the end.
  void go_to(std::uint64_t target, bool stop_at_difference, const std::function<bool()>& is_late);

  /// Runs every tick that was not run yet, from the first on, until one differs. False if `is_late` said so before the
  /// search was over; then it is to be called again.
  bool search(const std::function<bool()>& is_late);

  Match match(std::uint64_t tick) const { return match_[tick]; }
  bool has_inputs(std::uint64_t tick) const { return input_end(tick) > input_begin_[tick]; }
  ByteView inputs(std::uint64_t tick) const {
    return ByteView(inputs_).subspan(input_begin_[tick], input_end(tick) - input_begin_[tick]);
  }
  double dt(std::uint64_t tick) const { return dt_[tick]; }
  const std::vector<std::uint64_t>& checkpoints() const { return checkpoints_; }
  std::uint64_t recorded_hash(std::uint64_t tick) const { return hashes_[tick]; }
  double ms_per_tick() const { return ms_per_tick_; }  // of the last ticks run

  /// The first tick found to differ from the recording.
  std::optional<std::uint64_t> difference() const { return difference_; }
  /// Why the inputs of a tick were refused.
  const std::optional<std::string>& refused() const { return refused_; }
  /// What verify says of the first difference; nothing before one is met. Runs it when asked for the first time.
  const verifier::Report* report();
  /// The state as recorded at the end of the first tick that differs, where the trace stores it; valid like report().
  const Bytes* recorded_image();
  /// Ids of the bodies that the report names.
  std::vector<std::uint32_t> named_bodies();

 private:
  Player() = default;
  Status read_all();
  void start_at_nearest(std::uint64_t target);
  bool load_checkpoint(std::uint64_t tick);
  void run_tick();
  void save_state();
  std::size_t input_end(std::uint64_t tick) const {
    return tick + 1 < input_begin_.size() ? input_begin_[tick + 1] : inputs_.size();
  }

  std::string path_;
  std::optional<replay::TraceReader> reader_;
  std::unique_ptr<engine::Engine> engine_;
  Bytes first_state_;
  replay::TraceTail tail_;

  std::vector<double> dt_;                // [tick] s
  std::vector<std::uint64_t> hashes_;     // [tick] as recorded
  std::vector<std::size_t> input_begin_;  // [tick] where its inputs begin in inputs_
  Bytes inputs_;
  std::vector<std::uint64_t> checkpoints_;  // ticks done, ascending
  std::vector<Match> match_;                // [tick]

  std::uint64_t position_ = 0;
  std::uint64_t known_ = 0;  // ticks from the start that were run
  double ms_per_tick_ = 0;
  std::optional<std::uint64_t> difference_;
  std::optional<std::string> refused_;
  std::optional<verifier::Report> report_;
  std::optional<Bytes> recorded_image_;
  std::map<std::uint64_t, Bytes> saved_;  // cached states, by ticks done
  std::size_t saved_size_ = 0;            // bytes
};

}  // namespace ticktrue::play
