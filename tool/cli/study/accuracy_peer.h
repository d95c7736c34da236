// `ticktrue accuracy --peer box2d`: error against run time beside Box2D.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "tool/cli/study/study_output.h"

namespace ticktrue::cli {

/// Runs the scenes (all, if none is named), prints and writes what came out; returns the exit code.
int run_accuracy_peer(const std::vector<std::string>& scenes, int repeat_count, const StudyFiles& files);

}  // namespace ticktrue::cli
