// The words of a command that was given as one text, and the marks among them: the trace, a seed.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace ticktrue::verifier {

/// Splits as a shell does: at blanks, with '...', "..." and backslashes. No shell runs: what a shell would act on
/// (variables, pipes, redirections) is refused outside of quotes. `option`: what messages begin with. Errors: usage.
Result<std::vector<std::string>> split_command(std::string_view text, std::string_view option = "--command");

/// A mark within words, such as {seed}, and what takes its place.
struct CommandMark {
  std::string_view mark;
  std::string text;
};
/// Replaces the marks, each wherever it stands. What takes the place of a mark is not searched for marks, and a word is
/// never split. Returns which marks were there. Requires: each mark begins with {.
std::vector<bool> replace_marks(std::vector<std::string>& words, std::span<const CommandMark> marks);

/// The words as one line for a shell; marks that are whole words stay without quotes.
std::string command_line_of(const std::vector<std::string>& words);

/// The words with the trace in place of each {} and {trace}; without these, behind --verify at the end. A word is never
/// split, whatever is in the name.
std::vector<std::string> with_trace(std::vector<std::string> words, const std::string& trace);

}  // namespace ticktrue::verifier
