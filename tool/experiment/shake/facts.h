// Facts about the machine and the program, which decide which perturbations apply.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tool/experiment/shake/outcome.h"
#include "tool/experiment/shake/rebuild.h"

namespace ticktrue::shake {

struct Facts {
  std::string program;                  // file of the program; empty: not found
  std::string folder;                   // folder for files
  bool is_this_tool = false;            // `ticktrue verify` runs the trace
  bool is_x86_64 = false;               // of this build
  std::string no_cycle_trap;            // why rdtsc cannot be replaced; empty: the kernel and the processor trap it
  bool has_interpreter = false;         // the program uses an interpreter with hash seeds
  bool has_math_library = false;        // the program's file mentions numpy, OpenBLAS or MKL
  std::string no_shim;                  // why the preload library cannot be used; empty: usable
  std::vector<std::string> allocators;  // files of other allocators
  std::vector<std::string> locales;     // names of a locale with a decimal comma and of a Turkish locale
  std::string locale_folder;            // folder of compiled locales; empty: installed
  std::string no_time_namespace;        // why there is none; empty: available
  std::string no_user_namespace;        // why there is none; empty: available
  std::string no_process_namespace;     // why there is none; empty: available
  std::string emulator;                 // qemu-x86_64; empty: not found
  Outcome control;                      // outcome with the preload library, if available
  Builds builds;                        // builds of the program by --rebuild
};

/// Command words before a program that change its clocks, user or process number.
std::vector<std::string> time_wrapper();
std::vector<std::string> user_wrapper();
std::vector<std::string> process_wrapper();

/// Whether the processor has a feature, by its name in /proc/cpuinfo.
bool processor_has(const std::string& feature);

/// `words`: the program and its arguments. `folder`: for compiled locales. `is_asked`: whether a perturbation was
/// requested; facts for other perturbations are not collected.
Facts collect_facts(const std::vector<std::string>& words, const std::string& folder,
                    const std::function<bool(std::string_view name)>& is_asked);

}  // namespace ticktrue::shake
