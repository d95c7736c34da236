// Recognises marks that known bugs leave in values.
// SPDX-License-Identifier: MIT
#include "verifier/report/likely_causes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "base/assert.h"
#include "base/state/schema.h"
#include "verifier/report/fact_differences.h"

namespace ticktrue::verifier {

const std::array<CauseInfo, cause_count> causes{{
    {Cause::contraction, "contraction",
     "only one side is compiled with fused multiply-add: compile with -ffp-contract=off"},
    {Cause::fast_math, "fast_math", "only one side is compiled with fast math: compile without -ffast-math"},
    {Cause::unsaved_state, "unsaved_state", "the save lacks a variable that later ticks read"},
    {Cause::shared_generator, "shared_generator", "another number of random numbers was drawn in this tick"},
    {Cause::uninitialised_memory, "uninitialised_memory",
     "the value is the fill byte of a debug heap: memory was read before it was written, or after it was freed"},
    {Cause::address, "address", "the values are addresses: state must hold ids"},
    {Cause::clock, "clock", "the values are times of day: a tick must count ticks"},
    {Cause::negative_zero, "negative_zero",
     "the same value with the other sign: a minimum, a maximum or a product of zero is 0 or -0"},
    {Cause::flush_to_zero, "flush_to_zero",
     "one side flushes tiny numbers to zero: a library or -ffast-math has set the processor so"},
    {Cause::conversion_out_of_range, "conversion_out_of_range",
     "a float was converted to an integer that cannot hold it: processors give different results"},
    {Cause::decimal_comma, "decimal_comma",
     "one side has the value without its decimals: text was read in a locale with a decimal comma"},
    {Cause::row_order, "row_order",
     "rows have each other's values: they were made in the order of an unordered container, of addresses or of ties"},
    {Cause::tie, "tie",
     "one row has what another one lost: the choice among equals follows addresses, hashes or an unstable sort"},
    {Cause::thread_order, "thread_order", "no run repeats it: what threads do first differs from run to run"},
    {Cause::sum_order, "sum_order", "last places with equal inputs: floats are added in another order"},
    {Cause::other_math, "other_math",
     "last places with equal inputs: another sine, root or power of the C library, or fused multiply-add"},
    {Cause::random_numbers, "random_numbers", "no run repeats it: a clock, or random numbers without a recorded seed"},
}};

const CauseInfo& cause_info(Cause cause) {
  for (const CauseInfo& info : causes)
    if (info.cause == cause) return info;
  TICKTRUE_ASSERT(false);
  return causes[0];
}

namespace {

constexpr std::size_t cause_count_max = 2;
constexpr std::uint64_t last_places_max = 4;  // ulp
constexpr std::string_view own_simulation = "ticktrue.engine";

bool is_float(const LaneReport& lane) {
  return scalar_info(lane.type)->is_float;
}
unsigned bit_count(const LaneReport& lane) {
  return 8U * scalar_info(lane.type)->size;
}

double as_double(const LaneReport& lane, std::uint64_t bits) {
  if (lane.type == ScalarType::f32) return static_cast<double>(float_of_bits(static_cast<std::uint32_t>(bits)));
  if (lane.type == ScalarType::f64) return double_of_bits(bits);
  return static_cast<double>(bits);
}

/// A lane with values on both sides.
struct Pair {
  const LaneReport* lane;
  std::uint64_t expected;
  std::uint64_t got;
};

std::vector<Pair> pairs_of(const Divergence& divergence) {
  std::vector<Pair> pairs;
  for (const LaneReport& lane : divergence.rows)
    if (lane.expected && lane.got) pairs.push_back({&lane, *lane.expected, *lane.got});
  return pairs;
}

/// Whether the values are negatives of each other. The sign of a zero decides the sign of later values.
bool is_negated(const Pair& pair) {
  const std::uint64_t sign = std::uint64_t{1} << (bit_count(*pair.lane) - 1);
  if (is_float(*pair.lane)) return (pair.expected ^ pair.got) == sign;
  const unsigned unused = 64 - bit_count(*pair.lane);
  return scalar_info(pair.lane->type)->is_signed && (pair.expected + pair.got) << unused == 0;
}

bool is_denormal(const LaneReport& lane, std::uint64_t bits) {
  const double value = std::abs(as_double(lane, bits));
  return value > 0 && value < (lane.type == ScalarType::f32 ? 0x1p-126 : 0x1p-1022);
}
bool is_flushed(const Pair& pair) {
  if (!is_float(*pair.lane)) return false;
  const auto flushed = [&](std::uint64_t kept, std::uint64_t lost) {
    return is_denormal(*pair.lane, kept) && as_double(*pair.lane, lost) == 0;
  };
  return flushed(pair.expected, pair.got) || flushed(pair.got, pair.expected);
}

/// Whether the value is a byte, repeated four or eight times, that debug heaps and perturbed allocators write.
bool is_fill(const LaneReport& lane, std::uint64_t bits) {
  constexpr std::array<std::uint8_t, 10> fills{0xcd, 0xcc, 0xdd, 0xfd, 0xbe, 0xa5, 0x5a, 0xab, 0xaa, 0xfe};
  const std::size_t size = scalar_info(lane.type)->size;
  if (size < 4) return false;
  for (const std::uint8_t fill : fills)
    if (bits == (0x0101010101010101U >> (64 - 8 * size)) * fill) return true;
  return false;
}
bool is_fill(const Pair& pair) {
  return is_fill(*pair.lane, pair.expected) != is_fill(*pair.lane, pair.got);
}

/// Whether the value is in the range of programs, libraries, stacks and heaps on 64-bit Linux.
bool is_address(std::uint64_t bits) {
  const std::uint64_t top = bits >> 40;
  return top == 0x7f || top == 0x55 || top == 0x56;
}
bool is_address(const Pair& pair) {
  return !is_float(*pair.lane) && bit_count(*pair.lane) == 64 && is_address(pair.expected) && is_address(pair.got);
}

/// Whether both are times since 1970 in seconds, milliseconds, microseconds or nanoseconds, in 2017 to 2043, at most
/// ten years apart.
bool is_clock(const Pair& pair) {
  constexpr double first = 1.48e9, last = 2.3e9, apart = 3.2e8;
  if (bit_count(*pair.lane) < 32 || pair.lane->type == ScalarType::f32) return false;
  const double expected = as_double(*pair.lane, pair.expected), got = as_double(*pair.lane, pair.got);
  for (const double unit : {1.0, 1e3, 1e6, 1e9})
    if (std::min(expected, got) > first * unit && std::max(expected, got) < last * unit &&
        std::abs(expected - got) < apart * unit)
      return true;
  return false;
}

/// Whether one side is the "indefinite" integer of x86, and the other the result of other processors.
bool is_out_of_range(const Pair& pair) {
  const unsigned bits = bit_count(*pair.lane);
  if (is_float(*pair.lane) || bits < 32) return false;
  const std::uint64_t lowest = std::uint64_t{1} << (bits - 1);
  const auto fits = [&](std::uint64_t x86, std::uint64_t other) {
    return x86 == lowest && (other == lowest - 1 || other == 0 || other == (lowest | (lowest - 1)));
  };
  return fits(pair.expected, pair.got) || fits(pair.got, pair.expected);
}

bool is_cut_at_comma(const Pair& pair) {
  if (!is_float(*pair.lane)) return false;
  const double expected = as_double(*pair.lane, pair.expected), got = as_double(*pair.lane, pair.got);
  const auto cut = [](double whole, double part) {
    const double decimals = std::abs(whole - std::trunc(whole));
    return std::abs(whole) > 1 && std::abs(whole) < 1e6 && decimals > 0.01 && std::trunc(whole) == part;
  };
  return cut(expected, got) || cut(got, expected);
}

bool differs_in_last_places(const Pair& pair) {
  const auto ulp = ulp_distance(pair.lane->type, pair.expected, pair.got);
  return is_float(*pair.lane) && ulp && *ulp <= last_places_max;
}

using Column = std::pair<std::string, std::string>;
Column column_of(const LaneReport& lane) {
  return {lane.table, lane.column + "#" + std::to_string(lane.lane)};
}

/// Whether rows of a column have exchanged values.
bool has_other_row_order(const Divergence& divergence, const std::vector<Pair>& pairs) {
  if (divergence.from_cells && divergence.candidate_count == 0 && divergence.unexplained_cells == 0 &&
      !divergence.tables.empty())
    return true;
  if (divergence.lane_count != pairs.size()) return false;
  std::map<Column, std::pair<std::vector<std::uint64_t>, std::vector<std::uint64_t>>> values;
  for (const Pair& pair : pairs) {
    auto& [expected, got] = values[column_of(*pair.lane)];
    expected.push_back(pair.expected);
    got.push_back(pair.got);
  }
  for (auto& [column, both] : values) {
    std::sort(both.first.begin(), both.first.end());
    std::sort(both.second.begin(), both.second.end());
    if (both.first.size() > 1 && both.first == both.second) return true;
  }
  return false;
}

/// Whether of two rows of an integer column one has gained what the other has lost.
bool is_given_to_another(const std::vector<Pair>& pairs) {
  std::map<Column, std::vector<std::uint64_t>> more;
  for (const Pair& pair : pairs) {
    // Both sides modulo 2^(size of the type).
    const unsigned unused = 64 - bit_count(*pair.lane);
    if (!is_float(*pair.lane)) more[column_of(*pair.lane)].push_back((pair.got - pair.expected) << unused);
  }
  return std::any_of(more.begin(), more.end(), [](const auto& entry) {
    return entry.second.size() == 2 && entry.second[0] + entry.second[1] == 0;
  });
}

template <typename Is>
bool any(const std::vector<Pair>& pairs, Is is) {
  return std::any_of(pairs.begin(), pairs.end(), is);
}
template <typename Is>
bool all(const std::vector<Pair>& pairs, Is is) {
  return !pairs.empty() && std::all_of(pairs.begin(), pairs.end(), is);
}

std::optional<Cause> cause_of_builds(const Symptoms& symptoms) {
  if (symptoms.build_a == nullptr || symptoms.build_b == nullptr) return std::nullopt;
  for (const FactDifference& difference : fact_differences(*symptoms.build_a, *symptoms.build_b))
    if (difference.changes_bits) return difference.name.ends_with("fused") ? Cause::contraction : Cause::fast_math;
  return std::nullopt;
}

bool draws_other_count(const MarksDifference& marks) {
  return std::any_of(marks.names.begin(), marks.names.end(), [](const NameDifference& name) {
    return name.expected != name.got && name.name.find("rand") != std::string::npos;
  });
}

/// Adds the first mark that hardly anything else leaves.
void add_mark_of_values(const std::vector<Pair>& pairs, std::vector<Cause>& found) {
  struct Mark {
    Cause cause;
    bool (*is)(const Pair&);
    bool wants_all;  // all lanes must have the mark: a single lane can be chance
  };
  constexpr std::array<Mark, 7> marks{{{Cause::uninitialised_memory, is_fill, false},
                                       {Cause::address, is_address, false},
                                       {Cause::conversion_out_of_range, is_out_of_range, false},
                                       {Cause::clock, is_clock, false},
                                       {Cause::flush_to_zero, is_flushed, false},
                                       {Cause::negative_zero, is_negated, true},
                                       {Cause::decimal_comma, is_cut_at_comma, true}}};
  const auto mark = std::find_if(marks.begin(), marks.end(), [&](const Mark& one) {
    return one.wants_all ? all(pairs, one.is) : any(pairs, one.is);
  });
  if (mark != marks.end()) found.push_back(mark->cause);
}

void add_weak_marks(const Symptoms& symptoms, const std::vector<Pair>& pairs, std::vector<Cause>& found) {
  const bool is_last_places = all(pairs, differs_in_last_places);
  if (!symptoms.repeats) {
    found.push_back(Cause::thread_order);
    if (!is_last_places) found.push_back(Cause::random_numbers);
  } else if (has_other_row_order(*symptoms.divergence, pairs)) {
    found.push_back(Cause::row_order);
  } else if (is_given_to_another(pairs)) {
    found.push_back(Cause::tie);
  } else if (is_last_places) {
    found.push_back(Cause::sum_order);
    found.push_back(Cause::other_math);
  }
}

}  // namespace

std::vector<Cause> likely_causes(const Symptoms& symptoms) {
  std::vector<Cause> found;
  if (symptoms.simulation == own_simulation || symptoms.divergence == nullptr) return found;
  const std::vector<Pair> pairs = pairs_of(*symptoms.divergence);
  if (symptoms.begins_at_checkpoint) found.push_back(Cause::unsaved_state);
  if (symptoms.marks != nullptr && draws_other_count(*symptoms.marks)) found.push_back(Cause::shared_generator);
  add_mark_of_values(pairs, found);
  // Different floats between builds can appear in any column: a fact that changes bits is named for any values.
  if (const auto builds = cause_of_builds(symptoms); builds && found.empty()) found.push_back(*builds);
  if (found.empty()) add_weak_marks(symptoms, pairs, found);
  if (found.size() > cause_count_max) found.resize(cause_count_max);
  return found;
}

std::vector<Cause> likely_causes(const Report& report) {
  Symptoms symptoms;
  symptoms.simulation = report.simulation;
  symptoms.divergence = report.divergence ? &*report.divergence : nullptr;
  symptoms.marks = report.marks ? &*report.marks : nullptr;
  symptoms.build_a = &report.recorded_build;
  symptoms.build_b = &report.here_build;
  symptoms.repeats = report.verdict != Verdict::not_reproducible;
  symptoms.begins_at_checkpoint = report.verdict == Verdict::state_incomplete;
  return likely_causes(symptoms);
}

std::vector<std::string> cause_lines(const std::vector<Cause>& found) {
  std::vector<std::string> lines;
  for (const Cause cause : found) lines.push_back((lines.empty() ? "" : "or ") + std::string(cause_info(cause).text));
  return lines;
}

}  // namespace ticktrue::verifier
