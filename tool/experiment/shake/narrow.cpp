// Finds the shortest sufficient prefix of all calls, then tries its last call alone. If that is not enough, runs ddmin.
// SPDX-License-Identifier: MIT
//
// The calls before the first changed call are equal in every run of a repeatable program. Calls therefore keep their
// numbers while the prefix is narrowed.
#include "tool/experiment/shake/narrow.h"

#include <algorithm>
#include <vector>

#include "tool/experiment/ddmin.h"

namespace ticktrue::shake {
namespace {

using shim::CallRange;

std::string place_text(std::uint64_t position) {
  if (position == 0) return "before the first tick";
  if (position % 2 == 1) return "of tick " + std::to_string((position - 1) / 2);
  return "after tick " + std::to_string(position / 2 - 1);
}

class Narrower {
 public:
  Narrower(Launcher& launcher, Conditions guilty, const NarrowOptions& options)
      : launcher_(launcher), guilty_(std::move(guilty)), options_(options) {}

  /// Whether changing these calls changes the run. Also false if no time is left; the search then ends early.
  bool is_other(const std::vector<CallRange>& ranges) {
    Conditions conditions = guilty_;
    set_ranges(conditions.settings, ranges);
    return is_other_run(conditions);
  }

  bool is_other_in_ticks(std::uint64_t first, std::uint64_t last) {
    Conditions conditions = guilty_;
    conditions.settings.tick_first = first;
    conditions.settings.tick_last = last;
    return is_other_run(conditions);
  }

  /// Whether the run under these conditions differs. Also false if no time is left.
  bool is_other_run(const Conditions& conditions) {
    if (!options_.goes_on()) {
      has_ended_early_ = true;
      return false;
    }
    const Result<Run> run = launcher_.run(conditions);
    return run && signature(run->outcome) != options_.baseline;
  }

  bool has_ended_early() const { return has_ended_early_; }

  Result<Run> record(const std::vector<CallRange>& ranges, shim::Group group, CallRange logged) {
    Conditions conditions = guilty_;
    set_ranges(conditions.settings, ranges);
    conditions.settings.logged_group = static_cast<std::uint32_t>(group);
    conditions.settings.logged = logged;
    return launcher_.run(conditions);
  }

 private:
  static void set_ranges(shim::Settings& settings, const std::vector<CallRange>& ranges) {
    settings.call_range_count =
        static_cast<std::uint32_t>(std::min<std::size_t>(ranges.size(), shim::call_range_count_max));
    for (std::uint32_t i = 0; i < settings.call_range_count; ++i) settings.call_ranges[i] = ranges[i];
  }

