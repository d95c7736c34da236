// Builds the shaken program anew: by another compiler, without optimisation, with fused products.
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
  std::string program;  // its file
  std::string missing;  // why there is none; empty: there is one
};
using Builds = std::array<Build, build_kind_count>;

struct RebuildOptions {
  std::string command;  // for sh
  std::string folder;   // for programs
  double time_s = 600;  // of a build
};

/// Of a perturbation by its name: the build that it runs.
std::optional<BuildKind> build_kind_named(std::string_view perturbation);

/// No build, and why.
Builds no_builds(const std::string& why);

/// The program as the command builds it, with the compiler and the flags of this environment. Errors: usage (the
/// command fails, or leaves no program; its last lines are the hint).
Result<std::string> build_as_is(const RebuildOptions& options);

/// `as_is`: of build_as_is. A kind whose build fails, or gives the same bytes, is missing.
Build build_kind(const RebuildOptions& options, BuildKind kind, const std::string& as_is);

}  // namespace ticktrue::shake
