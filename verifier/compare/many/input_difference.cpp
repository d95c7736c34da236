// Groups traces by the inputs of a tick, and searches moved inputs in later ticks.
// SPDX-License-Identifier: MIT
#include "verifier/compare/many/input_difference.h"

#include <algorithm>

#include "base/assert.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {
namespace {

constexpr std::uint64_t moved_ticks_max = 64;  // an input that comes later is a different input
constexpr std::size_t bytes_shown_max = 32;

using Items = std::vector<std::string>;

bool same_inputs(const replay::TickRecord& a, const replay::TickRecord& b) {
  return bits_of(a.dt) == bits_of(b.dt) &&
         std::equal(a.inputs.begin(), a.inputs.end(), b.inputs.begin(), b.inputs.end());
}

/// The elements that `a` has more often than `b`, in the order of `a`.
Items without(const Items& a, Items b) {
  Items left;
  for (const std::string& item : a) {
    const auto same = std::find(b.begin(), b.end(), item);
    if (same == b.end())
      left.push_back(item);
    else
      b.erase(same);
  }
  return left;
}

bool has_all(const Items& items, const Items& wanted) {
  return without(wanted, items).empty();
}

const replay::TickRecord* record_of(std::span<const PresentTick> present, std::size_t trace) {
  for (const PresentTick& one : present)
    if (one.trace == trace) return one.record;
  return nullptr;
}

InputChange change_of(const OddInputs& odd, bool same_bytes) {
  if (odd.missing.empty() && odd.extra.empty()) return same_bytes ? InputChange::dt : InputChange::order;
  if (odd.extra.empty()) return InputChange::missing;
  return odd.missing.empty() ? InputChange::extra : InputChange::other;
}

}  // namespace

const InputChangeInfo& input_change_info(InputChange change) {
  const auto found = std::find_if(input_changes.begin(), input_changes.end(),
                                  [&](const InputChangeInfo& info) { return info.change == change; });
  TICKTRUE_ASSERT(found != input_changes.end());
  return *found;
}

std::string input_hex(ByteView bytes) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text;
}

std::string input_bytes_text(ByteView bytes) {
  if (bytes.empty()) return "none";
  if (bytes.size() <= bytes_shown_max) return input_hex(bytes);
  return input_hex(bytes.first(bytes_shown_max)) + "... (" + std::to_string(bytes.size()) + " bytes)";
}

std::string InputComparer::lines(std::uint64_t tick, ByteView bytes) const {
  return simulation_ != nullptr ? simulation_->inputs_text(tick, bytes) : "";
}

/// The tick number in each line is that of the finding. So the same input has the same text in each tick.
Items InputComparer::items(ByteView bytes) const {
  if (bytes.empty()) return {};
  Items found = split_lines(lines(found_->tick, bytes));
  if (found.empty()) found.push_back(input_hex(bytes));
  return found;
}

bool InputComparer::compare(std::uint64_t tick, std::span<const PresentTick> present) {
  const bool same = std::all_of(present.begin(), present.end(), [&](const PresentTick& one) {
    return same_inputs(*present.front().record, *one.record);
  });
  if (same) return true;
  TraceGroup traces;
  for (const PresentTick& one : present) traces.push_back(one.trace);
  const TraceGroups who = group_traces(traces, [&](std::size_t i, std::size_t j) {
    return same_inputs(*record_of(present, i), *record_of(present, j));
  });
  for (const std::size_t trace : who.odd())
    if (!from_[trace]) from_[trace] = tick;
  if (!found_)
    describe(tick, present, who);
  else if (who.has_majority() && tick - found_->tick <= moved_ticks_max)
    follow(tick, present, record_of(present, who.groups.front().front())->inputs);
  return false;
}

void InputComparer::describe(std::uint64_t tick, std::span<const PresentTick> present, const TraceGroups& who) {
  found_ = InputsFinding{tick, {}, who, {}};
  for (const TraceGroup& group : who.groups) {
    const replay::TickRecord& record = *record_of(present, group.front());
    found_->groups.push_back(
        {group, record.dt, Bytes(record.inputs.begin(), record.inputs.end()), lines(tick, record.inputs)});
  }
  const Bytes& expected = found_->groups.front().bytes;
  const Items expected_items = items(expected);
  for (const std::size_t trace : who.odd()) {
    const ByteView got = record_of(present, trace)->inputs;
    OddInputs odd;
    odd.trace = trace;
    odd.missing = without(expected_items, items(got));
    odd.extra = without(items(got), expected_items);
    odd.change = change_of(odd, std::equal(got.begin(), got.end(), expected.begin(), expected.end()));
    found_->odd.push_back(std::move(odd));
  }
}

/// Searches a later tick for the missing and extra inputs. `most`: the inputs of the majority in this tick.
void InputComparer::follow(std::uint64_t tick, std::span<const PresentTick> present, ByteView most) {
  const Items there = items(most);
  for (OddInputs& odd : found_->odd) {
    const replay::TickRecord* record = record_of(present, odd.trace);
    if (record == nullptr) continue;
    const Items here = items(record->inputs);
    if (!odd.later && !odd.missing.empty() && has_all(here, odd.missing) && !has_all(there, odd.missing))
      odd.later = tick;
    if (!odd.before && !odd.extra.empty() && has_all(there, odd.extra) && !has_all(here, odd.extra)) odd.before = tick;
  }
}

}  // namespace ticktrue::verifier
