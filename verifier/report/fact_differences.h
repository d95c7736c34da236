// The builds of two programs in a report: one line each, and the facts that differ.
// SPDX-License-Identifier: MIT
//
// Facts with the prefix caller. or program. are about the program that records or verifies a session. Facts with the
// prefix plugin. are about the library of a plug-in. All others are about ticktrue. caller.NAME is a fact of the unit
// that opened the session, caller.UNIT.NAME a fact of another unit.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "replay/format/trace.h"

namespace ticktrue::verifier {

/// Whether the fact is about the program or plug-in, not about ticktrue.
bool is_program_fact(std::string_view name);

/// The unit in caller.UNIT.NAME; nothing for any other fact.
std::string fact_unit(std::string_view name);

/// One line about the program; empty: no fact is about it.
std::string program_line(const replay::BuildFacts& facts);

/// A fact that differs between two programs.
struct FactDifference {
  std::string name;  // without the leading "caller."
  std::string a;
  std::string b;
  bool changes_bits = false;  // floats can differ because of it
};

/// Differences that change bits come first. Empty: one side has no fact about its program.
std::vector<FactDifference> fact_differences(const replay::BuildFacts& a, const replay::BuildFacts& b);
/// "fused: recorded no, here yes (changes bits)".
std::string difference_line(const FactDifference& difference, const std::string& a_name, const std::string& b_name);

}  // namespace ticktrue::verifier
