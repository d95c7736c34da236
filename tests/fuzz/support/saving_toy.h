// The toy simulation with saves: they hold its whole state, so that a run may begin at each of them.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>

#include "tests/support/toy_simulation.h"

namespace ticktrue::fuzz {

class SavingToy : public test::ToySimulation {
 public:
  using ToySimulation::ToySimulation;

  static Result<std::unique_ptr<Simulation>> make(ByteView setup) {
    const auto checked = ToySimulation::make(setup);
    if (!checked) return checked.error();
    return std::unique_ptr<Simulation>(std::make_unique<SavingToy>(ByteReader(setup).u32()));
  }

  Result<std::optional<Bytes>> save(std::uint64_t) override {
    Bytes bytes;
    encode_image(state(), bytes);
    return std::optional<Bytes>(std::move(bytes));
  }
  Status load_saved(std::uint64_t, ByteView save) override { return load(save); }
};

}  // namespace ticktrue::fuzz
