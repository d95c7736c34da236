// The parts of the list of stress cases.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tool/study/measures.h"
#include "tool/study/stress/stress.h"

namespace ticktrue::verifier {

void add_contact_cases(std::vector<StressCase>& cases);
void add_motion_cases(std::vector<StressCase>& cases);
void add_joint_cases(std::vector<StressCase>& cases);

/// The scene set as the method says.
engine::Scene with_method(engine::Scene scene, const StressMethod& method);

/// Runs for `seconds`; `watch` is called after every tick and may be empty; false ends the run. `finish` gives the
/// number. What is refused is not applicable, with the reason; a value that is not finite ends the run, and so does a
/// tick that could not be done.
StressValue run_case(
    const engine::Scene& scene, double seconds, const std::function<bool(const Bodies&)>& watch,
    const std::function<double(const engine::Engine&, const Bodies& start, const Bodies& end)>& finish);

/// The largest displacement across and down of the moving bodies, relative to their bounds; 1 is the limit.
double moved_share(const Bodies& start, const Bodies& end, double across_max, double down_max);

/// The format in names and sentences: 0.01, 1000, 1e+06.
std::string plain_number(double value);

}  // namespace ticktrue::verifier
