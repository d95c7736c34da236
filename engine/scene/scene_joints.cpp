// Removal of joints from a scene.
// SPDX-License-Identifier: MIT
#include <utility>

#include "engine/scene/scene.h"

namespace ticktrue::engine {

std::vector<std::uint32_t> keep_joints(Scene& scene, const std::vector<std::uint8_t>& is_kept) {
  std::vector<std::uint32_t> index_of(scene.joints.size(), no_joint);
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < scene.joints.size(); ++i) {
    Joint& joint = scene.joints[i];
    bool keeps = is_kept[i] != 0;
    if (joins_joints(joint.kind)) {  // its joints come before it
      joint.joint_a = index_of[joint.joint_a];
      joint.joint_b = index_of[joint.joint_b];
      keeps = keeps && joint.joint_a != no_joint && joint.joint_b != no_joint;
    }
    if (!keeps) continue;
    index_of[i] = count;
    if (count != i) scene.joints[count] = std::move(joint);
    ++count;
  }
  scene.joints.resize(count);
  return index_of;
}

}  // namespace ticktrue::engine
