// The inner loops of solvers as a table of functions, compiled for each instruction set and chosen once per run.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/contacts/contact_lanes.h"
#include "engine/joints/batched/driven_revolute_lanes.h"
#include "engine/joints/batched/revolute_lanes.h"
#include "engine/narrow_phase/box_lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct SolverKernels {
  FillingKernels filling;
  ContactKernels contacts;
  RevoluteKernels revolutes;
  DrivenRevoluteKernels driven_revolutes;
  MotionKernels motion;
  BoxKernels boxes;
};

// Units of these namespaces include no standard header with code (simd/realxn.h).
namespace baseline {
FillingKernels filling_kernels();
ContactKernels contact_kernels(unsigned features);
RevoluteKernels revolute_kernels();
DrivenRevoluteKernels driven_revolute_kernels();
MotionKernels motion_kernels();
BoxKernels box_kernels();
}  // namespace baseline
namespace avx2 {
FillingKernels filling_kernels();
ContactKernels contact_kernels(unsigned features);
RevoluteKernels revolute_kernels();
DrivenRevoluteKernels driven_revolute_kernels();
MotionKernels motion_kernels();
BoxKernels box_kernels();
}  // namespace avx2

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
