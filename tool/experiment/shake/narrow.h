// Narrows a perturbation that moves a run to the calls or ticks that matter.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

#include "tool/experiment/shake/call_site.h"
#include "tool/experiment/shake/dispatch.h"
#include "tool/experiment/shake/launch.h"
#include "tool/experiment/shake/perturbations.h"

namespace ticktrue::shake {

struct Cause {
  std::string function;          // of the C library; empty: not found
  std::uint64_t number = 0;      // number of the call in its group
  std::uint64_t nth = 0;         // index of the call among calls of this function at this position, from 1
  std::uint64_t position = 0;    // as in shim/page.h
  std::uint64_t size = 0;        // requested bytes; 0: not an allocation
  std::uint64_t call_count = 1;  // calls that are needed together
  CallSite site;
  DispatchCause dispatch;  // with features: the cause is a choice of kernels and not a call
  std::string effect;      // the change, if known
  bool is_ticks = false;   // the cause is a range of ticks and not a call
  std::uint64_t tick_first = 0;
  std::uint64_t tick_last = 0;
  std::string failure;  // why no cause was found; empty: found

  /// "sin, call 1 of tick 16, from Ship::steer (ship.cpp:40)".
  std::string text() const;
};

struct NarrowOptions {
  std::string baseline;           // signature of an unchanged run
  std::function<bool()> goes_on;  // whether time is left for another run
};

/// `guilty`: conditions that change the run. `outcome`: of that run.
Cause narrow(Launcher& launcher, const Perturbation& perturbation, const Conditions& guilty, const Outcome& outcome,
             const NarrowOptions& options);

/// For a program that only repeats itself with all calls fixed: finds the last call that must be fixed. `control` is a
/// run that made the calls. `holds_still`: whether runs under given conditions are equal.
Cause narrow_fix(Launcher& launcher, const Perturbation& perturbation, const Conditions& fixed, const Outcome& control,
                 const std::function<bool(const Conditions&)>& holds_still, const std::function<bool()>& goes_on);

}  // namespace ticktrue::shake
