// The place of a call in a program: function and line, as far as debug information is available.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "shim/page.h"

namespace ticktrue::shake {

struct CallSite {
  std::string function;  // empty: unknown
  std::string file;      // source file; empty: unknown
  unsigned line = 0;
  std::string module;  // path
  std::uint64_t offset = 0;

  /// "Ship::steer (ship.cpp:40)"; without names "game+0x1234".
  std::string text() const;
  /// "Ship::steer"; without names "game+0x1234".
  std::string name() const;
};

/// The innermost frame in the program, outside the C and C++ libraries.
CallSite call_site(const shim::Page& page, const shim::CallRecord& record);
/// The call site of one return address.
CallSite call_site(const shim::Page& page, std::uint32_t module, std::uint64_t offset);

/// The call sites of return addresses in one file that was mapped at `base`. Each address gives the functions of the
/// program that contain the call, innermost first. Empty for the C and C++ libraries.
std::vector<std::vector<CallSite>> call_frames(const std::string& module, std::uint64_t base,
                                               const std::vector<std::uint64_t>& offsets);

/// The place of an instruction, by its address in the file.
std::string address_text(const std::string& module, std::uint64_t address);

/// Instructions of a program whose results differ in every run (rdrand, rdseed, rdtsc), at most 16: "rdrand at draw
/// (game.cpp:12)". Empty without objdump.
std::vector<std::string> find_instructions(const std::string& program);

}  // namespace ticktrue::shake
