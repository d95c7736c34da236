// Replaces the name of a file in texts and in commands.
// SPDX-License-Identifier: MIT
#include "verifier/store/renamed_report.h"

#include <cctype>
#include <utility>
#include <vector>

namespace ticktrue::verifier {
namespace {

bool is_in_path(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '/' || c == '_' || c == '-' || c == '.';
}

/// Replaces `from` where it is a whole path, and not where it is a part of a longer path.
void replace_path(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at)) {
    const std::size_t end = at + from.size();
    const bool is_whole = (at == 0 || !is_in_path(text[at - 1])) && (end == text.size() || !is_in_path(text[end]));
    if (is_whole) text.replace(at, from.size(), to);
    at += is_whole ? to.size() : 1;
  }
}

}  // namespace

void rename_file(Report& report, const std::string& file) {
  const std::string former = std::exchange(report.file, file);
  if (former.empty() || former == file) return;
  for (std::string& command : report.again) replace_path(command, shell_word(former), shell_word(file));
  replace_path(report.reason, former, file);
  replace_path(report.hint, former, file);
  for (std::vector<std::string>* lines : {&report.warnings, &report.notes})
    for (std::string& line : *lines) replace_path(line, former, file);
  if (report.end) replace_path(report.end->tail.message, former, file);
  if (report.verdict != Verdict::match)
    report.notes.push_back("found first in " + former + ", a file of the same bytes");
}

}  // namespace ticktrue::verifier
