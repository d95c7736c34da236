// The table of perturbations, one row for each perturbation.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "shim/page.h"
#include "tool/experiment/shake/facts.h"
#include "tool/experiment/shake/launch.h"

namespace ticktrue::shake {

/// A: must never matter. B: differs between machines. C: measures sensitivity.
enum class Kind : char { a = 'A', b = 'B', c = 'C' };

/// How a perturbation that moves the program is narrowed.
enum class Narrowing : std::uint8_t { none, calls, ticks, libm_results, dispatch };

struct Perturbation {
  std::string_view name;
  Kind kind;
  std::string_view what;  // one line
  std::string_view mend;  // how to mend the cause
  bool uses_shim;
  bool is_combinable;  // may take part in the common run of all A
  Narrowing narrowing;
  shim::Group group;  // the group of calls to narrow
  unsigned variant_count;
  /// The reason why the perturbation does not apply; empty: it applies.
  std::string (*missing)(const Facts& facts);
  void (*apply)(Conditions& conditions, unsigned variant, std::uint64_t seed, const Facts& facts);
  /// Fixes the source, for a program whose runs differ; may be null.
  void (*fix)(Conditions& conditions);
};

std::span<const Perturbation> perturbations();
const Perturbation* find_perturbation(std::string_view name);

}  // namespace ticktrue::shake
