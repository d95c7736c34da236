// The builds of two programs, as a report tells them: a line for each, and the facts that differ.
// SPDX-License-Identifier: MIT
//
// Facts whose names begin with caller. or program. are about the program that recorded or verifies a session, those
// with plugin. about the library of a plug-in; all others are about ticktrue. caller.NAME is a fact of the unit that
// opened the session, caller.UNIT.NAME one of a further unit.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "replay/format/trace.h"

namespace ticktrue::verifier {

/// Whether the fact is about the program or plug-in, not about ticktrue.
bool is_program_fact(std::string_view name);

/// Of caller.UNIT.NAME the unit; of any other fact nothing.
std::string fact_unit(std::string_view name);

/// One line for the program, or nothing where no fact tells of it.
std::string program_line(const replay::BuildFacts& facts);

/// A fact that two programs do not share.
struct FactDifference {
  std::string name;  // without the leading "caller."
  std::string a;
  std::string b;
  bool changes_bits = false;  // floats can differ because of it
};

/// Those that change bits first. Empty where one side tells nothing of its program.
std::vector<FactDifference> fact_differences(const replay::BuildFacts& a, const replay::BuildFacts& b);
/// "fused: recorded no, here yes (changes bits)".
std::string difference_line(const FactDifference& difference, const std::string& a_name, const std::string& b_name);

}  // namespace ticktrue::verifier
