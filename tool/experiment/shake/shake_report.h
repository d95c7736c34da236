// The output of a shake: text, JSON, JUnit, annotations.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "tool/experiment/shake/shake.h"

namespace ticktrue::shake {

/// Facts for the report: the shaken trace and program, and the classes that make the shake fail.
struct ShakeSubject {
  std::string trace;
  std::uint64_t tick_count = 0;
  std::vector<std::string> words;  // the command as the user gave it
  bool fails_for_b = false;
};

/// Exit code 0, 1, 2 or 6.
int exit_code(const ShakeReport& report, const ShakeSubject& subject);

std::string shake_text(const ShakeReport& report, const ShakeSubject& subject);
/// Schema ticktrue.shake/2.
std::string shake_json(const ShakeReport& report, const ShakeSubject& subject);
/// One test case for each perturbation. Class B and C are failures only if they make the shake fail.
std::string shake_junit(const ShakeReport& report, const ShakeSubject& subject);
/// Workflow commands of GitHub Actions.
std::string shake_github(const ShakeReport& report, const ShakeSubject& subject);

}  // namespace ticktrue::shake
