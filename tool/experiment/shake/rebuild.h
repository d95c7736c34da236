// Rebuilds the shaken program: with another compiler, without optimisation, with fused products.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace ticktrue::shake {

enum class BuildKind : std::uint8_t { other_compiler, no_optimisation, contraction, this_processor };
inline constexpr std::size_t build_kind_count = 4;

struct Build {
  std::string program;  // file of the program
  std::string missing;  // why the build is missing; empty: it exists
};
using Builds = std::array<Build, build_kind_count>;

struct RebuildOptions {
  std::string command;  // command for sh
  std::string folder;   // folder for programs
  double time_s = 600;  // limit of one build
};

/// The build that a perturbation runs, by the name of the perturbation.
std::optional<BuildKind> build_kind_named(std::string_view perturbation);

/// Builds that are all missing, with the reason.
Builds no_builds(const std::string& why);

/// Builds the program with the compiler and the flags of this environment. Errors: usage (the command fails or leaves
/// no program; the hint has its last lines).
Result<std::string> build_as_is(const RebuildOptions& options);

/// `as_is`: the program of build_as_is. A kind whose build fails, or gives equal bytes, is missing.
Build build_kind(const RebuildOptions& options, BuildKind kind, const std::string& as_is);

}  // namespace ticktrue::shake
