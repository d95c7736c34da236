// Libraries that choose their kernels by the processor: forces another choice, and finds the choice that matters.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tool/experiment/shake/launch.h"

namespace ticktrue::shake {

/// Makes OpenBLAS, MKL and torch choose the kernels of the oldest processor that they know.
void choose_oldest_kernels(Conditions& conditions);
/// Disables newer features of this processor in numpy.
void leave_out_features(Conditions& conditions);

/// The smallest choice that changes a run.
struct DispatchCause {
  std::vector<std::string> features;  // of the processor, named as in /proc/cpuinfo or numpy; empty: not found
  std::string variable;               // the environment variable that made the choice
  std::string module;                 // loaded file that reads the variable; empty: not found
};

/// Narrows a change of kernels. `guilty`: conditions of the functions above that change the run. `is_other`: whether
/// given conditions change the run. Requires: the program has a session, which lists the loaded files.
DispatchCause narrow_dispatch(Launcher& launcher, const Conditions& guilty,
                              const std::function<bool(const Conditions&)>& is_other);

}  // namespace ticktrue::shake
