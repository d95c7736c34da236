// Parts that all stress cases share, and the functions that add the cases.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tool/study/measures.h"
#include "tool/study/stress/stress.h"

namespace ticktrue::tool {

void add_contact_cases(std::vector<StressCase>& cases);
void add_small_and_far_cases(std::vector<StressCase>& cases);
void add_load_cases(std::vector<StressCase>& cases);
void add_floating_cases(std::vector<StressCase>& cases);
void add_scheme_cases(std::vector<StressCase>& cases);
void add_motion_cases(std::vector<StressCase>& cases);
void add_joint_cases(std::vector<StressCase>& cases);
void add_arm_cases(std::vector<StressCase>& cases);

/// Adds the claims of documents about the cases: StressCase::cures and shortfalls.
void add_claims(std::vector<StressCase>& cases);

/// The scene with the settings of the method.
engine::Scene with_method(engine::Scene scene, const StressMethod& method);

/// The inputs of a tick, in order.
using InputsOfTick = std::function<std::vector<engine::Input>(std::uint64_t tick)>;

/// Runs the scene for `seconds`. `watch` is called after every tick; false ends the run. `finish` returns the number of
/// the case. `watch` and `inputs` may be empty. A refused scene is not applicable, with the reason. A value that is not
/// finite ends the run, and so does a tick that fails.
StressValue run_case(const engine::Scene& scene, double seconds, const std::function<bool(const Bodies&)>& watch,
                     const std::function<double(const engine::Engine&, const Bodies& start, const Bodies& end)>& finish,
                     const InputsOfTick& inputs = {});

/// Largest joint gap after the first `settle` s of the run, relative to `size` (m).
StressValue worst_gap(const engine::Scene& scene, double seconds, double settle, double size);

StressCase make_case(std::string name, std::string what, std::string unit, double lower, double upper,
                     std::vector<StressMethod> methods);

/// The largest displacement of a moving body, across and down, each relative to its bound. 1 is the limit.
double moved_share(const Bodies& start, const Bodies& end, double across_max, double down_max);

/// The format in names and sentences: 0.01, 1000, 1e+06.
std::string plain_number(double value);

}  // namespace ticktrue::tool
