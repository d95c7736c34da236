// A world to examine: a scene, its inputs and its number of ticks.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "engine/engine.h"
#include "engine/scene/input.h"
#include "engine/scene/scene.h"
#include "replay/recorder.h"

namespace ticktrue::soak {

struct SoakCase {
  engine::Scene scene;
  std::vector<engine::Input> inputs;  // ascending by tick; `end` has no effect
  std::uint64_t tick_count = 0;
};

/// Makes the engines of every run. Tests replace it by a maker of engines with an injected fault.
using EngineMaker =
    std::function<Result<std::unique_ptr<engine::Engine>>(const engine::Scene&, const engine::EngineOptions&)>;

/// The inputs of a case, encoded tick by tick.
class CaseInputs {
 public:
  explicit CaseInputs(const SoakCase& soak_case);

  /// The returned bytes are valid as long as this object.
  TickInput at(std::uint64_t tick) const;

 private:
  double dt_;
  Bytes none_;
  std::vector<Bytes> bytes_;  // [tick]
};

/// The inputs of a case as a source for the recorder.
class CaseSource : public replay::InputSource {
 public:
  CaseSource(const CaseInputs& inputs, std::uint64_t tick_count) : inputs_(inputs), tick_count_(tick_count) {}
  Result<std::optional<TickInput>> next(std::uint64_t tick) override {
    if (tick >= tick_count_) return std::optional<TickInput>();
    return std::optional(inputs_.at(tick));
  }
  bool repeatable() const override { return true; }

 private:
  const CaseInputs& inputs_;
  std::uint64_t tick_count_;
};

/// SplitMix64 of the sum of `b` and a multiple of `a`: one pseudo-random number for each pair.
std::uint64_t mix(std::uint64_t a, std::uint64_t b);

}  // namespace ticktrue::soak
