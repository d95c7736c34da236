// The recording loop: writes the inputs, runs the tick, writes the hashes.
// SPDX-License-Identifier: MIT
#include "replay/recorder.h"

#include <chrono>
#include <utility>
#include <vector>

#include "base/float_behaviour.h"
#include "base/state/child_tables.h"
#include "base/state/row_names.h"
#include "base/state/stage_hashes.h"

namespace ticktrue::replay {
namespace {

std::string non_finite_text(const Simulation& simulation, std::uint64_t tick, const StatePlace& place) {
  const RowNamer row_name = [&](std::size_t table, std::size_t row) { return simulation.row_name(table, row); };
  return "tick " + std::to_string(tick) + ": " + place_text(*simulation.state().schema, place, row_name) +
         ": found a value that is not finite";
}

/// One running recording.
class Recording {
 public:
  Recording(Simulation& simulation, InputSource& source, TraceWriter& writer, const RecordOptions& options,
            bool has_saves)
      : simulation_(simulation), source_(source), writer_(writer), options_(options), has_saves_(has_saves) {}

  Result<RecordResult> run() {
    result_.root_hash = root_hash(simulation_.state());
    for (;;) {
      if (writer_.wants_checkpoint()) {
        Result<std::optional<Bytes>> save = find_save();
        if (!save) return give_up(save.error());
        if (const Status status = write_checkpoint(*save); !status) return writer_.abandon(status.error());
      }
      const std::uint64_t tick = writer_.tick_count();
      if (options_.tick_count && tick >= *options_.tick_count) return finish(EndReason::complete, "");
      if (is_stopped(tick)) return stop(tick);
      Result<std::optional<TickInput>> input = source_.next(tick);
      // A signal can end the wait for live inputs: then the wait returns an error.
      if (!input && !source_.repeatable() && is_stopped(tick)) return stop(tick);
      if (!input) return source_.tick_failed() ? give_up(input.error()) : refuse(input.error());
      if (!input->has_value() && tick == 0)
        return refuse(Error{ErrorCode::invalid_input, "the session ends before its first tick: nothing to record", ""});
      if (!input->has_value()) return finish(EndReason::complete, "");
      if (const Status status = simulation_.accept(**input); !status) return refuse(status.error());
      if (const Status status = writer_.begin_tick(**input); !status) return writer_.abandon(status.error());
      const bool has_stages = writer_.wants_stages();
      if (const Status status = step(**input, has_stages); !status) return give_up(status.error());
      if (const std::optional<StatePlace> place = find_non_finite(simulation_.state()))
        return finish(EndReason::non_finite, non_finite_text(simulation_, tick, *place));
      result_.root_hash = root_hash(simulation_.state());
      if (const Status status = writer_.end_tick(result_.root_hash, stage_hashes_.hashes(),
                                                 writer_.wants_state() ? &simulation_.state() : nullptr);
          !status)
        return writer_.abandon(status.error());
    }
  }

 private:
  bool is_stopped(std::uint64_t tick) { return options_.progress && !options_.progress(tick); }

  /// Nothing: the trace has no saves.
  Result<std::optional<Bytes>> find_save() {
    if (!has_saves_) return std::optional<Bytes>();
    Result<std::optional<Bytes>> save = simulation_.save(writer_.tick_count());
    if (save && !*save) ++result_.saves_missing;
    return save;
  }

  Status write_checkpoint(const std::optional<Bytes>& save) {
    if (const Status status = writer_.checkpoint(simulation_.state(), result_.root_hash); !status) return status;
    return save ? writer_.save(*save) : Status();
  }

  Result<RecordResult> stop(std::uint64_t tick) {
    if (tick > 0) return finish(EndReason::interrupted, "stopped on request");
    writer_.discard();
    result_.reason = EndReason::interrupted;
    result_.note = "stopped before the first tick";
    return std::move(result_);
  }

  Status step(const TickInput& input, bool has_stages) {
    stage_hashes_.clear();
    const auto before = std::chrono::steady_clock::now();
    Status did = simulation_.step(input, has_stages ? &stage_hashes_ : nullptr);
    result_.simulate_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    return did;
  }

  Result<RecordResult> finish(EndReason reason, const std::string& note) {
    if (const Status status = writer_.finish(reason, note); !status) return writer_.abandon(status.error());
    result_.tick_count = writer_.tick_count();
    result_.size = writer_.size();
    result_.reason = reason;
    result_.note = note;
    return std::move(result_);
  }

  /// Handles an input that the source or the simulation refused.
  Error refuse(Error error) {
    if (source_.repeatable() || writer_.tick_count() == 0) {
      writer_.discard();
      return error;
    }
    return close_before(std::move(error));
  }

  /// Handles a failed tick. The earlier ticks are kept: they show how the simulation got there.
  Error give_up(Error error) {
    if (writer_.tick_count() > 0) return close_before(std::move(error));
    writer_.discard();
    return error;
  }

  Error close_before(Error error) {
    const std::uint64_t tick_count = writer_.tick_count();
    if (const Status status = writer_.finish(EndReason::interrupted, error.message); !status)
      return writer_.abandon(status.error());
    error.hint += (error.hint.empty() ? "" : "; ") + std::string("the trace was closed and holds the ") +
                  std::to_string(tick_count) + " ticks before";
    return error;
  }

  Simulation& simulation_;
  InputSource& source_;
  TraceWriter& writer_;
  const RecordOptions& options_;
  bool has_saves_;
  StageHashes stage_hashes_;  // of ticks with stored stage hashes
  RecordResult result_;
};

}  // namespace

Result<std::optional<TickInput>> NoInputs::next(std::uint64_t) {
  return std::optional<TickInput>(TickInput{dt_, {}});
}

Result<RecordResult> record(Simulation& simulation, InputSource& source, const std::string& path,
                            const TraceSetup& setup, const BuildFacts& facts, const RecordOptions& options) {
  if (const Status floats = check_float_behaviour(); !floats) return floats.error();
  if (const std::optional<StatePlace> place = find_non_finite(simulation.state()))
    return Error{ErrorCode::invalid_scene, "initial state, " + non_finite_text(simulation, 0, *place), ""};
  const bool has_saves = setup.has(Feature::saves);
  WriterOptions writer_options = options.writer;
  writer_options.allow_third = writer_options.allow_third || has_saves || has_children(setup.schema);
  Result<TraceWriter> writer = TraceWriter::create(path, setup, facts, writer_options);
  if (!writer) return writer.error();
  return Recording(simulation, source, *writer, options, has_saves).run();
}

}  // namespace ticktrue::replay
