// Delta debugging: the smallest part of a list with which a test still fails.
// SPDX-License-Identifier: MIT
// Source: Zeller and Hildebrandt, "Simplifying and isolating failure-inducing input", 2002, figure 5 (ddmin).
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace ticktrue::verifier::soak {

/// Indices of 0..count-1 to keep, ascending: no single one of them can be left out. `fails` is never asked twice about
/// all of them. Requires: all together fail, and `fails` answers false once no more tests may be made.
std::vector<std::size_t> ddmin(std::size_t count, const std::function<bool(const std::vector<std::size_t>&)>& fails);

}  // namespace ticktrue::verifier::soak
