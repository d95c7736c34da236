// Libraries that choose their kernels by the processor: how to make them choose others, and which choice matters.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tool/experiment/shake/launch.h"

namespace ticktrue::shake {

/// OpenBLAS, MKL and torch as on the oldest processor that they know.
void choose_oldest_kernels(Conditions& conditions);
/// numpy without the features of newer processors that this one has.
void leave_out_features(Conditions& conditions);

/// The choice that is enough to make a run another one.
struct DispatchCause {
  std::vector<std::string> features;  // of the processor, as /proc/cpuinfo or numpy names them; empty: none was found
  std::string variable;               // that chose, of the environment
  std::string module;                 // file that is loaded and reads it; empty: not found
};

/// `guilty`: conditions of the functions above under which the run is another one; `is_other` tells it of others.
/// Requires: the program has a session, which tells what is loaded.
DispatchCause narrow_dispatch(Launcher& launcher, const Conditions& guilty,
                              const std::function<bool(const Conditions&)>& is_other);

}  // namespace ticktrue::shake
