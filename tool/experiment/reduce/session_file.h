// Reads sessions to reduce, from a scene and inputs or from a trace.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.h"
#include "engine/scene/scene.h"
#include "tool/experiment/soak_case.h"

namespace ticktrue::reduce {

/// `inputs_path` empty: no inputs. `tick_count` absent: the `end` input determines it. Errors: usage (no end), io,
/// invalid_input, limit.
Result<soak::SoakCase> read_session(const engine::Scene& scene, const std::string& inputs_path,
                                    std::optional<std::uint64_t> tick_count);

/// The scene and the inputs of a trace of the engine, with at most `tick_count` ticks. Errors: those of
/// TraceReader::open; unsupported (ticks of different lengths); corrupt.
Result<soak::SoakCase> read_trace_session(const std::string& path, std::optional<std::uint64_t> tick_count);

}  // namespace ticktrue::reduce
