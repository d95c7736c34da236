// The output of a trail as text and JSON.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "tool/experiment/trail/trail.h"

namespace ticktrue::trail {

struct TrailSubject {
  std::string trace;
  std::vector<std::string> words;  // as the user gave them
  std::string against;             // the other program; empty: none
  std::string calls;
};

/// Exit code 0, 1 or 6.
int exit_code(const TrailReport& report);
std::string trail_text(const TrailReport& report, const TrailSubject& subject);
/// Schema ticktrue.trail/1.
std::string trail_json(const TrailReport& report, const TrailSubject& subject);

}  // namespace ticktrue::trail
