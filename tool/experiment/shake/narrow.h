// Narrows a guilty perturbation: to the calls or ticks in which it matters.
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
  std::string function;          // of the C library; empty: none was found
  std::uint64_t number = 0;      // of the call in its group
  std::uint64_t nth = 0;         // call of the function in that place, from 1
  std::uint64_t position = 0;    // as in shim/page.h
  std::uint64_t size = 0;        // bytes that were asked for; 0: no allocation
  std::uint64_t call_count = 1;  // that are needed together
  CallSite site;
  DispatchCause dispatch;  // no call, but kernels that a library chose; no features: another kind of cause
  std::string effect;      // what changed, where it is known
  bool is_ticks = false;   // no call, but a range of ticks
  std::uint64_t tick_first = 0;
  std::uint64_t tick_last = 0;
  std::string failure;  // why there is no cause; empty: there is one

  /// "sin, call 1 of tick 16, from Ship::steer (ship.cpp:40)".
  std::string text() const;
};

struct NarrowOptions {
  std::string baseline;           // signature of runs that change nothing
  std::function<bool()> goes_on;  // whether there is time for another run
};

/// `guilty`: conditions under which the run was another, and that run.
Cause narrow(Launcher& launcher, const Perturbation& perturbation, const Conditions& guilty, const Outcome& outcome,
             const NarrowOptions& options);

/// Of a program that does not repeat itself, and does if all calls are fixed: the last call that has to be. `control`
/// has made the calls; `holds_still` says whether runs under conditions are the same.
Cause narrow_fix(Launcher& launcher, const Perturbation& perturbation, const Conditions& fixed, const Outcome& control,
                 const std::function<bool(const Conditions&)>& holds_still, const std::function<bool()>& goes_on);

}  // namespace ticktrue::shake
