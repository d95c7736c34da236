// A description of this machine: CPU, the instruction set of this build, the floating point control word.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace ticktrue::verifier {

struct MachineFacts {
  std::string cpu;              // "AMD EPYC ..."; empty: unknown
  std::string instruction_set;  // the widest vector instructions the engine was compiled for
  std::string control_word;     // of the calling thread: "MXCSR 00001f80"; empty: the CPU has none
};

MachineFacts machine_facts();

}  // namespace ticktrue::verifier
