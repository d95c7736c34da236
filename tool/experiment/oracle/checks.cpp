// Names of checks, and the text form of variants.
// SPDX-License-Identifier: MIT
#include "tool/experiment/oracle/checks.h"

#include <charconv>

namespace ticktrue::soak {

std::string variant_text(const Variant& variant) {
  const CheckInfo& info = check_table[static_cast<std::size_t>(variant.check)];
  if (info.value.empty()) return std::string(info.name);
  return std::string(info.name) + "=" + std::to_string(variant.value);
}

CheckSelection CheckSelection::all() {
  CheckSelection selection;
  selection.wanted.fill(true);
  return selection;
}

Result<CheckSelection> parse_checks(const std::vector<std::string>& words) {
  CheckSelection selection;
  for (const std::string& word : words) {
    const std::size_t sign = word.find('=');
    const CheckInfo* found = nullptr;
    for (const CheckInfo& info : check_table)
      if (info.name == word.substr(0, sign)) found = &info;
    if (found == nullptr) {
      std::string names;
      for (const CheckInfo& info : check_table) names += (names.empty() ? "" : ", ") + std::string(info.name);
      return Error{ErrorCode::usage, "--checks: found \"" + word + "\", expected names of checks", "one of: " + names};
    }
    selection.wanted[static_cast<std::size_t>(found->kind)] = true;
    const bool is_of_base_run = found->kind == CheckKind::finite || found->kind == CheckKind::zeros;
    if (sign == std::string::npos && found->value.empty() && !is_of_base_run)
      selection.only.push_back({found->kind, 0});
    if (sign == std::string::npos) continue;
    std::uint64_t value = 0;
    const char* end = word.data() + word.size();
    const auto [last, failed] = std::from_chars(word.data() + sign + 1, end, value);
    if (failed != std::errc() || last != end || found->value.empty())
      return Error{ErrorCode::usage,
                   "--checks: found \"" + word + "\", expected " + std::string(found->name) +
                       (found->value.empty() ? " without a number" : "=N"),
                   found->value.empty() ? "" : "N: " + std::string(found->value)};
    selection.only.push_back({found->kind, value});
  }
  return selection;
}

}  // namespace ticktrue::soak
