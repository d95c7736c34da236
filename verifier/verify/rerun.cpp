// The second run up to a mismatch, and its effect on the verdict.
// SPDX-License-Identifier: MIT
#include "verifier/verify/rerun.h"

#include <utility>
#include <variant>

#include "base/state/stage_hashes.h"
#include "verifier/locate/locate.h"
#include "verifier/locate/locate_cells.h"

namespace ticktrue::verifier {
namespace {

class RunAgain {
 public:
  RunAgain(const WalkContext& context, TraceSource& source, const Mismatch& mismatch, Findings& findings,
           const std::function<void(std::uint64_t)>& progress)
      : context_(context), source_(source), mismatch_(mismatch), findings_(findings), progress_(progress) {}

  Rerun run(Start start) {
    if (!go_to_start(source_, start)) return std::move(rerun_);
    simulation_ = begin_at(context_, start, findings_);
    if (simulation_ == nullptr) return std::move(rerun_);
    tick_ = start.tick;
    time_s_ = start.time_s;
    const StoredTick& expected = mismatch_.expected;
    while (tick_ < expected.tick && !rerun_.differs_at) {
      const replay::TraceReader::Item& item = source_.next();
      if (std::holds_alternative<std::monostate>(item)) break;
      if (const auto* record = std::get_if<replay::TickRecord>(&item)) run_tick(*record);
    }
    if (!rerun_.differs_at && tick_ == expected.tick) run_last({expected.dt, expected.inputs});
    if (rerun_.differs_at && !rerun_.divergence && *rerun_.differs_at != expected.tick) {
      Divergence divergence;
      divergence.tick = *rerun_.differs_at;
      divergence.time_s = time_s_;
      rerun_.divergence = std::move(divergence);
    }
    return std::move(rerun_);
  }

 private:
  void run_tick(const replay::TickRecord& record) {
    const TickInput input{record.dt, record.inputs};
    if (!simulation_->accept(input)) {
      rerun_.differs_at = tick_;
      return;
    }
    if (!steps(input, nullptr)) return;
    TickSide here{root_hash(simulation_->state())};
    if (here.root_hash != record.root_hash) {
      // At this tick, the first run agreed with the recorded hash.
      rerun_.differs_at = tick_;
      here.state = &simulation_->state();
      rerun_.divergence = describe_mismatch(context_, *simulation_, copy_of(record), time_s_, here, findings_);
      return;
    }
    time_s_ += record.dt;
    ++tick_;
    if (progress_) progress_(tick_);
  }

  /// False: the tick fails. It succeeded in the first run.
  bool steps(const TickInput& input, StageObserver* observer) {
    const Status did = simulation_->step(input, observer);
    if (did) return true;
    rerun_.differs_at = tick_;
    rerun_.why_undone = did.error().message;
    return false;
  }

  void run_last(const TickInput& input) {
    if (!simulation_->accept(input)) {
      rerun_.differs_at = tick_;
      return;
    }
    StageHashes stages;
    const bool has_stages = !mismatch_.expected.stage_hashes.empty();
    const Divergence& found = mismatch_.divergence;
    std::optional<RowsBefore> before;
    if (found.from_cells && (found.healed || found.unexplained_cells > 0))
      before = rows_before(simulation_->state(), names_of(*simulation_));
    if (!steps(input, has_stages ? &stages : nullptr)) return;
    Bytes image;
    encode_image(simulation_->state(), image);
    rerun_.same = image == mismatch_.got && stages.hashes() == mismatch_.got_stages;
    rerun_.done = true;
    if (rerun_.same && before) locate_again(*before);
    if (rerun_.same) return;
    rerun_.differs_at = tick_;
    rerun_.between = mismatch_.divergence;
    describe_lanes(context_, *simulation_, mismatch_.got, image, *rerun_.between, findings_);
  }

  void locate_again(const RowsBefore& before) {
    const StateSchema& schema = context_.setup.schema;
    const StateCells& recorded = *mismatch_.expected.cells;
    StateCells here;
    CellHasher(schema).hash(simulation_->state(), recorded.partition_cells, here);
    rerun_.located = mismatch_.divergence;
    locate_cells(schema, recorded, here, &simulation_->state(), names_of(*simulation_), context_.options.row_count_max,
                 *rerun_.located, &before);
  }

  const WalkContext& context_;
  TraceSource& source_;
  const Mismatch& mismatch_;
  Findings& findings_;
  const std::function<void(std::uint64_t)>& progress_;
  Rerun rerun_;
  std::unique_ptr<Simulation> simulation_;
  std::uint64_t tick_ = 0;
  double time_s_ = 0;
};

}  // namespace

Rerun run_again(const WalkContext& context, TraceSource& source, const Start& start, const Mismatch& mismatch,
                Findings& findings, const std::function<void(std::uint64_t)>& progress) {
  return RunAgain(context, source, mismatch, findings, progress).run(start);
}

void judge_mismatch(const Mismatch& mismatch, const Rerun& rerun, Findings& findings) {
  findings.decide(Verdict::diverged, "");
  Divergence divergence = rerun.located ? *rerun.located : mismatch.divergence;
  if (rerun.differs_at) {
    if (*rerun.differs_at < mismatch.expected.tick) {
      divergence = *rerun.divergence;
    } else if (divergence.tables.empty() && rerun.between) {
      divergence = *rerun.between;
      findings.notes.push_back("columns and values are those of two runs here");
    }
    divergence.stage.reset();
    divergence.stage_note = "not looked for: two runs here differ";
    findings.not_reproducible(
        "two runs here differ from tick " + std::to_string(*rerun.differs_at) + " on" +
        (rerun.why_undone.empty() ? "" : ": the second run could not do this tick: " + rerun.why_undone));
  }
  findings.divergence = std::move(divergence);
}

bool go_to_start(TraceSource& source, Start& start) {
  if (!start.loaded) {
    source.rewind();
    return true;
  }
  if (!source.seek(start.tick)) return false;
  const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&source.next());
  if (checkpoint == nullptr || checkpoint->tick != start.tick) return false;
  if (start.image.empty()) start = start_at(*checkpoint, start.time_s);
  return true;
}

}  // namespace ticktrue::verifier
