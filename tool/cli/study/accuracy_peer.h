// `ticktrue accuracy --peer box2d2,box2d3`: error against run time beside Box2D.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "tool/cli/study/study_output.h"

namespace ticktrue::cli {

/// Another name of box2d2.
inline constexpr const char* first_peer_name = "box2d";

struct AccuracyPeerOptions {
  std::vector<std::string> scenes;  // none: all
  std::vector<std::string> peers;   // names of the table of peers, or first_peer_name
  std::string engine_program;       // PeerCurvesOptions::engine_program
  int repeat_count = 1;
};

/// Runs the scenes, prints and writes what came out; returns the exit code.
int run_accuracy_peer(const AccuracyPeerOptions& options, const StudyFiles& files);

}  // namespace ticktrue::cli
