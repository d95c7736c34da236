// Toy simulations with an injected fault, and short ways to record and verify them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "tests/replay/toy_traces.h"
#include "tests/support/text.h"
#include "tests/support/toy_simulation.h"
#include "verifier/verify/verify.h"

namespace ticktrue::test {

/// A toy that calls a function at the end of a stage of one tick. The test sets the function first.
struct InjectedFault {
  std::uint64_t tick = 0;
  std::size_t stage = 0;
  std::function<void(ToySimulation&)> fault;
};
inline InjectedFault injected;

inline Result<std::unique_ptr<Simulation>> make_faulty(ByteView setup) {
  ByteReader in(setup);
  auto toy = std::make_unique<ToySimulation>(in.u32());
  toy->disturb = [](ToySimulation& self, std::size_t stage) {
    // tick_count rises in the last stage, before the fault.
    const std::uint64_t tick = self.world.tick_count - (stage == ToySimulation::move_stage ? 1 : 0);
    if (tick != injected.tick || stage != injected.stage) return;
    injected.fault(self);
    self.refresh();
  };
  return std::unique_ptr<Simulation>(std::move(toy));
}
inline const SimulationInfo faulty_info{"ticktrue.toy", 1, &make_faulty};

/// The toy under a class of one's own.
template <typename Toy>
Result<std::unique_ptr<Simulation>> make_toy(ByteView setup) {
  ByteReader in(setup);
  return std::unique_ptr<Simulation>(std::make_unique<Toy>(in.u32()));
}

inline Bytes toy_trace_with(const replay::TraceSetup& setup, std::uint64_t tick_count,
                            std::uint32_t checkpoint_interval) {
  replay::TraceSetup copy = setup;
  copy.checkpoint_interval = checkpoint_interval;
  return toy_trace(copy, tick_count);
}

inline replay::TraceReader open_trace(ByteView bytes) {
  auto reader = replay::TraceReader::open_bytes(bytes, "toy.ttr");
  if (!reader) FAIL(reader.error().message);
  return std::move(*reader);
}

inline verifier::VerifyOptions verify_options(const SimulationInfo& info,
                                              verifier::VerifyMode mode = verifier::VerifyMode::replay) {
  verifier::VerifyOptions options;
  options.simulation = &info;
  options.mode = mode;
  return options;
}

inline verifier::Report verify_bytes(ByteView bytes, const verifier::VerifyOptions& options) {
  replay::TraceReader reader = open_trace(bytes);
  return verifier::verify(reader, options);
}
inline verifier::Report verify_bytes(ByteView bytes, const SimulationInfo& info,
                                     verifier::VerifyMode mode = verifier::VerifyMode::replay) {
  return verify_bytes(bytes, verify_options(info, mode));
}

}  // namespace ticktrue::test
