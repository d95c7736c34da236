// Where in a program a call stands: function and line, as far as debug information tells.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "shim/page.h"

namespace ticktrue::shake {

struct CallSite {
  std::string function;  // empty: not known
  std::string file;      // source; empty: not known
  unsigned line = 0;
  std::string module;  // path
  std::uint64_t offset = 0;

  /// "Ship::steer (ship.cpp:40)"; without names "game+0x1234".
  std::string text() const;
  /// "Ship::steer"; without names "game+0x1234".
  std::string name() const;
};

/// The innermost frame that is of the program and not of the C or C++ library.
CallSite call_site(const shim::Page& page, const shim::CallRecord& record);
/// Of one return address.
CallSite call_site(const shim::Page& page, std::uint32_t module, std::uint64_t offset);

/// Of return addresses in one file, which was mapped at `base`: each as the functions of the program that it stands in,
/// the innermost first. None for the C and C++ libraries.
std::vector<std::vector<CallSite>> call_frames(const std::string& module, std::uint64_t base,
                                               const std::vector<std::uint64_t>& offsets);

/// The place of an instruction, by its address in the file.
std::string address_text(const std::string& module, std::uint64_t address);

/// Instructions of a program that give something else in every run (rdrand, rdseed, rdtsc): "rdrand at draw
/// (game.cpp:12)", at most 16. Empty without objdump.
std::vector<std::string> find_instructions(const std::string& program);

}  // namespace ticktrue::shake
