// What the machine offers and what the program is: decides which perturbations apply.
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
  std::string program;                  // its file; empty: not found
  std::string folder;                   // for files
  bool is_this_tool = false;            // `ticktrue verify` runs the trace
  bool is_x86_64 = false;               // this build
  bool has_interpreter = false;         // of a language with hash seeds
  bool has_math_library = false;        // numpy, OpenBLAS or MKL, as far as the program's file tells
  std::string no_shim;                  // why the preload library cannot be used; empty: it can
  std::vector<std::string> allocators;  // files of other allocators
  std::vector<std::string> locales;     // names of locales with a decimal comma, of Turkish
  std::string locale_folder;            // where they were made; empty: they are installed
  std::string no_time_namespace;        // why there is none
  std::string no_user_namespace;        // why there is none
  std::string no_process_namespace;     // why there is none
  std::string emulator;                 // qemu-x86_64; empty: there is none
  Outcome control;                      // with the preload library, where there is one
  Builds builds;                        // of the program, by --rebuild
};

/// Words before a program that give it other clocks, another user, another process number.
std::vector<std::string> time_wrapper();
std::vector<std::string> user_wrapper();
std::vector<std::string> process_wrapper();

/// Whether the processor has an instruction set, by its name in /proc/cpuinfo.
bool processor_has(const std::string& feature);

/// `words`: the program and its arguments. `folder`: where locales are made. `is_asked`: whether a perturbation of this
/// name is to be run; what nobody asks for is not looked for.
Facts collect_facts(const std::vector<std::string>& words, const std::string& folder,
                    const std::function<bool(std::string_view name)>& is_asked);

}  // namespace ticktrue::shake
