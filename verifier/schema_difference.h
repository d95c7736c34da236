// The first place in which two state schemas differ, for people.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "base/state_view.h"

namespace ticktrue::verifier {

struct SchemaDifference {
  std::string place;  // e.g. "bodies.source"
  std::string a;      // what the first has there, e.g. "0..6"
  std::string b;
};

/// Nothing if the schemas are the same.
std::optional<SchemaDifference> first_schema_difference(const StateSchema& a, const StateSchema& b);

/// Nothing unless the schemas are the same but for the precision of every float: then "f32" and "f64", or the reverse.
std::optional<SchemaDifference> precision_difference(const StateSchema& a, const StateSchema& b);

}  // namespace ticktrue::verifier
