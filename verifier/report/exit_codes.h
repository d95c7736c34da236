// The exit codes of the tool, and the exit code for each error.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "base/result.h"

namespace ticktrue::verifier {

inline constexpr int exit_ok = 0;              // match (at least one tick compared), or the command succeeded
inline constexpr int exit_finding = 1;         // divergence, non-finite state, or a failed check of the command itself
inline constexpr int exit_usage = 2;           // usage, input/output, bad scene or inputs
inline constexpr int exit_incomplete = 3;      // trace incomplete; the intact part was examined
inline constexpr int exit_damaged = 4;         // trace damaged; the report says what is still proven
inline constexpr int exit_not_comparable = 5;  // physics version, schema, precision, simulation or build
inline constexpr int exit_not_reproducible = 6;  // two runs on this machine differ

/// The exit code of a command that failed with this error. Commands with a scene instead of a trace exit with
/// exit_usage, unless a check of the command itself failed (inconsistent).
int exit_code_of(ErrorCode code);

/// The exit code for several files: the worst in the order 2, 1, 6, 4, 5, 3, 0.
int worst_exit_code(std::span<const int> codes);

}  // namespace ticktrue::verifier
