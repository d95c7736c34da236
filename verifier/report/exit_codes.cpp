// Exit codes of errors, and the worst of several.
// SPDX-License-Identifier: MIT
#include "verifier/report/exit_codes.h"

#include <array>

namespace ticktrue::verifier {

int exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::io:
    case ErrorCode::usage:
    case ErrorCode::invalid_scene:
    case ErrorCode::invalid_input:
    case ErrorCode::limit:
      return exit_usage;
    case ErrorCode::inconsistent:
      return exit_finding;
    case ErrorCode::corrupt:
      return exit_damaged;
    case ErrorCode::truncated:
      return exit_incomplete;
    case ErrorCode::incompatible:
    case ErrorCode::unsupported:
      return exit_not_comparable;
  }
  return exit_usage;
}

int worst_exit_code(std::span<const int> codes) {
  constexpr std::array<int, 7> worst_first{
      exit_usage, exit_finding, exit_not_reproducible, exit_damaged, exit_not_comparable, exit_incomplete, exit_ok};
  for (const int candidate : worst_first)
    for (const int code : codes)
      if (code == candidate) return candidate;
  return exit_ok;
}

}  // namespace ticktrue::verifier
