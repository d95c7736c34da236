// Delta debugging over the ticks and inputs of a plug-in's session.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/foreign_session.h"

#include <algorithm>

#include "replay/recorder.h"
#include "replay/trace_reader.h"
#include "tool/experiment/ddmin.h"
#include "tool/session/session.h"
#include "tool/study/table.h"

namespace ticktrue::reduce {
namespace {

using Indices = std::vector<std::size_t>;

class ForeignSource : public replay::InputSource {
 public:
  explicit ForeignSource(const ForeignSession& session) : session_(session) {}
  Result<std::optional<TickInput>> next(std::uint64_t tick) override {
    if (tick >= session_.ticks.size()) return std::optional<TickInput>();
    const ForeignTick& at = session_.ticks[tick];
    return std::optional(TickInput{at.dt, at.inputs});
  }
  bool repeatable() const override { return true; }

 private:
  const ForeignSession& session_;
};

class ForeignReducer {
 public:
  ForeignReducer(const ForeignSession& session, const SimulationInfo& recorder, const TraceJudge& judge,
                 const std::string& folder, const ReduceOptions& options)
      : session_(session), recorder_(recorder), judge_(judge), trace_(folder + "/session.ttr"), options_(options) {}

  Result<ForeignResult> run() {
    const auto first = examine(session_);
    if (!first) return first.error();
    if (!*first)
      return Error{ErrorCode::usage,
                   "reduce: the session does not fail: found nothing in " + std::to_string(session_.ticks.size()) +
                       " ticks, expected a failure",
                   ""};
    first_ = last_ = **first;
    end_at_failure();
    leave_out_inputs();
    leave_out_ticks();
    return ForeignResult{std::move(session_), std::move(first_), std::move(last_), run_count_, ended_early_};
  }

 private:
  Result<std::optional<Failure>> examine(const ForeignSession& session) {
    ++run_count_;
    if (const Status recorded = record_foreign(session, recorder_, trace_); !recorded) return recorded.error();
    return judge_(trace_);
  }

  bool fails_alike(const ForeignSession& candidate) {
    if (!ended_early_ && options_.stops && options_.stops()) ended_early_ = true;
    if (ended_early_ || candidate.ticks.empty()) return false;
    const auto found = examine(candidate);
    return found && *found && is_same(first_, **found, options_.is_loose);
  }

  void end_at_failure() {
    session_.ticks.resize(std::min<std::size_t>(session_.ticks.size(), static_cast<std::size_t>(last_.tick) + 1));
  }

  void leave_out_inputs() {
    Indices with_inputs;
    for (std::size_t i = 0; i < session_.ticks.size(); ++i)
      if (!session_.ticks[i].inputs.empty()) with_inputs.push_back(i);
    const ForeignSession before = session_;
    const auto with = [&](const Indices& some) {
      ForeignSession fewer = before;
      for (const std::size_t i : with_inputs) fewer.ticks[i].inputs.clear();
      for (const std::size_t i : some) fewer.ticks[with_inputs[i]].inputs = before.ticks[with_inputs[i]].inputs;
      return fewer;
    };
    take(with(soak::ddmin(with_inputs.size(), [&](const Indices& some) { return fails_alike(with(some)); })));
  }

  void leave_out_ticks() {
    const ForeignSession before = session_;
    const auto with = [&](const Indices& some) {
      ForeignSession fewer = before;
      fewer.ticks.clear();
      for (const std::size_t i : some) fewer.ticks.push_back(before.ticks[i]);
      return fewer;
    };
    take(with(soak::ddmin(before.ticks.size(), [&](const Indices& some) { return fails_alike(with(some)); })));
  }

  void take(ForeignSession found) {
    const auto failure = examine(found);
    if (!failure || !*failure || !is_same(first_, **failure, options_.is_loose)) return;
    last_ = **failure;
    session_ = std::move(found);
    end_at_failure();
  }

  ForeignSession session_;
  const SimulationInfo& recorder_;
  const TraceJudge& judge_;
  std::string trace_;
  const ReduceOptions& options_;
  Failure first_;
  Failure last_;
  std::size_t run_count_ = 0;
  bool ended_early_ = false;
};

}  // namespace

std::size_t ForeignSession::input_count() const {
  return static_cast<std::size_t>(
      std::count_if(ticks.begin(), ticks.end(), [](const ForeignTick& tick) { return !tick.inputs.empty(); }));
}

Result<ForeignSession> read_foreign_session(const std::string& path, std::optional<std::uint64_t> tick_count) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(path);
  if (!reader) return reader.error();
  if (const Status whole = reader->check_from_start(); !whole) return whole.error();
  ForeignSession session;
  session.setup = reader->setup();
  while (session.ticks.size() < tick_count.value_or(UINT64_MAX)) {
    const auto& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    if (const auto* record = std::get_if<replay::TickRecord>(&item))
      session.ticks.push_back({record->dt, Bytes(record->inputs.begin(), record->inputs.end())});
  }
  return session;
}

Result<ForeignResult> reduce_foreign(const ForeignSession& session, const SimulationInfo& recorder,
                                     const TraceJudge& judge, const std::string& folder, const ReduceOptions& options) {
  return ForeignReducer(session, recorder, judge, folder, options).run();
}

Status record_foreign(const ForeignSession& session, const SimulationInfo& recorder, const std::string& path) {
  const auto made = recorder.make(session.setup.setup);
  if (!made) return made.error();
  replay::TraceSetup setup = session.setup;
  setup.detail = replay::Detail::full;
  setup.full_first = 0;
  setup.full_last = session.ticks.size();
  setup.features = 0;
  setup.stage_interval = 0;
  setup.whole_schema.reset();
  setup.schema = *(*made)->state().schema;
  setup.stages.assign((*made)->stage_names().begin(), (*made)->stage_names().end());
  ForeignSource source(session);
  replay::RecordOptions options;
  options.writer.overwrite = true;
  options.writer.sync = false;
  const auto recorded = replay::record(**made, source, path, setup, tool::make_build_facts(), options);
  if (!recorded) return recorded.error();
  return {};
}

std::string foreign_inputs_text(const ForeignSession& session) {
  constexpr const char* digits = "0123456789abcdef";
  std::string text;
  double dt = session.setup.dt;
  for (std::size_t tick = 0; tick < session.ticks.size(); ++tick) {
    const ForeignTick& at = session.ticks[tick];
    if (at.inputs.empty() && at.dt == dt) continue;
    text += "{\"tick\":" + std::to_string(tick) + ",\"bytes\":\"";
    for (const std::uint8_t byte : at.inputs) {
      text += digits[byte >> 4];
      text += digits[byte & 15];
    }
    text += "\"";
    if (at.dt != dt) text += ",\"dt\":" + tool::full_number(at.dt);
    text += "}\n";
    dt = at.dt;
  }
  return text;
}

}  // namespace ticktrue::reduce