  Launcher& launcher_;
  Conditions guilty_;
  const NarrowOptions& options_;
  bool has_ended_early_ = false;
};

/// The smallest n in (low, high] with holds(n). Requires: holds(high), not holds(low).
template <typename Holds>
std::uint64_t least(std::uint64_t low, std::uint64_t high, Holds&& holds) {
  while (high - low > 1) {
    const std::uint64_t middle = low + (high - low) / 2;
    (holds(middle) ? high : low) = middle;
  }
  return high;
}

std::vector<CallRange> ranges_of(const std::vector<std::size_t>& kept, std::uint64_t first) {
  std::vector<CallRange> ranges;
  for (const std::size_t index : kept) {
    const std::uint64_t number = first + index;
    if (!ranges.empty() && ranges.back().end == number)
      ++ranges.back().end;
    else
      ranges.push_back({number, number + 1});
  }
  return ranges;
}

Cause no_cause(const std::string& why) {
  Cause cause;
  cause.failure = why;
  return cause;
}

/// The call that a run recorded.
Cause cause_of(const Run& run) {
  const shim::CallRecord& record = run.page.records[0];
  Cause cause;
  cause.function = shim::functions[std::min<std::size_t>(record.function, shim::function_count - 1)].name;
  cause.number = record.number;
  cause.nth = record.nth;
  cause.position = record.position;
  cause.size = record.size;
  cause.site = call_site(run.page, record);
  return cause;
}

Cause narrow_calls(Narrower& runs, const Perturbation& perturbation, const Outcome& outcome) {
  const std::uint64_t count = std::max<std::uint64_t>(outcome.calls_of(perturbation.group), 1);
  if (runs.is_other({{0, 0}})) return no_cause("it does not repeat: the run is another one without any changed call");
  if (!runs.is_other({{0, count}})) return no_cause(runs.has_ended_early() ? "no time was left" : "it does not repeat");
  const std::uint64_t end = least(0, count, [&](std::uint64_t n) { return runs.is_other({{0, n}}); });
  std::vector<CallRange> ranges{{end - 1, end}};
  std::uint64_t needed = 1;
  if (!runs.is_other(ranges)) {
    // Several calls matter together, and the last of them is known. Finds the shortest sufficient range that ends
    // there.
    const std::uint64_t dropped = end - least(1, end, [&](std::uint64_t length) {
                                    return runs.is_other({{end - length, end}});
                                  });
    ranges = {{dropped, end}};
    needed = end - dropped;
    if (needed <= shim::call_range_count_max / 2 && !runs.has_ended_early()) {
      const auto kept = soak::ddmin(static_cast<std::size_t>(needed), [&](const auto& indices) {
        return !indices.empty() && runs.is_other(ranges_of(indices, dropped));
      });
      if (!kept.empty()) {
        ranges = ranges_of(kept, dropped);
        needed = kept.size();
      }
    }
  }
  const std::uint64_t last = ranges.back().end - 1;
  const Result<Run> recorded = runs.record(ranges, perturbation.group, {last, last + 1});
  if (!recorded || recorded->page.record_count == 0) return no_cause("the call was not made again");
  Cause cause = cause_of(*recorded);
  cause.call_count = needed;
  if (runs.has_ended_early()) cause.effect = "narrowed as far as the time went";
  return cause;
}

Cause narrow_ticks(Narrower& runs, const Outcome& outcome) {
  constexpr std::uint64_t tick_count_max = std::uint64_t{1} << 40;
  const std::uint64_t end = outcome.kind == OutcomeKind::diverged ? outcome.tick + 1 : tick_count_max;
  if (!runs.is_other_in_ticks(0, end))
    return no_cause(runs.has_ended_early() ? "no time was left" : "it does not repeat");
  Cause cause;
  cause.is_ticks = true;
  cause.tick_last =
      runs.is_other_in_ticks(0, 0) ? 0 : least(0, end, [&](std::uint64_t n) { return runs.is_other_in_ticks(0, n); });
  const std::uint64_t length =
      runs.is_other_in_ticks(cause.tick_last, cause.tick_last) ? 0 : least(0, cause.tick_last, [&](std::uint64_t n) {
        return runs.is_other_in_ticks(cause.tick_last - n, cause.tick_last);
      });
  cause.tick_first = cause.tick_last - length;
  return cause;
}

Cause narrow_kernels(Launcher& launcher, Narrower& runs, const Conditions& guilty) {
  Cause cause;
  cause.dispatch =
      narrow_dispatch(launcher, guilty, [&](const Conditions& conditions) { return runs.is_other_run(conditions); });
  if (cause.dispatch.features.empty())
    return no_cause(runs.has_ended_early() ? "no time was left" : "it does not repeat");
  return cause;
}

Cause cause_of(const Run& run, const shim::LibmCall& call) {
  Cause cause;
  cause.function = shim::functions[std::min<std::size_t>(call.function, shim::function_count - 1)].name;
  cause.number = call.number;
  cause.nth = call.nth;
  cause.position = call.position;
  cause.site = call_site(run.page, call.module, call.offset);
  return cause;
}

/// The plain program, but with this one result changed by an ulp to the result of the other processor.
Conditions one_result(const shim::LibmCall& here, const shim::LibmCall& there) {
  constexpr std::uint32_t up = 1;
  constexpr std::uint32_t down = 2;
  Conditions conditions;
  conditions.settings.libm_mode = there.result > here.result ? up : down;
  conditions.settings.call_range_count = 1;
  conditions.settings.call_ranges[0] = {here.number, here.number + 1};
  return conditions;
}

/// Finds the first libm result that differs and matters. Compares the logs of a plain run and of a run under `guilty`.
/// A result that a later rounding removes does not matter.
Cause compare_libm(Launcher& launcher, const Conditions& guilty, const NarrowOptions& options) {
  constexpr int tried_max = 24;
  Conditions plain;
  plain.settings.libm_log = 1;
  Conditions changed = guilty;
  changed.settings.libm_log = 1;
  const Result<Run> here = launcher.run(plain);
  const Result<Run> there = launcher.run(changed);
  if (!here || !there) return no_cause("the log of libm cannot be written");
  const std::size_t count = std::min(here->libm_calls.size(), there->libm_calls.size());
  std::optional<Cause> last;
  int tried = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const shim::LibmCall& a = here->libm_calls[i];
    const shim::LibmCall& b = there->libm_calls[i];
    if (a.function != b.function || a.arguments != b.arguments) break;
    if (a.result == b.result) continue;
    last = cause_of(*here, a);
    const bool is_one_ulp = a.result + 1 == b.result || b.result + 1 == a.result;
    if (!is_one_ulp || ++tried > tried_max || !options.goes_on()) continue;
    const Result<Run> alone = launcher.run(one_result(a, b));
    if (alone && signature(alone->outcome) != options.baseline) return *last;
  }
  return last ? *last : no_cause("no result of libm differs before the state does: the processor is asked elsewhere");
}

}  // namespace

