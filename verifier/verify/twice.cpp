// Mode `twice`: whether a simulation is reproducible on this machine.
// SPDX-License-Identifier: MIT
#include "verifier/verify/twice.h"

#include <utility>
#include <variant>

#include "verifier/locate/schema_difference.h"

namespace ticktrue::verifier {
namespace {

class TwiceWalk {
 public:
  TwiceWalk(const WalkContext& context, TraceSource& source) : context_(context), source_(source) {}

  WalkResult run(const Start& start) {
    Findings& findings = result_.findings;
    result_.tick = start.tick;
    result_.time_s = start.time_s;
    first_ = begin_at(context_, start, findings);
    if (first_ != nullptr) second_ = begin_at(context_, start, findings);
    if (second_ == nullptr) return std::move(result_);
    watch_.begin(first_->state());
    findings.notes.push_back("two runs here were compared with each other, not with the recorded hashes");
    source_.rewind();
    if (same_states(stage_setup, "two simulations made here begin with different states", {})) result_.end = walk_on();
    if (result_.end == WalkEnd::end_of_trace) result_.trace_end = TraceEnd{source_.tail(), ""};
    result_.changed = watch_.changed();
    return std::move(result_);
  }

 private:
  WalkEnd walk_on() {
    for (;;) {
      if (context_.options.to && result_.tick > *context_.options.to) return WalkEnd::reached_stop;
      const replay::TraceReader::Item& item = source_.next();
      if (std::holds_alternative<std::monostate>(item)) return WalkEnd::end_of_trace;
      const auto* record = std::get_if<replay::TickRecord>(&item);
      if (record != nullptr && !run_tick({record->dt, record->inputs})) return WalkEnd::stopped;
    }
  }

  bool run_tick(const TickInput& input) {
    const std::string tick = "tick " + std::to_string(result_.tick);
    if (const Status accepted = first_->accept(input); !accepted) {
      result_.findings.decide(Verdict::not_comparable,
                              tick + ": recorded inputs are refused here: " + accepted.error().message,
                              "the bytes are intact: this build takes other inputs than the one that recorded them");
      return false;
    }
    if (!second_->accept(input)) {
      result_.findings.not_reproducible(tick + ": inputs one run takes are refused by the other");
      return false;
    }
    if (!steps(input, tick)) return false;
    ++result_.ticks_compared;
    result_.last_tick_s = result_.time_s;
    if (!same_states("", "not looked for: two runs here differ", input.inputs)) return false;
    watch_.update(first_->state());
    if (const auto place = find_non_finite(first_->state())) {
      result_.findings.notes.push_back(
          tick + " is not finite in both runs: " + place_text(*first_->state().schema, *place, names_of(*first_)));
      result_.findings.non_finite = find_non_finite_of(*first_, result_.tick);
      result_.findings.decide(Verdict::diverged, tick + ": a value is not finite: nothing behind it can be compared");
      return false;
    }
    result_.time_s += input.dt;
    result_.last_tick_s = result_.time_s;
    if (context_.options.on_compared) context_.options.on_compared(result_.last_tick_s);
    ++result_.tick;
    if (context_.options.progress) context_.options.progress(result_.tick);
    return true;
  }

  /// False: the tick failed in one run or in both.
  bool steps(const TickInput& input, const std::string& tick) {
    const Status first = first_->step(input, nullptr);
    const Status second = second_->step(input, nullptr);
    if (first && second) return true;
    const Error& error = first ? second.error() : first.error();
    if (first.has_value() == second.has_value())
      result_.findings.undone(error);
    else
      result_.findings.not_reproducible(tick + ": one run does it, the other does not: " + error.message);
    return false;
  }

  bool same_states(std::string_view stage, const char* note, ByteView inputs) {
    const std::uint64_t a = root_hash(first_->state());
    const std::uint64_t b = root_hash(second_->state());
    result_.root_hash = a;
    if (a == b) return true;
    Divergence divergence;
    divergence.tick = result_.tick;
    divergence.time_s = result_.time_s;
    if (!stage.empty()) divergence.stage = std::string(stage);
    divergence.stage_note = note;
    divergence.expected_root = a;
    divergence.got_root = b;
    divergence.inputs = first_->inputs_text(result_.tick, inputs);
    Bytes image_a, image_b;
    encode_image(first_->state(), image_a);
    encode_image(second_->state(), image_b);
    if (!first_schema_difference(context_.setup.schema, *first_->state().schema, Ranges::any))
      describe_lanes(context_, *second_, image_a, image_b, divergence, result_.findings);
    result_.findings.not_reproducible("two runs here differ from tick " + std::to_string(result_.tick) + " on");
    result_.findings.divergence = std::move(divergence);
    return false;
  }

  const WalkContext& context_;
  TraceSource& source_;
  WalkResult result_;
  std::unique_ptr<Simulation> first_;
  std::unique_ptr<Simulation> second_;
  ChangeWatch watch_;
};

}  // namespace

WalkResult walk_twice(const WalkContext& context, TraceSource& source, const Start& start) {
  return TwiceWalk(context, source).run(start);
}

}  // namespace ticktrue::verifier
