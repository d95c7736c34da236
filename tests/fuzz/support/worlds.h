// Small worlds that harnesses load states and inputs into: between them, every table and most columns of the engine.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

namespace ticktrue::fuzz {

/// Texts for make_builtin_scene. The first byte of a state or inputs input chooses one; only append, since stored
/// inputs count on the places.
inline constexpr std::array<std::string_view, 8> worlds{
    "stack?boxes=3&substeps=4",
    "shapes?bodies=6&precision=f64&substeps=4",
    "sensors?bodies=4&sleep=1",
    "bridge?planks=4&substeps=auto",
    "thesis",
    "billiards?walls=1&locate_impacts=1",
    "chain?links=4&solver=pgs&precision=f64",
    "mixed_pile?bodies=6&solver=pgs",
};

}  // namespace ticktrue::fuzz
