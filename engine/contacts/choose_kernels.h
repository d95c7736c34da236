// The choice of the kernels that a scene needs.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "engine/model/solver_kernels.h"
#include "engine/simd/instruction_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;

/// The features that contacts of a scene may have: bits of contact_feature.
unsigned contact_features(const Model& model);
/// The work that kernels with these features leave out, as "no friction, one point"; empty for none.
std::string left_out(unsigned features);

/// Requires: can_use(set); features: at least those of the model's contacts.
void set_kernels(Model& model, InstructionSet set, unsigned features);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
