// Runs of the engine that tests compare: scenes that use every feature, sessions of random inputs, tick hashes.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/engine.h"

namespace ticktrue::test {

/// A scene and its inputs. `inputs[tick]` are the encoded inputs of that tick.
struct Session {
  std::string name;
  engine::Scene scene;
  std::vector<Bytes> inputs;     // shorter than the run: no inputs later
  std::vector<double> dts = {};  // s, of each tick; shorter than the run: the scene's dt later
};

/// A scene of traces/MANIFEST.tsv with its inputs, and how many ticks its trace has.
struct GoldenSession {
  Session session;
  std::uint64_t tick_count = 0;
};
std::vector<GoldenSession> golden_sessions();

/// Built-in scenes in both precisions, and worlds under random inputs of every kind they declare: with a joint of every
/// kind, every shape, force elements, sleep, automatic substeps, each solver, each clock. Small and lively.
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

/// Ticks of the scene's length without inputs.
void run_ticks(engine::Engine& engine, int tick_count);

}  // namespace ticktrue::test
