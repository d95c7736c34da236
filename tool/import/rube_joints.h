// Reads the joints of a R.U.B.E. file into a scene.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/scene/scene.h"
#include "tool/import/rube_reader.h"

namespace ticktrue::tool {

/// [index in the file] index in the scene; absent: the body or joint was left out.
using RubeIds = std::vector<std::optional<std::uint32_t>>;

/// Adds the joint at this place to the scene, or a note why it is left out. The reader stores errors.
/// Adds an element to `joint_ids`. Passes over gears: read_rube_gear reads them.
/// Requires: the bodies of the file were read.
void read_rube_joint(RubeReader& in, const RubePlace& at, const RubeIds& body_ids, RubeIds& joint_ids, RubeNames& names,
                     engine::Scene& scene);

/// The same for a gear; passes over all other joints. Requires: all other joints of the file were read.
void read_rube_gear(RubeReader& in, const RubePlace& at, const RubeIds& joint_ids, RubeNames& names,
                    engine::Scene& scene);

}  // namespace ticktrue::tool
