// Instructions of a program that give something else in every run: rdrand, rdseed, rdtsc.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace ticktrue::shake {

/// "rdrand at draw (game.cpp:12)": each place in the file of the program, at most 16. Empty without objdump.
std::vector<std::string> find_instructions(const std::string& program);

}  // namespace ticktrue::shake
