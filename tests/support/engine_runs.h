// Runs of the engine that tests compare: scenes with every feature, sessions of random inputs, tick hashes.
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
  std::vector<Bytes> inputs;     // may be shorter than the run: later ticks have no inputs
  std::vector<double> dts = {};  // s, of each tick; may be shorter than the run: later ticks have the scene's dt
};

/// A scene of traces/MANIFEST.tsv with its inputs, and the number of ticks of its trace.
struct GoldenSession {
  Session session;
  std::uint64_t tick_count = 0;
};
std::vector<GoldenSession> golden_sessions();

/// Built-in scenes in both precisions, and worlds with random inputs of every declared kind. The worlds have every
/// joint and shape, force elements, sleep, automatic substeps, each solver and each clock. The worlds are small and
/// active.
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

/// Runs ticks of the scene's length without inputs.
void run_ticks(engine::Engine& engine, int tick_count);

/// The column saved_work of the table `budget`. Requires: the scene has a budget.
std::uint64_t saved_work(const engine::Engine& engine);

}  // namespace ticktrue::test
