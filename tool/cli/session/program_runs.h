// What the commands need that run a recorded program again: its words, the preload library.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace ticktrue::cli {

/// The preload library of this build or installation; empty: there is none.
std::string shim_path();

/// The program's words with the trace in them: in place of {trace}, else behind --verify at their end.
std::vector<std::string> words_with_trace(const std::vector<std::string>& words, const std::string& trace);

}  // namespace ticktrue::cli
