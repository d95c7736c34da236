// What this build is made of, as far as a verdict depends on it.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "base/hash128.h"

namespace ticktrue::tool {

/// A line for each unit: hash of its preprocessed text, hash of its flags and compiler. Empty where the build could not
/// tell. Made by cmake/engine_digest.cmake.
extern const char* const engine_units;

/// The same for what runs a program and judges the report of its session.
extern const char* const program_units;

/// XXH3-128 of these lines. It stays the same when comments, names of folders or the commit change.
std::optional<Hash128> engine_digest();
/// XXH3-128 of both.
std::optional<Hash128> program_verification_digest();

}  // namespace ticktrue::tool
