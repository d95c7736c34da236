// Delta debugging: a minimal subset of a list with which a test still fails.
// SPDX-License-Identifier: MIT
// Source: Zeller and Hildebrandt, "Simplifying and isolating failure-inducing input", 2002, figure 5 (ddmin).
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace ticktrue::soak {

/// A subset of the indices 0..count-1, ascending, from which no single index can be removed. `fails` is called at most
/// once with all indices. Requires: all indices together fail; `fails` returns false after the limit of tests.
std::vector<std::size_t> ddmin(std::size_t count, const std::function<bool(const std::vector<std::size_t>&)>& fails);

}  // namespace ticktrue::soak
