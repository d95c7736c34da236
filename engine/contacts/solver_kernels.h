// The inner loops of solvers as a table, compiled once per instruction set and chosen once per run.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/contacts/contact_lanes.h"
#include "engine/joints/batched/hinge_lanes.h"
#include "engine/joints/batched/pin_lanes.h"
#include "engine/narrow_phase/box_lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct SolverKernels {
  FillingKernels filling;
  ContactKernels contacts;
  PinKernels pins;
  HingeKernels hinges;
  MotionKernels motion;
  BoxKernels boxes;
};

// Units of these namespaces include no standard header with code in it (math/wide.h).
namespace baseline {
FillingKernels filling_kernels();
ContactKernels contact_kernels(unsigned features);
PinKernels pin_kernels();
HingeKernels hinge_kernels();
MotionKernels motion_kernels();
BoxKernels box_kernels();
}  // namespace baseline
namespace avx2 {
FillingKernels filling_kernels();
ContactKernels contact_kernels(unsigned features);
PinKernels pin_kernels();
HingeKernels hinge_kernels();
MotionKernels motion_kernels();
BoxKernels box_kernels();
}  // namespace avx2

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
