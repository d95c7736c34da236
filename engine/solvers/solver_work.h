// The workspace of the solving stages of an engine.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/contacts/contact_batch.h"
#include "engine/impacts/impacts.h"
#include "engine/impacts/jointed_impacts.h"
#include "engine/impacts/shock_propagation.h"
#include "engine/integrators/free_bodies.h"
#include "engine/integrators/motion_rows.h"
#include "engine/joints/direct/direct_set.h"
#include "engine/joints/gears/gear_joints.h"
#include "engine/joints/joint_passes.h"
#include "engine/joints/mouse_joint.h"
#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The workspaces of the rooms of the solver. Each room gets its own.
struct SolverWork {
  SolverBodies bodies;
  MotionWorkspace motion;
  FreeBodies free_bodies;
  ContactWorkspace contacts;
  JointWorkspace joints;
  DirectWorkspace direct;
  std::vector<GearJoint> gears;
  std::vector<MouseJoint> mouse_joints;
  ImpactWorkspace impacts;
  ShockWorkspace shock;
  JointedImpacts jointed_impacts;
};

template <typename Visit>
void list_fields(SolverWork& of, const Visit& visit) {
  auto& [bodies, motion, free_bodies, contacts, joints, direct, gears, mouse_joints, impacts, shock, jointed_impacts] =
      of;
  visit(bodies, motion, free_bodies, contacts, joints, direct, gears, mouse_joints, impacts, shock, jointed_impacts);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
