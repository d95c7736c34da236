// The facts of two setups that differ, as text.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "replay/format/trace.h"

namespace ticktrue::verifier {

/// A fact of the setup that differs.
struct SetupDifference {
  std::string what;
  std::string a;
  std::string b;
};

/// The keys of two setups that differ.
struct SetupKeys {
  std::vector<SetupDifference> first;  // the first of them
  std::uint64_t count = 0;             // of all
};

/// Appends the differences. Differences that prevent a comparison come first; returns their number.
std::size_t compare_setups(const replay::TraceSetup& a, const replay::TraceSetup& b, std::vector<SetupDifference>& out);

}  // namespace ticktrue::verifier
