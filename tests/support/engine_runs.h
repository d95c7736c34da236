// Runs of the engine that tests compare: scenes that use every feature, sessions of random inputs, tick hashes.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/engine.h"

namespace ticktrue::test {

/// A scene and what happens in it. `inputs[tick]` are the encoded inputs of that tick.
struct Session {
  std::string name;
  engine::Scene scene;
  std::vector<Bytes> inputs;  // shorter than the run: no inputs later
};

/// Built-in scenes in both precisions, and three worlds under random inputs of every kind they
/// declare, one with a joint of every kind. Small and lively.
std::vector<Session> property_sessions();

/// Requires: the scene is valid.
std::unique_ptr<engine::Engine> make_engine_or_fail(const engine::Scene& scene,
                                                    const engine::EngineOptions& options = {});

/// The input of a tick of a session.
TickInput input_of(const Session& session, std::uint64_t tick);

/// Root hash after each of `tick_count` ticks.
std::vector<std::uint64_t> tick_hashes(const Session& session, std::uint64_t tick_count,
                                       const engine::EngineOptions& options = {});

Bytes image_of(const Simulation& simulation);

}  // namespace ticktrue::test
