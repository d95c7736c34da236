// The order of calls in a session, and rollback.
// SPDX-License-Identifier: MIT
#include "capi/session.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/compiler/compiler.h"
#include "base/limits.h"
#include "base/plain_text.h"
#include "capi/call_values.h"
#include "capi/marks/shake_page.h"
#include "replay/format/chunk.h"
#include "verifier/report/exit_codes.h"

namespace ticktrue::capi {
namespace {

constexpr std::size_t note_count_max = 1024;  // notes that wait for their tick

/// Returns an address that differs between threads.
const void* own_thread() {
  static thread_local const char of_thread = 0;
  return &of_thread;
}

}  // namespace

Session::Session(const ticktrue_options& options) {
  if (const Status status = check_options(options); !status) {
    fail(status.error());
    return;
  }
  take_calls();
  set_facts();
  if (!comparing_) return;
  if (!comparing_->check_identity(identity_)) {
    stop(TICKTRUE_FAILED);
    return;
  }
  if (restores_ && !comparing_->has_saves()) {
    comparing_->refuse("holds no saves", "record it with the callbacks save and load in the options");
    stop(TICKTRUE_FAILED);
    return;
  }
  const std::uint64_t begin = std::max(from_, comparing_->first_tick());
  if (saves_.is_set() && begin > 0 && comparing_->seek(begin)) {
    tick_ = confirmed_ = comparing_->begin_tick();
  } else if (comparing_->first_tick() > 0) {
    comparing_->refuse(
        "begins at tick " + number(comparing_->first_tick()) + " and holds no state that this program can load",
        "show lists what it holds; diff compares it with another trace");
    stop(TICKTRUE_FAILED);
  }
}

Session::~Session() {
  if (takes_calls_) leave_calls(this);
}

void Session::take_calls() {
  calls_warning_ = follow_calls(take_call, this, takes_calls_);
  if (!calls_warning_.empty() && comparing_) comparing_->note(calls_warning_);
  if (!takes_calls_) return;
  marks_.turn_on();
  if (recording_) recording_->add_marks();
}

/// Any thread may call this. Calls of threads other than that of the tick have no defined order.
void Session::take_call(void* session, const char* name, std::uint64_t value, const void* caller) {
  auto& of_tick = *static_cast<Session*>(session);
  if (compiler::load_relaxed(of_tick.tick_thread_) != own_thread()) return;
  try {
    if (!of_tick.mark_quickly(name, value)) of_tick.mark(name, value, caller);
  } catch (...) {
    of_tick.has_dropped_marks_ = true;
  }
}

int Session::stop(int status) {
  if (status_ == TICKTRUE_OK) status_ = status;
  return status_;
}

int Session::fail(const Error& error) {
  if (status_ != TICKTRUE_OK) return status_;
  message_ = plain_line(error.message);
  if (!error.hint.empty()) message_ += "\n  " + plain_line(error.hint);
  exit_code_ = verifier::exit_code_of(error.code);
  status_ = TICKTRUE_FAILED;
  return status_;
}

int Session::wrong_order(const std::string& what, const std::string& hint) {
  return fail(usage("tick " + number(tick_) + ": " + what, hint));
}

bool Session::refuse_in_callback(const char* what) {
  if (!in_callback_) return false;
  wrong_order(std::string(what) + ": found a call from inside " +
                  (is_gathering_ ? "a callback that gives elements" : "the save or load callback"),
              "they may call ticktrue_column and ticktrue_rows, and no other function");
  return true;
}

bool Session::can_call(const char* what) {
  if (status_ != TICKTRUE_OK) return false;
  if (phase_ != Phase::finished) return true;
  wrong_order(std::string(what) + ": found a session that is finished", "open another one");
  return false;
}

ByteView Session::setup() const {
  return comparing_ ? ByteView(comparing_->setup().setup) : ByteView(setup_);
}

void Session::set_facts() {
  if (recording_) recording_->set_facts(facts_.all());
  if (comparing_) comparing_->set_facts(facts_.all());
}

int Session::build_facts(const char* unit, const char* facts) {
  if (!can_call("build_facts") || refuse_in_callback("build_facts")) return status_;
  if (phase_ != Phase::registering)
    return wrong_order("build_facts: found facts after the first tick", "give them before the first tick");
  if (const Status status = check_name("build_facts: unit", text_of(unit)); !status) return fail(status.error());
  if (const Status status = facts_.add(text_of(unit), facts); !status) return fail(status.error());
  set_facts();
  return TICKTRUE_OK;
}

bool Session::wants_stages(const RecordedTick* recorded) const {
  if (stages_.empty()) return false;
  if (recorded != nullptr) return !recorded->stage_hashes.empty();
  return is_recording() && recording_->wants_stages(tick_);
}

int Session::stage(const char* name) {
  if (!can_call("stage") || refuse_in_callback("stage")) return status_;
  if (phase_ != Phase::inside) return wrong_order("stage: found no tick that runs", "call it after begin_tick");
  const std::string_view text = text_of(name);
  if (stages_done_ >= stages_.size() || stages_[stages_done_] != text)
    return wrong_order("stage: found " + std::string(text) + ", expected " +
                           (stages_done_ < stages_.size() ? stages_[stages_done_] : "no further one"),
                       "the stages of every tick come in the order of ticktrue_add_stage");
  ++stages_done_;
  if (!wants_stages(comparing_ ? comparing_->at(tick_) : nullptr)) return TICKTRUE_OK;
  if (const Status status = gather(); !status) return fail(status.error());
  stage_hashes_.push_back(root_hash(state_.view()));
  return TICKTRUE_OK;
}

const RecordedTick* Session::recorded() {
  return comparing_->at(tick_);
}

int Session::input(void* data, std::size_t size) {
  if (!can_call("input") || refuse_in_callback("input")) return status_;
  if (phase_ == Phase::inside)
    return wrong_order("input: found a tick that runs already, expected its inputs before begin_tick",
                       "so they are in the file before the tick runs, and a crash does not lose them");
  if (size == 0) return TICKTRUE_OK;
  if (data == nullptr) return wrong_order("input: found null, expected " + number(size) + " bytes", "");
  if (second_.is_second()) return input_of_second(data, size);
  if (!comparing_) {
    if (size > replay::input_size_max - std::min(inputs_.size(), replay::input_size_max))
      return wrong_order("input: found more than " + number(replay::input_size_max) + " bytes",
                         "spread them over several ticks");
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    inputs_.insert(inputs_.end(), bytes, bytes + size);
    return TICKTRUE_OK;
  }
  const RecordedTick* tick = recorded();
  if (tick == nullptr) {
    if (!can_go_back()) return stop(TICKTRUE_END);
    return go_back() ? input_of_second(data, size) : status_;
  }
  const std::size_t left = tick->inputs.size() - inputs_taken_;
  if (size > left) {
    comparing_->other_inputs(tick_, "recorded " + number(tick->inputs.size()) + " bytes, the program asks for " +
                                        number(inputs_taken_ + size));
    return stop(TICKTRUE_DIVERGED);
  }
  std::memcpy(data, tick->inputs.data() + inputs_taken_, size);
  inputs_taken_ += size;
  return TICKTRUE_OK;
}

int Session::mark(const char* name, std::uint64_t value, const void* caller) {
  if (phase_ != Phase::inside) return status_;
  if (marks_.is_on())
    marks_.add(name, value, caller);
  else
    has_dropped_marks_ = true;
  return status_;
}

int Session::note(const char* topic, const char* text) {
  if (!can_call("note") || refuse_in_callback("note")) return status_;
  const std::string_view name =
      topic == nullptr ? std::string_view() : std::string_view(topic, strnlen(topic, replay::topic_size_max + 1));
  if (name.empty() || name.size() > replay::topic_size_max || name.compare(0, 9, "ticktrue.") == 0)
    return wrong_order("note: topic: found \"" + std::string(name) + "\", expected 1.." +
                           number(replay::topic_size_max) + " bytes that do not begin with ticktrue.",
                       "");
  if (!is_recording() || second_.is_second()) return TICKTRUE_OK;
  if (!recording_->has_marks()) {
    has_dropped_marks_ = true;
    return TICKTRUE_OK;
  }
  if (notes_.size() >= note_count_max) return TICKTRUE_OK;
  notes_.push_back({std::string(name),
                    text == nullptr ? std::string() : std::string(text, strnlen(text, replay::note_body_size_max))});
  return phase_ == Phase::inside ? write_notes() : TICKTRUE_OK;
}

/// To be called inside a tick. With rollback, notes wait until their tick is confirmed.
int Session::write_notes() {
  if (rollback_max_ > 0) return TICKTRUE_OK;
  for (const replay::Note& note : notes_) {
    const Status status = recording_->note(note);
    if (!status && recording_failed(status.error()) != TICKTRUE_OK) return status_;
    if (!status) break;
  }
  notes_.clear();
  return TICKTRUE_OK;
}

RowNamer Session::namer() {
  return [this](std::size_t table, std::size_t row) -> std::string {
    const auto found = namers_.find(state_.schema().tables[table].name);
    if (found == namers_.end() || found->second.call == nullptr || row >= state_.row_count(table)) return "";
    char text[limits::name_size_max] = "";
    found->second.call(found->second.user, static_cast<std::uint32_t>(row), text, sizeof text);
    text[sizeof text - 1] = 0;
    return text;
  };
}

int Session::start() {
  if (!state_.is_frozen())
    if (const Status status = state_.freeze(); !status) return fail(status.error());
  if (const Status status = gather(); !status) return fail(status.error());
  if (!comparing_) {
    root_hash(state_.view(), table_hashes_);
    changes_.add(state_.view(), table_hashes_);
  }
  peers_->begin(state_.view());
  if (is_live_) return TICKTRUE_OK;
  if (recording_) {
    std::optional<Bytes> save;
    if (saves_.is_set() && !save_now(save)) return status_;
    std::optional<Bytes> shown;
    if (state_.has_shown() && !gather_shown(shown)) return status_;
    const CheckpointContents contents{save ? &*save : nullptr, shown ? &*shown : nullptr};
    const Status status = recording_->start(state_.view(), state_.whole_schema(), contents, stages_, namer());
    if (!status) return fail(status.error());
  } else {
    if (!comparing_->start(state_.view(), stages_)) return stop(TICKTRUE_FAILED);
    comparing_->note_shown_schema(state_.whole_schema());
    const Bytes* begin = comparing_->begin_save();
    if (begin != nullptr && !load_now(tick_, *begin)) return status_;
    if (!comparing_->check_begin(state_.view(), namer())) return stop(TICKTRUE_DIVERGED);
    const Bytes* save = begin != nullptr ? begin : comparing_->first_save();
    if (restores_ && save != nullptr) second_.open(tick_, *save, state_.view());
  }
  if (sync_ticks_ > 0 && !open_sync_block()) return status_;
  return TICKTRUE_OK;
}

int Session::begin_tick(double* dt) {
  if (!can_call("begin_tick") || refuse_in_callback("begin_tick")) return status_;
  if (phase_ == Phase::inside) return wrong_order("begin_tick: found a tick that runs already", "end_tick comes first");
  if (rollback_max_ > 0 && pending_.size() >= rollback_max_ && !second_.is_second())
    return wrong_order("begin_tick: found " + number(pending_.size()) + " ticks that wait for ticktrue_confirm, " +
                           "expected at most rollback_max, " + number(rollback_max_),
                       "confirm every tick whose inputs are known of all players, or raise rollback_max");
  if (phase_ == Phase::registering) {
    // The inputs of a verification come from the trace. Its columns must first be known to equal the columns here.
    if (start() != TICKTRUE_OK) return status_;
    phase_ = Phase::between;
  }
  if (comparing_ && !second_.is_second() && recorded() == nullptr && can_go_back() && !go_back()) return status_;
  if (second_.is_second()) return begin_second_tick(dt);
  dt_ = dt != nullptr ? *dt : default_dt_;
  if (!comparing_) {
    if (!replay::is_dt(dt_)) return wrong_order("begin_tick: dt: found a value that is negative or not finite", "");
    if (rollback_max_ == 0 && begin_recorded_tick(dt_, inputs_) != TICKTRUE_OK) return status_;
  } else {
    const RecordedTick* tick = recorded();
    if (tick == nullptr) return stop(TICKTRUE_END);
    if (inputs_taken_ != tick->inputs.size()) {
      comparing_->other_inputs(
          tick_, "recorded " + number(tick->inputs.size()) + " bytes, the program asked for " + number(inputs_taken_));
      return stop(TICKTRUE_DIVERGED);
    }
    if (dt == nullptr && bits_of(dt_) != bits_of(tick->dt)) {
      comparing_->other_inputs(tick_, "recorded with a dt of " + lane_text(ScalarType::f64, bits_of(tick->dt)) +
                                          " s, this program always takes " + lane_text(ScalarType::f64, bits_of(dt_)) +
                                          " s");
      return stop(TICKTRUE_DIVERGED);
    }
    dt_ = tick->dt;
    inputs_ = tick->inputs;
    if (dt != nullptr) *dt = dt_;
  }
  stages_done_ = 0;
  stage_hashes_.clear();
  phase_ = Phase::inside;
  marks_.begin_tick(mark_detail());
  compiler::store_relaxed(tick_thread_, own_thread());
  return is_recording() ? write_notes() : TICKTRUE_OK;
}

MarkDetail Session::mark_detail() const {
  if (trail_ != nullptr && trail_->wants_list(tick_)) return MarkDetail::stacks;
  return is_recording() && recording_->wants_stages(tick_) ? MarkDetail::list : MarkDetail::counts;
}

int Session::take(DoneTick done) {
  done.root_hash = root_hash(*done.state, table_hashes_);
  if (trail_ != nullptr) trail_->write(done.tick, *done.bound);
  if (!comparing_ && !is_recording()) {
    take_live_tick(done);
    return TICKTRUE_OK;
  }
  if (comparing_) {
    if (comparing_->compare(done, state_.whole_schema(), namer())) {
      take_live_tick(done);
      return TICKTRUE_OK;
    }
    if (load_count_ > 0)
      comparing_->note(
          "before this tick the load callback brought the program back: only a run from tick 0 without it tells "
          "whether "
          "the tick itself differs, or state is missing from the save");
    return stop(TICKTRUE_DIVERGED);
  }
  const Result<bool> written = recording_->end(done, namer());
  if (!written && recording_failed(written.error()) != TICKTRUE_OK) return status_;
  if (written && !*written) return stop(TICKTRUE_DIVERGED);
  take_live_tick(done);
  return TICKTRUE_OK;
}

int Session::end_tick() {
  if (!can_call("end_tick") || refuse_in_callback("end_tick")) return status_;
  if (phase_ != Phase::inside) return wrong_order("end_tick: found no tick that runs", "begin_tick comes first");
  if (stages_done_ != stages_.size())
    return wrong_order("end_tick: stage " + stages_[stages_done_] + ": found no ticktrue_stage for it in this tick",
                       "every stage is said to be done in every tick, also where it has no work");
  if (const Status status = gather(); !status) return fail(status.error());
  phase_ = Phase::between;
  compiler::store_relaxed<const void*>(tick_thread_, nullptr);
  inputs_taken_ = 0;
  const std::uint64_t tick = tick_++;
  BoundContents bound = marks_.take();
  if (probe_ && probe_->is_copy()) probe_->tick_ended(tick, state_.view(), second_.is_second());
  if (second_.is_second()) return end_second(tick);
  bound.notes = std::exchange(notes_, {});
  std::optional<Bytes> save, shown, recorded_save;
  if (is_recording() && recording_->wants_save(tick_) && !save_now(save)) return status_;
  const bool wants_shown = comparing_ || (is_recording() && recording_->wants_shown(tick));
  if (state_.has_shown() && wants_shown && !gather_shown(shown)) return status_;
  if (restores_) recorded_save = comparing_->save_behind(tick);
  const bool is_last = comparing_ && comparing_->at(tick) != nullptr && comparing_->at(tick)->is_not_finite;
  if (second_.is_open() && second_.behind() == tick && !is_last) second_.add(dt_, inputs_, state_.view());
  if (rollback_max_ == 0) {
    const CheckpointContents contents{save ? &*save : nullptr, shown ? &*shown : nullptr};
    DoneTick done{tick, dt_, inputs_, stage_hashes_, &state_.view(), contents, &bound};
    const int status = take(done);
    inputs_.clear();
    confirmed_ = tick_;
    return status == TICKTRUE_OK ? after_first_run(std::move(recorded_save)) : status;
  }
  PendingTick& pending = pending_.emplace_back();
  pending.tick = tick;
  pending.dt = dt_;
  pending.inputs = std::move(inputs_);
  inputs_.clear();
  pending.stage_hashes = stage_hashes_;
  pending.state = KeptState(state_.view());
  pending.save = std::move(save);
  pending.shown = std::move(shown);
  pending.bound = std::move(bound);
  return after_first_run(std::move(recorded_save));
}

int Session::rewind(std::uint64_t tick) {
  if (!can_call("rewind") || refuse_in_callback("rewind")) return status_;
  if (rollback_max_ == 0)
    return wrong_order("rewind: found a session without rollback", "set rollback_max in the options");
  if (phase_ == Phase::inside)
    return wrong_order("rewind: found a tick that runs, expected none", "end_tick comes first: its result is dropped");
  if (tick > tick_)
    return wrong_order("rewind: found tick " + number(tick) + ", expected at most the ticks done, " + number(tick_),
                       "");
  if (comparing_ && second_.is_second() && tick >= second_.first()) {
    tick_ = tick;  // the recorded inputs come again, in the second run as in the first
    inputs_taken_ = 0;
    return TICKTRUE_OK;
  }
  if (tick < confirmed_ && second_.is_second() && tick < second_.first())
    return wrong_order("rewind: found tick " + number(tick) +
                           ", expected at least the tick to which load brought the " + "program, " +
                           number(second_.first()),
                       "behind load, a program has no older states of its own");
  if (tick < confirmed_)
    return wrong_order(
        "rewind: found tick " + number(tick) + ", expected at least the ticks confirmed, " + number(confirmed_),
        "a confirmed tick is final: confirm a tick when the inputs of all players are known for it");
  // Without recorded inputs, the program now knows inputs that these ticks did not run with.
  if (second_.is_open() && !second_.is_second() && (comparing_ || tick >= second_.first()))
    second_.drop_from(tick);
  else
    second_.close();
  while (!pending_.empty() && pending_.back().tick >= tick) pending_.pop_back();
  tick_ = tick;
  inputs_.clear();
  notes_.clear();
  inputs_taken_ = 0;
  return TICKTRUE_OK;
}

int Session::confirm(std::uint64_t tick) {
  if (!can_call("confirm") || refuse_in_callback("confirm")) return status_;
  if (tick > ticks_done())
    return wrong_order(
        "confirm: found tick " + number(tick) + ", expected at most the ticks done, " + number(ticks_done()),
        "confirm(n) says that the first n ticks are final");
  return confirm_pending(tick);
}

int Session::confirm_pending(std::uint64_t tick) {
  while (!pending_.empty() && pending_.front().tick < tick) {
    const PendingTick& pending = pending_.front();
    if (begin_recorded_tick(pending.dt, pending.inputs) != TICKTRUE_OK) return status_;
    const CheckpointContents contents{pending.save ? &*pending.save : nullptr,
                                      pending.shown ? &*pending.shown : nullptr};
    if (take({pending.tick, pending.dt, pending.inputs, pending.stage_hashes, &pending.state.view(), contents,
              &pending.bound}) != TICKTRUE_OK)
      return status_;
    confirmed_ = pending.tick + 1;
    pending_.pop_front();
  }
  return TICKTRUE_OK;
}

int Session::begin_recorded_tick(double dt, ByteView inputs) {
  if (!is_recording()) return TICKTRUE_OK;
  const Status status = recording_->begin(dt, inputs);
  return status ? TICKTRUE_OK : recording_failed(status.error());
}

int Session::recording_failed(const Error& error) {
  if (error.code != ErrorCode::io) return fail(error);
  is_recording_lost_ = true;
  message_ = plain_line(error.message) + ": recording ends, the game goes on";
  if (!error.hint.empty()) message_ += "\n  " + plain_line(error.hint);
  exit_code_ = verifier::exit_code_of(error.code);
  return TICKTRUE_OK;
}

int Session::finish_recording() {
  if (is_recording_lost_) return exit_code_;
  if (!recording_->is_started()) {
    if (status_ == TICKTRUE_OK)
      fail(usage(path_ + ": the session ends before its first tick: nothing was recorded",
                 "begin_tick and end_tick belong into the loop"));
    return exit_code_;
  }
  const bool is_whole = status_ != TICKTRUE_FAILED;
  if (is_whole && !second_.is_second() && phase_ == Phase::inside)
    recording_->warnings.push_back("tick " + number(tick_) + " was begun and not ended: it is not in the trace");
  if (is_whole && !pending_.empty())
    recording_->warnings.push_back("ticks " + number(pending_.front().tick) + ".." + number(pending_.back().tick) +
                                   " were never confirmed and are not in the trace");
  if (!calls_warning_.empty()) recording_->warnings.push_back(calls_warning_);
  if (has_dropped_marks_)
    recording_->warnings.push_back("marks and notes were not stored: set TICKTRUE_MARKS in the flags of the options");
  const std::string first_line = message_.substr(0, std::min(message_.find('\n'), limits::name_size_max));
  const Status status = recording_->finish(is_whole ? replay::EndReason::complete : replay::EndReason::interrupted,
                                           is_whole ? "" : first_line);
  if (!status) fail(status.error());
  if (status_ == TICKTRUE_FAILED) return exit_code_;
  if (!recording_->is_finite() || recording_->has_finding()) return verifier::exit_finding;
  return sync_ticks_ > 0 && second_count_ == 0 ? verifier::exit_incomplete : verifier::exit_ok;
}

int Session::finish() {
  if (phase_ == Phase::finished || refuse_in_callback("finish")) return exit_code_;
  if (probe_) probe_->finish(ticks_done());
  if (recording_) {
    judge_second_runs();
    exit_code_ = finish_recording();
  } else if (comparing_) {
    const bool is_wrong_call = status_ == TICKTRUE_FAILED && !message_.empty();
    // Pending ticks are final now: no rollback can follow.
    if (!is_wrong_call && status_ != TICKTRUE_DIVERGED) confirm_pending(ticks_done());
    comparing_->finish(ticks_done());
    judge_second_runs();
    if (!is_wrong_call) exit_code_ = comparing_->report().exit_code();
  }
  if (peers_ && !comparing_) report_peers();
  phase_ = Phase::finished;
  return exit_code_;
}

std::string Session::report_text() const {
  if (is_live_ || is_recording_lost_) return live_text();
  if (!message_.empty()) return "";
  if (comparing_) return verifier::report_text(comparing_->report());
  return recording_ ? recording_->text() + desync_text_ : "";
}

std::string Session::report_json() const {
  if (is_live_ || is_recording_lost_) return live_json();
  if (!message_.empty()) return "";
  if (comparing_) return verifier::report_json({&comparing_->report(), 1}, false);
  return recording_ ? recording_->json(desync_json_) : "";
}

std::string Session::result_json() const {
  if (recording_ || is_live_) return "";
  if (message_.empty()) return report_json();
  verifier::Report failed;
  failed.file = path_;
  failed.verdict = verifier::Verdict::error;
  failed.reason = message_.substr(0, message_.find('\n'));
  return verifier::report_json({&failed, 1}, false);
}

}  // namespace ticktrue::capi
