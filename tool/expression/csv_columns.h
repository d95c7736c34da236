// Values of a world by name, one line of CSV for each state.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"
#include "tool/expression/named_values.h"
#include "tool/expression/world_values.h"

namespace ticktrue::tool {

/// Columns: `tick`, `time`, and those that are asked for.
class CsvColumns {
 public:
  /// Names of world_values and part_values; `bodies.*.x` and `joints.*.gap` stand for those of every body and joint of
  /// the scene. Empty: every world value. A named `tick` or `time` is not added again. `option` comes first in
  /// messages. Errors: usage (an unknown name, a body or joint that the scene cannot have, too many).
  static Result<CsvColumns> make(const std::vector<std::string>& names, const engine::Scene& scene,
                                 const std::string& option);

  /// Without `tick` and `time`.
  std::vector<std::string> names() const;
  /// As names(). NaN: the value does not exist in this state.
  std::vector<double> values(const engine::Engine& engine) const;
  /// With its end of line, as row().
  std::string head() const;
  /// A value that does not exist or is not finite is an empty cell.
  std::string row(const engine::Engine& engine, std::uint64_t tick) const;

 private:
  Status add(const std::string& name, const engine::Scene& scene, const std::string& option);

  std::vector<std::variant<WorldValue, NamedValue>> columns_;
};

}  // namespace ticktrue::tool
