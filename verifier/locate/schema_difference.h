// The first place in which two state schemas differ, for people.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/state/state_view.h"

namespace ticktrue::verifier {

struct SchemaDifference {
  std::string place;  // e.g. "bodies.source"
  std::string a;      // what the first has there, e.g. "0..6"
  std::string b;
  std::string meaning = {};  // what follows from it, where a person may not see it; may be empty
};

/// Which ranges of a column may differ. They bound what load() accepts and are in no hash. Those of references never
/// may.
enum class Ranges : std::uint8_t {
  same,
  inside,  // the first may lie inside the second: a recording and a build that knows more kinds
  any,     // two recordings
};

/// Nothing if the schemas are the same, up to ranges.
std::optional<SchemaDifference> first_schema_difference(const StateSchema& a, const StateSchema& b, Ranges ranges);

/// The sentence of a recording that this build cannot compare.
std::string schema_text(const SchemaDifference& difference);

/// Nothing unless the schemas are the same but for the precision of every float: then "f32" and "f64", or the reverse.
std::optional<SchemaDifference> precision_difference(const StateSchema& a, const StateSchema& b);

}  // namespace ticktrue::verifier
