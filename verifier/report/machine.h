// What this machine is: CPU, the instruction set this build computes with, the floating point control word.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace ticktrue::verifier {

struct MachineFacts {
  std::string cpu;              // "AMD EPYC ..."; empty where the system does not say
  std::string instruction_set;  // the widest vector instructions the engine was compiled for
  std::string control_word;     // of the calling thread: "MXCSR 00001f80"; empty where the CPU has none
};

MachineFacts machine_facts();

}  // namespace ticktrue::verifier
