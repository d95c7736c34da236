// Expressions over the values of a world, such as `energy < 1.05 * energy_start`.
// SPDX-License-Identifier: MIT
//
// Syntax: that of muParser: + - * / ^, comparisons, && || !, abs, min, max, sqrt and others.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"
#include "tool/expression/world_values.h"

namespace ticktrue::tool {

/// What an expression may name: world_values, with part_values (`bodies.3.x`, `joints.0.force`), or the time alone
/// (`t`).
enum class ExpressionNames : std::uint8_t { world, world_and_parts, time };

class Expression {
 public:
  /// `option` comes first in messages. Names: those of world_values, and each with `_start`: the value before the first
  /// tick. Errors: usage; unsupported (a build without muParser).
  static Result<Expression> parse(const std::string& text, const std::string& option,
                                  ExpressionNames names = ExpressionNames::world);
  Expression(Expression&& other) noexcept;
  Expression& operator=(Expression&& other) noexcept;
  ~Expression();

  /// Measures what the names with `_start` stand for. Call it before the first tick.
  void begin(const engine::Engine& engine);
  /// The value in the present state; a comparison gives 1 or 0. A comparison with a NaN gives 0.
  double evaluate(const engine::Engine& engine);
  /// Requires: ExpressionNames::time.
  double evaluate_at(double time_s);
  /// Refuses bodies and joints that no state of the scene can have. Messages begin with `place`. Errors: usage.
  Status check_parts(const engine::Scene& scene, const std::string& place) const;
  /// Whether begin() must be called.
  bool uses_start() const;

  /// The values that the expression names, each once, in the order of world_values.
  const std::vector<WorldValue>& values() const;
  /// "energy = 12.5, energy_start = 3": as of the last evaluate.
  std::string values_text() const;
  const std::string& text() const;

 private:
  struct Parser;
  explicit Expression(std::unique_ptr<Parser> parser);
  std::unique_ptr<Parser> parser_;
};

}  // namespace ticktrue::tool
