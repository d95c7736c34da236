// The part of a session about saves: where a run begins, and ticks that run a second time.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstring>
#include <utility>

#include "base/count_text.h"
#include "base/hash.h"
#include "capi/marks/shake_page.h"
#include "capi/session.h"
#include "replay/format/shown_image.h"
#include "verifier/locate/locate.h"

namespace ticktrue::capi {
namespace {

constexpr std::size_t lane_count_max = 64;

/// During its lifetime, actions of this thread belong to a callback of the program.
class InCallback {
 public:
  explicit InCallback(bool& flag) : flag_(flag) { flag_ = true; }
  InCallback(const InCallback&) = delete;
  InCallback& operator=(const InCallback&) = delete;
  ~InCallback() { flag_ = false; }

 private:
  bool& flag_;
};

std::string range_text(std::uint64_t first, std::uint64_t behind) {
  return behind == first + 1 ? "tick " + std::to_string(first)
                             : "ticks " + std::to_string(first) + ".." + std::to_string(behind - 1);
}

}  // namespace

Status Session::gather() {
  if (!state_.has_children()) return state_.gather();
  const InCallback inside(in_callback_), gathering(is_gathering_);
  const Status status = state_.gather();
  // A wrong call from inside the callback has failed the session, and the session has its message.
  return status_ == TICKTRUE_OK ? status : Error{ErrorCode::usage, message_, ""};
}

bool Session::save_now(std::optional<Bytes>& bytes) {
  const KeptState before(state_.view());
  Result<std::optional<Bytes>> saved = [&] {
    const InCallback inside(in_callback_);
    std::optional<OutOfLibrary> outside;
    if (probe_) outside.emplace();
    return saves_.save(tick_);
  }();
  if (status_ != TICKTRUE_OK) return false;  // a wrong call from inside the callback
  if (!saved) return fail(saved.error()), false;
  bytes = std::move(*saved);
  if (const Status status = gather(); !status) return fail(status.error()), false;
  if (before.is_same(state_.view())) return true;
  const verifier::Divergence changed = verifier::between_states(before.view(), state_.view(), namer(), lane_count_max);
  std::string place;
  if (!changed.rows.empty())
    place =
        ": " + changed.rows[0].table + "." + changed.rows[0].column + ", row " + std::to_string(changed.rows[0].row);
  else if (!changed.contents.empty())
    place = ": " + changed.contents[0].place;
  fail({ErrorCode::usage,
        "save callback: tick " + std::to_string(tick_) + ": it changes the state" + place + ": hash before " +
            hex64(changed.expected_root) + ", behind it " + hex64(changed.got_root),
        "save writes to the buffer alone"});
  return false;
}

bool Session::gather_shown(std::optional<Bytes>& bytes) {
  const Result<std::vector<ShownRows>> rows = state_.gather_shown();
  if (!rows) return fail(rows.error()), false;
  replay::encode_shown(*rows, bytes.emplace());
  return true;
}

bool Session::load_now(std::uint64_t tick, ByteView bytes) {
  const Status loaded = [&] {
    const InCallback inside(in_callback_);
    std::optional<OutOfLibrary> outside;
    if (probe_) outside.emplace();
    return saves_.load(tick, bytes);
  }();
  if (status_ != TICKTRUE_OK) return false;
  if (!loaded) return fail(loaded.error()), false;
  ++load_count_;
  const Status gathered = gather();
  if (!gathered) {
    fail({gathered.error().code,
          "load callback: tick " + std::to_string(tick) + ": behind it: " + gathered.error().message,
          gathered.error().hint});
    return false;
  }
  return true;
}

bool Session::open_sync_block() {
  std::optional<Bytes> save;
  if (!save_now(save)) return false;
  if (save)
    second_.open(tick_, std::move(*save), state_.view());
  else
    ++missing_saves_;
  return true;
}

bool Session::go_back() {
  const std::uint64_t first = second_.first();
  if (!load_now(first, second_.save())) {
    if (probe_) probe_->load_failed(message_);
    return false;
  }
  tick_ = first;
  inputs_.clear();
  inputs_taken_ = 0;
  if (probe_) probe_->loaded(state_.view());
  if (second_.state().is_same(state_.view())) {
    second_.begin_second();
    return true;
  }
  differs(first, &second_.state(), "the load callback does not bring back the state at tick " + std::to_string(first),
          verifier::stage_load);
  return false;
}

int Session::after_probed_tick() {
  if (probe_->role() == Probe::Role::trial) return TICKTRUE_OK;
  if (probe_->role() == Probe::Role::straight) {
    if (!second_.is_open()) probe_->leave();
    if (second_.behind() - second_.first() < probe_->length() && recorded() != nullptr) return TICKTRUE_OK;
    return go_back() ? TICKTRUE_OK : status_;
  }
  if (!probe_->wants_window(tick_) || recorded() == nullptr) return TICKTRUE_OK;
  std::optional<Bytes> save;
  if (!save_now(save)) return status_;
  if (!save) return probe_->no_save(tick_), TICKTRUE_OK;
  comparing_->at(tick_ + probe_->length());  // reads the ticks now, because copies of the process read no file
  const auto apply = [this](const MovedColumn& moved) {
    if (!moved.column.empty()) return static_cast<bool>(state_.column(moved.table, moved.column, moved.source));
    const std::optional<std::size_t> table = state_.find_table(moved.table);
    return table && static_cast<bool>(state_.rows(*table, moved.source.data, moved.source.row_count));
  };
  if (probe_->run_window(tick_, state_.view(), apply) && probe_->role() == Probe::Role::straight)
    second_.open(tick_, std::move(*save), state_.view());
  return TICKTRUE_OK;
}

void Session::tell_probe(const char* table, const char* column, const ColumnSource& source) {
  if (in_callback_) probe_->column_moved({table, column, source});
}

int Session::after_first_run(std::optional<Bytes> recorded_save) {
  if (probe_) return after_probed_tick();
  // A loop that counts to the end of its trace would not request another tick.
  if (comparing_ && can_go_back() && recorded() == nullptr) return go_back() ? TICKTRUE_OK : status_;
  if (sync_ticks_ > 0) {
    if (!second_.is_open()) return open_sync_block() ? TICKTRUE_OK : status_;
    const bool is_full = second_.behind() - second_.first() >= sync_ticks_ || !second_.has_room();
    if (is_full && can_go_back() && !go_back()) return status_;
    return TICKTRUE_OK;
  }
  if (!recorded_save) return TICKTRUE_OK;
  if (!can_go_back()) {
    second_.open(tick_, std::move(*recorded_save), state_.view());
    return TICKTRUE_OK;
  }
  next_save_ = std::move(recorded_save);
  return go_back() ? TICKTRUE_OK : status_;
}

int Session::end_second(std::uint64_t tick) {
  const FirstRunTick& first = second_.at(tick);
  if (!first.is_same(state_.view()))
    return differs(tick, first.state ? &*first.state : nullptr,
                   "tick " + std::to_string(tick) +
                       " ended in two states: the second run began with the save of tick " +
                       std::to_string(second_.first()),
                   "");
  // A program state with a period equal to the number of repeated ticks would be in step again. So every other second
  // run begins twice.
  if (probe_) return TICKTRUE_OK;
  if (tick == second_.first() && second_.behind() - tick > 1 && begins_twice_) {
    begins_twice_ = false;
    return go_back() ? TICKTRUE_OK : status_;
  }
  ++second_count_;
  if (tick_ < second_.behind()) return TICKTRUE_OK;
  begins_twice_ = ++second_run_count_ % 2 == 0;
  second_.close();
  if (sync_ticks_ > 0) return open_sync_block() ? TICKTRUE_OK : status_;
  if (next_save_) second_.open(tick_, std::move(*next_save_), state_.view());
  next_save_.reset();
  return TICKTRUE_OK;
}

int Session::differs(std::uint64_t tick, const KeptState* first, const std::string& reason, std::string_view stage) {
  SecondRunFinding finding;
  finding.begin = second_.first();
  finding.reason = reason;
  if (first != nullptr)
    finding.divergence = verifier::between_states(first->view(), state_.view(), namer(), lane_count_max);
  finding.divergence.tick = tick;
  if (!stage.empty()) {
    finding.divergence.stage = std::string(stage);
    finding.divergence.stage_note = "expected: the state that was saved; got: the state behind load";
  } else {
    finding.divergence.stage_note = "expected: the first run; got: the second run, behind load";
  }
  if (comparing_) {
    comparing_->second_run_differs(std::move(finding));
  } else {
    verifier::Report report;
    report.file = path_;
    report.simulation = identity_.name;
    report.mode = "sync";
    report.verdict = verifier::Verdict::state_incomplete;
    report.checkpoint = finding.begin;
    report.reason = std::move(finding.reason);
    report.hint = verifier::second_run_hint;
    report.divergence = std::move(finding.divergence);
    recording_->add_finding(std::move(report));
  }
  return stop(TICKTRUE_DIVERGED);
}

int Session::input_of_second(void* data, std::size_t size) {
  const Bytes& inputs = second_.at(tick_).inputs;
  if (size > inputs.size() - inputs_taken_)
    return differs(tick_, nullptr,
                   "tick " + std::to_string(tick_) + ": inputs: the first run took " + std::to_string(inputs.size()) +
                       " bytes, the second asks for " + std::to_string(inputs_taken_ + size),
                   "");
  std::memcpy(data, inputs.data() + inputs_taken_, size);
  inputs_taken_ += size;
  return TICKTRUE_OK;
}

int Session::begin_second_tick(double* dt) {
  const FirstRunTick& first = second_.at(tick_);
  if (inputs_taken_ != first.inputs.size())
    return differs(tick_, nullptr,
                   "tick " + std::to_string(tick_) + ": inputs: the first run took " +
                       std::to_string(first.inputs.size()) + " bytes, the second " + std::to_string(inputs_taken_),
                   "");
  dt_ = first.dt;
  if (dt != nullptr) *dt = dt_;
  stages_done_ = 0;
  stage_hashes_.clear();
  phase_ = Phase::inside;
  marks_.begin_tick(MarkDetail::counts);
  return TICKTRUE_OK;
}

int Session::seek(std::uint64_t tick) {
  if (status_ == TICKTRUE_END) status_ = TICKTRUE_OK;
  if (!can_call("seek") || refuse_in_callback("seek")) return status_;
  if (!comparing_) return wrong_order("seek: found a recording", "only a verification can go elsewhere");
  if (phase_ == Phase::inside)
    return wrong_order("seek: found a tick that runs, expected none", "end_tick comes first");
  if (phase_ == Phase::registering)
    return wrong_order("seek: found a session before its first tick", "`from` of the options says where it begins");
  if (!saves_.is_set()) return wrong_order("seek: found no load callback", "set save and load in the options");
  if (!comparing_->seek(tick))
    return wrong_order("seek: found no save at or before tick " + std::to_string(tick),
                       "the trace was recorded without save callback, or its saves are damaged");
  second_.close();
  next_save_.reset();
  pending_.clear();
  inputs_.clear();
  inputs_taken_ = 0;
  tick_ = confirmed_ = comparing_->begin_tick();
  if (!load_now(tick_, *comparing_->begin_save())) return status_;
  if (!comparing_->check_begin(state_.view(), namer())) return stop(TICKTRUE_DIVERGED);
  if (restores_) second_.open(tick_, *comparing_->begin_save(), state_.view());
  if (sync_ticks_ > 0 && !open_sync_block()) return status_;
  return TICKTRUE_OK;
}

void Session::judge_second_runs() {
  if ((sync_ticks_ == 0 && !restores_) || status_ == TICKTRUE_FAILED || status_ == TICKTRUE_DIVERGED) return;
  const std::string what = restores_ ? "restore" : "sync test";
  const std::string done = what + ": " + count_text(second_count_, "tick") + " ran twice" +
                           (second_count_ > 0 ? " with the same state" : "");
  std::string missing;
  if (can_go_back() || second_.is_second())
    missing = what + ": the loop ended before the second run of " +
              range_text(second_.is_second() ? tick_ : second_.first(), second_.behind());
  if (second_count_ == 0 && missing.empty()) missing = what + ": no tick ran twice";
  if (missing_saves_ > 0)
    missing += (missing.empty() ? what + ": " : "; ") + count_text(missing_saves_, "time") +
               " the save callback returned TICKTRUE_SAVE_FAILED";
  constexpr const char* hint = "a loop that runs ticks twice counts them by its state or by ticktrue_tick";
  if (comparing_) {
    comparing_->note(done);
    if (!missing.empty()) comparing_->not_whole(missing, hint);
  } else {
    recording_->notes.push_back(done);
    if (!missing.empty()) recording_->warnings.push_back(missing);
  }
}

}  // namespace ticktrue::capi