std::string Cause::text() const {
  if (!failure.empty()) return "not narrowed: " + failure;
  if (!dispatch.features.empty()) {
    std::string text;
    for (const std::string& feature : dispatch.features)
      text += (text.empty() ? "kernels without " : " and ") + feature;
    if (!dispatch.module.empty()) text += ", in " + dispatch.module;
    return text + " (" + dispatch.variable + ")";
  }
  if (is_ticks)
    return tick_first == tick_last ? "in tick " + std::to_string(tick_first) + " alone"
                                   : "in ticks " + std::to_string(tick_first) + ".." + std::to_string(tick_last);
  std::string text = function;
  if (size > 0) text += " of " + std::to_string(size) + " bytes";
  text += ", call " + std::to_string(nth) + " " + place_text(position);
  if (const std::string from = site.text(); !from.empty()) text += ", from " + from;
  if (call_count > 1) text += ", the last of " + std::to_string(call_count) + " calls that matter together";
  if (!effect.empty()) text += " (" + effect + ")";
  return text;
}

Cause narrow_fix(Launcher& launcher, const Perturbation& perturbation, const Conditions& fixed, const Outcome& control,
                 const std::function<bool(const Conditions&)>& holds_still, const std::function<bool()>& goes_on) {
  const auto first_calls = [&](std::uint64_t count) {
    Conditions conditions = fixed;
    conditions.settings.call_range_count = 1;
    conditions.settings.call_ranges[0] = {0, count};
    return conditions;
  };
  const std::uint64_t count = control.calls_of(perturbation.group);
  if (count == 0) return no_cause("the program makes no such call");
  bool has_ended_early = false;
  const std::uint64_t end = least(0, count, [&](std::uint64_t n) {
    has_ended_early = has_ended_early || !goes_on();
    return !has_ended_early && holds_still(first_calls(n));
  });
  Conditions logged = first_calls(end);
  logged.settings.logged_group = static_cast<std::uint32_t>(perturbation.group);
  logged.settings.logged = {end - 1, end};
  const Result<Run> recorded = launcher.run(logged);
  if (has_ended_early || !recorded || recorded->page.record_count == 0)
    return no_cause(has_ended_early ? "no time was left" : "the call was not made again");
  return cause_of(*recorded);
}

Cause narrow(Launcher& launcher, const Perturbation& perturbation, const Conditions& guilty, const Outcome& outcome,
             const NarrowOptions& options) {
  Narrower runs(launcher, guilty, options);
  switch (perturbation.narrowing) {
    case Narrowing::none:
      return no_cause("this perturbation changes the whole process");
    case Narrowing::calls:
      return narrow_calls(runs, perturbation, outcome);
    case Narrowing::ticks:
      return narrow_ticks(runs, outcome);
    case Narrowing::libm_results:
      return compare_libm(launcher, guilty, options);
    case Narrowing::dispatch:
      return narrow_kernels(launcher, runs, guilty);
  }
  return {};
}

}  // namespace ticktrue::shake
