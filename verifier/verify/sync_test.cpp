// Saves, brings back, and compares each tick of the second run with the first.
// SPDX-License-Identifier: MIT
#include "verifier/verify/sync_test.h"

#include <utility>

#include "verifier/locate/locate.h"

namespace ticktrue::verifier {

const char* sync_hint(BroughtBackBy by) {
  return by == BroughtBackBy::save ? second_run_hint
                                   : "something that these ticks read is in no column, or load does not restore it (a "
                                     "static, a cache, a counter, a generator)";
}

bool SyncTest::begin(std::uint64_t tick, double time_s) {
  tick_ = tick;
  time_s_ = time_s;
  return open();
}

bool SyncTest::add(const TickInput& input) {
  ++tick_;
  time_s_ += input.dt;
  if (!ticks_.is_open()) return open();
  ticks_.add(input.dt, Bytes(input.inputs.begin(), input.inputs.end()), simulation_.state());
  const bool is_full = ticks_.behind() - ticks_.first() >= interval_ || !ticks_.has_room();
  return !is_full || run_again();
}

bool SyncTest::finish() {
  return !ticks_.is_open() || ticks_.behind() == ticks_.first() || run_again();
}

/// The next ticks run twice, where the simulation can be brought back to its present state.
bool SyncTest::open() {
  begin_s_ = time_s_;
  if (by_ == BroughtBackBy::image) {
    Bytes image;
    encode_image(simulation_.state(), image);
    ticks_.open(tick_, std::move(image), simulation_.state());
    return true;
  }
  Result<std::optional<Bytes>> saved = simulation_.save(tick_);
  if (!saved) return fail(tick_, saved.error().message, nullptr);
  if (*saved)
    ticks_.open(tick_, std::move(**saved), simulation_.state());
  else
    ++missing_count_;
  return true;
}

/// Hidden state of period p is in step again behind p ticks. So every other second run, and the first one, begins
/// twice: its first tick, back again, then all ticks.
bool SyncTest::run_again() {
  const std::uint64_t first = ticks_.first(), behind = ticks_.behind();
  const bool begins_twice = run_count_++ % 2 == 0 && behind - first > 1;
  if (begins_twice && (!bring_back() || !step_again(first))) return false;
  if (!bring_back()) return false;
  for (std::uint64_t tick = first; tick < behind; ++tick)
    if (!step_again(tick)) return false;
  tick_count_ += behind - first;
  ticks_.close();
  return open();
}

bool SyncTest::bring_back() {
  const std::uint64_t first = ticks_.first();
  const bool by_save = by_ == BroughtBackBy::save;
  last_load_ = first;
  time_s_ = begin_s_;
  const Status loaded = by_save ? simulation_.load_saved(first, ticks_.save()) : simulation_.load(ticks_.save());
  if (!loaded)
    return fail(first, "its own state after " + std::to_string(first) + " ticks is refused: " + loaded.error().message,
                nullptr, stage_load);
  if (ticks_.state().is_same(simulation_.state())) return true;
  return fail(first, "load does not bring back the state at tick " + std::to_string(first), &ticks_.state(),
              stage_load);
}

bool SyncTest::step_again(std::uint64_t tick) {
  const FirstRunTick& first = ticks_.at(tick);
  const TickInput input{first.dt, first.inputs};
  Status did = simulation_.accept(input);
  if (did) did = simulation_.step(input, nullptr);
  if (!did) return fail(tick, "tick " + std::to_string(tick) + " cannot run again: " + did.error().message, nullptr);
  if (!first.is_same(simulation_.state()))
    return fail(tick,
                "tick " + std::to_string(tick) + " ended in two states: the second run began with the " +
                    (by_ == BroughtBackBy::save ? "save" : "state") + " of tick " + std::to_string(ticks_.first()),
                first.state ? &*first.state : nullptr);
  time_s_ += input.dt;
  return true;
}

bool SyncTest::fail(std::uint64_t tick, std::string reason, const KeptState* first, std::string_view stage) {
  SyncFinding& finding = finding_.emplace();
  finding.begin = ticks_.is_open() ? ticks_.first() : tick;
  finding.reason = std::move(reason);
  finding.hint = sync_hint(by_);
  const RowNamer names = [this](std::size_t table, std::size_t row) { return simulation_.row_name(table, row); };
  if (first != nullptr) finding.divergence = between_states(first->view(), simulation_.state(), names, row_count_max_);
  finding.divergence.tick = tick;
  finding.divergence.time_s = time_s_;
  if (!stage.empty()) finding.divergence.stage = std::string(stage);
  finding.divergence.stage_note = stage.empty() ? "expected: the first run; got: the second run, behind load"
                                                : "expected: the state that was saved; got: the state behind load";
  return false;
}

}  // namespace ticktrue::verifier
