// The words of a command that was given as one text, and the trace among them.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace ticktrue::verifier {

/// Splits as a shell does: at blanks, with '...', "..." and backslashes. No shell runs: what a shell would act on
/// (variables, pipes, redirections) is refused outside of quotes. Errors: usage.
Result<std::vector<std::string>> split_command(std::string_view text);

/// The words with the trace in place of each {} and {trace}; without these, behind --verify at the end. A word is never
/// split, whatever is in the name.
std::vector<std::string> with_trace(std::vector<std::string> words, const std::string& trace);

}  // namespace ticktrue::verifier
