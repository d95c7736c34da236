// The first difference between two state schemas, for people.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/state/state_view.h"

namespace ticktrue::verifier {

struct SchemaDifference {
  std::string place;  // e.g. "bodies.source"
  std::string a;      // the value in the first schema, e.g. "0..6"
  std::string b;
  std::string meaning = {};  // the consequence, if it is not obvious; may be empty
};

/// Which ranges of a column may differ. Ranges limit what load() accepts and are in no hash. Ranges of references may
/// never differ.
enum class Ranges : std::uint8_t {
  same,
  inside,  // the first range may be inside the second: a recording, and a build that knows more kinds
  any,     // two recordings
};

/// Nothing: the schemas are the same, apart from allowed differences of ranges.
std::optional<SchemaDifference> first_schema_difference(const StateSchema& a, const StateSchema& b, Ranges ranges);

/// The sentence for a recording that this build cannot compare.
std::string schema_text(const SchemaDifference& difference);

/// "f32" and "f64" or the reverse, if the schemas differ only in the precision of every float; otherwise nothing.
std::optional<SchemaDifference> precision_difference(const StateSchema& a, const StateSchema& b);

}  // namespace ticktrue::verifier
