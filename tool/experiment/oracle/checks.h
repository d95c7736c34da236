// The checks of `ticktrue soak`: variants of a run that must not change a bit, and rules that every run obeys.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace ticktrue::soak {

enum class CheckKind : std::uint8_t {
  finite,
  zeros,
  cold,
  forget,
  broad_phase,
  chunks,
  threads,
  instruction_set,
  full_pipeline,
  restore,
  process,
  trace,
  momentum,
  pair_limit,
};
struct CheckInfo {
  CheckKind kind;
  std::string_view name;
  std::string_view summary;
  std::string_view value;  // meaning of a variant's number; empty: the variant has no number
};
inline constexpr std::array<CheckInfo, 14> check_table{{
    {CheckKind::finite, "finite", "every stored real is finite, and every tick can be done", ""},
    {CheckKind::zeros, "zeros", "no stored real is -0", ""},
    {CheckKind::cold, "cold", "all cached structures are forgotten before every tick", ""},
    {CheckKind::forget, "forget", "random cached structures are forgotten at random ticks",
     "seed, its remainder by 6 the broad phase"},
    {CheckKind::broad_phase, "broad_phase", "another broad phase finds the pairs", "index in the list of broad phases"},
    {CheckKind::chunks, "chunks", "loops run in small chunks out of order", "10 * chunk size + order (0, 1)"},
    {CheckKind::threads, "threads", "a tick runs on several threads", "10 * chunk size (0: as it pays) + threads"},
    {CheckKind::instruction_set, "instruction_set", "kernels use other vector instructions", "index in their list"},
    {CheckKind::full_pipeline, "full_pipeline", "no stage is left out; the tables that both runs have", ""},
    {CheckKind::restore, "restore", "a fresh engine loads the state of a tick and runs on", "the tick"},
    {CheckKind::process, "process", "a fresh process loads every checkpoint of a trace and runs on", "seed"},
    {CheckKind::trace, "trace", "the world is recorded, and verify says match", "seed"},
    {CheckKind::momentum, "momentum", "without anything from outside, momentum stays", ""},
    {CheckKind::pair_limit, "pair_limit", "a tick may list no more pairs of shapes than it needs",
     "index in the list of broad phases"},
}};

/// One way to run and examine a world.
struct Variant {
  CheckKind check = CheckKind::finite;
  std::uint64_t value = 0;  // its meaning is CheckInfo::value
  bool operator==(const Variant&) const = default;
};

/// "restore=57".
std::string variant_text(const Variant& variant);

/// The checks that a soak runs. If a variant of a check is given, no other variant of that check runs.
struct CheckSelection {
  std::array<bool, check_table.size()> wanted{};
  std::vector<Variant> only;
  static CheckSelection all();
  bool has(CheckKind kind) const { return wanted[static_cast<std::size_t>(kind)]; }
};
/// Parses names of checks or variants: "cold,restore=57". A named check without a number runs in every world. A named
/// check with numbers draws some numbers for each world. Errors: usage.
Result<CheckSelection> parse_checks(const std::vector<std::string>& words);

/// The finding of a check in a world.
struct Finding {
  Variant variant;
  std::uint64_t tick = 0;   // the first wrong tick
  std::string what;         // "table contacts, column tangent_force, row 3 (box / box), lane 0: expected 0, got -0"
  bool is_refused = false;  // the engine refused the world: a fault of the generator
  bool is_beyond = false;   // the tick needs more than base/limits.h allows
};

}  // namespace ticktrue::soak
