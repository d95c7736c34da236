// The known name that is nearest to an unknown one.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ticktrue::engine {

/// The candidate nearest to the typed text (a few edits away, or beginning with it); empty if none is near.
std::string_view nearest_name(std::string_view typed, const std::vector<std::string_view>& candidates);

/// "did you mean x?", or nothing if no candidate is near.
std::string suggestion(std::string_view typed, const std::vector<std::string_view>& candidates);

}  // namespace ticktrue::engine
