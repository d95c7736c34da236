// The facts of two setups that differ, as text.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "replay/format/trace.h"

namespace ticktrue::verifier {

/// One fact of the setup that differs.
struct SetupDifference {
  std::string what;
  std::string a;
  std::string b;
};

/// Appends what differs. Differences that make a comparison impossible come first; returns their number.
std::size_t compare_setups(const replay::TraceSetup& a, const replay::TraceSetup& b, std::vector<SetupDifference>& out);

}  // namespace ticktrue::verifier
