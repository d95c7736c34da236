// Verdicts, exit codes, and text for several printers.
// SPDX-License-Identifier: MIT
#include "verifier/report/report.h"

#include <algorithm>

#include "base/count_text.h"
#include "verifier/report/fact_differences.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t name_shown_max = 4;  // names of marks in a line

std::string times(std::uint64_t count) {
  return count == 0 ? "never" : count_text(count, "time");
}

std::string name_text(const NameDifference& name, const char* expected_name) {
  if (name.expected == name.got) return name.name + " " + times(name.got) + " with other values";
  return name.name + " " + times(name.got) + ", " + expected_name + " " +
         (name.expected == 0 ? "never" : std::to_string(name.expected));
}

}  // namespace

const VerdictInfo& verdict_info(Verdict verdict) {
  const auto found =
      std::find_if(verdicts.begin(), verdicts.end(), [&](const VerdictInfo& info) { return info.verdict == verdict; });
  TICKTRUE_ASSERT(found != verdicts.end());
  return *found;
}

Verdict verdict_of_open_error(ErrorCode code) {
  switch (code) {
    case ErrorCode::corrupt:
      return Verdict::damaged;
    case ErrorCode::truncated:
      return Verdict::incomplete;
    case ErrorCode::incompatible:
    case ErrorCode::unsupported:
    case ErrorCode::limit:
    case ErrorCode::invalid_scene:
    case ErrorCode::invalid_input:
      return Verdict::not_comparable;
    case ErrorCode::io:
    case ErrorCode::usage:
    case ErrorCode::inconsistent:
      return Verdict::error;
  }
  return Verdict::error;
}

int git_bisect_exit_code(int exit_code) {
  constexpr int skip = 125;
  const bool judged = exit_code == exit_ok || exit_code == exit_finding || exit_code == exit_incomplete;
  return judged ? exit_code : skip;
}

int Report::exit_code(bool allow_truncated) const {
  const bool only_cut = verdict == Verdict::incomplete && ticks_compared > 0 && end &&
                        end->tail.condition == replay::TraceCondition::truncated;
  if (allow_truncated && only_cut) return exit_ok;
  return verdict_info(verdict).exit_code;
}

void set_salvaged(TraceEnd& end, std::optional<std::uint64_t> salvaged_from) {
  const bool goes_on = salvaged_from && *salvaged_from < end.tail.ticks_intact;
  if (goes_on && end.tail.condition == replay::TraceCondition::damaged) end.salvaged_from = salvaged_from;
}

std::string shell_word(const std::string& text) {
  constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:=+,@%";
  if (!text.empty() && text.find_first_not_of(plain) == std::string::npos) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string marks_text(const MarksDifference& difference, const char* expected_name) {
  if (difference.names.empty()) return "the same marks in another order";
  std::string text;
  const std::size_t shown = std::min(difference.names.size(), name_shown_max);
  for (std::size_t i = 0; i < shown; ++i) text += (i > 0 ? "; " : "") + name_text(difference.names[i], expected_name);
  if (difference.name_count > shown) text += "; and " + count_text(difference.name_count - shown, "more name");
  return text;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::string facts_line(const replay::BuildFacts& facts) {
  // The facts of every recorder, in the form of build_line(), then others with their names.
  std::string known, others;
  for (const char* name : {"version", "commit", "compiler", "flags", "target"})
    for (const auto& [found, value] : facts) {
      if (found != name || value.empty()) continue;
      known += known.empty() ? "" : " ";
      known += found == "version" ? "ticktrue " + value : found == "commit" ? "(" + value + ")" : value;
    }
  for (const auto& [name, value] : facts)
    if (name != "version" && name != "commit" && name != "compiler" && name != "flags" && name != "target" &&
        !is_program_fact(name))
      others += (others.empty() && known.empty() ? "" : ", ") + name + " " + value;
  return known + others;
}

}  // namespace ticktrue::verifier
