// The words of a command in one text, and the marks among them: the trace, a seed.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace ticktrue::verifier {

/// Splits as a shell does: at blanks, with '...', "..." and backslashes. No shell runs: unquoted shell syntax
/// (variables, pipes, redirections) is refused. `option`: the begin of messages. Errors: usage.
Result<std::vector<std::string>> split_command(std::string_view text, std::string_view option = "--command");

/// A mark inside words, such as {seed}, and its replacement.
struct CommandMark {
  std::string_view mark;
  std::string text;
};
/// Replaces every occurrence of the marks. Replacements are not searched for marks, and a word is never split. Returns
/// which marks occurred. Requires: each mark begins with {.
std::vector<bool> replace_marks(std::vector<std::string>& words, std::span<const CommandMark> marks);

/// The words as one line for a shell. Marks that are whole words are not quoted.
std::string command_line_of(const std::vector<std::string>& words);

/// The words with the trace in place of each {} and {trace}. Without such a mark, `--verify TRACE` is appended. A word
/// is never split, whatever the name of the trace is.
std::vector<std::string> with_trace(std::vector<std::string> words, const std::string& trace);

}  // namespace ticktrue::verifier
