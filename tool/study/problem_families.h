// The parts of the list of verification problems.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "tool/study/problems.h"

namespace ticktrue::tool {

std::vector<Problem> joint_problems();
/// Impacts, friction, rest.
std::vector<Problem> contact_problems();

}  // namespace ticktrue::tool
