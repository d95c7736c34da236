// `ticktrue accuracy --peer box2d2,box2d3`: error against run time beside Box2D.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "tool/cli/study/study_output.h"

namespace ticktrue::cli {

/// Another name of box2d2.
inline constexpr const char* first_peer_name = "box2d";

/// Runs the scenes (all, if none is named), prints and writes what came out; returns the exit code. `peers`: names of
/// the table of peers, or first_peer_name.
int run_accuracy_peer(const std::vector<std::string>& scenes, const std::vector<std::string>& peers, int repeat_count,
                      const StudyFiles& files);

}  // namespace ticktrue::cli
