// The tool's exit codes, and which of them an error means.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "base/result.h"

namespace ticktrue::verifier {

inline constexpr int exit_ok = 0;              // match (at least one tick compared), or the command did its work
inline constexpr int exit_finding = 1;         // divergence, non-finite state, a check of the command's own fell short
inline constexpr int exit_usage = 2;           // usage, input/output, bad scene or inputs
inline constexpr int exit_incomplete = 3;      // trace incomplete; the surviving part was examined
inline constexpr int exit_damaged = 4;         // trace damaged; the report says what is still proven
inline constexpr int exit_not_comparable = 5;  // physics version, schema, precision, simulation or build
inline constexpr int exit_not_reproducible = 6;  // two runs on this machine differ

/// What the tool exits with when a command failed with this error. Commands that were given a scene, not a trace, exit
/// with exit_usage, unless a check of their own fell short (inconsistent).
int exit_code_of(ErrorCode code);

/// The one that counts when several files were processed: the worst in the order 2, 1, 6, 4, 5, 3, 0.
int worst_exit_code(std::span<const int> codes);

}  // namespace ticktrue::verifier
