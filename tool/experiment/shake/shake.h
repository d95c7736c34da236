// The order of runs: control, all of A at once, one at a time, narrowing.
// SPDX-License-Identifier: MIT
//
// For a program that does not repeat itself: what has to be held still so that it does.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tool/experiment/shake/narrow.h"
#include "tool/experiment/shake/perturbations.h"

namespace ticktrue::shake {

/// A perturbation that was asked for, and where it is to act.
struct Choice {
  const Perturbation* perturbation = nullptr;
  std::optional<shim::CallRange> calls;
  std::optional<std::pair<std::uint64_t, std::uint64_t>> ticks;  // both included
};

struct ShakeOptions {
  LaunchOptions launch;
  std::vector<Choice> choices;
  unsigned seed_count = 1;
  unsigned thread_count = 1;
  std::optional<double> time_s;  // no run begins later
  bool narrows = true;
  bool each_alone = false;  // no run of all A at once
  std::string rebuild;      // command that builds the program; empty: there is none
  std::function<void(std::uint64_t done, std::uint64_t expected)> progress;  // may be empty
};

enum class RowState : std::uint8_t { same, same_together, moved, not_applicable, not_run };

struct RowResult {
  Choice choice;
  RowState state = RowState::not_run;
  std::string reason;  // of not_applicable and not_run
  unsigned run_count = 0;
  double wall_s = 0;         // of these runs together
  Outcome outcome;           // moved: of the first run that was another
  unsigned moved_count = 0;  // of `repeat_count` runs under those conditions
  unsigned repeat_count = 0;
  std::optional<Cause> cause;  // moved, and narrowed
};

/// What holds the program still.
struct FixResult {
  std::vector<std::string> names;  // perturbations whose source was fixed; all of them together were needed
  std::vector<std::string> mends;
  std::optional<Cause> cause;
  bool is_found = false;
};

struct ShakeReport {
  std::vector<Outcome> control;
  std::vector<Outcome> control_with_shim;
  bool repeats = false;  // the control
  std::string failure;   // why nothing could be examined; empty: something was
  std::vector<RowResult> rows;
  std::vector<std::string> together;  // only these together move the program
  Outcome together_outcome;
  FixResult fix;
  std::vector<std::string> instructions;  // of the program that no fix reaches: "rdrand in draw (game.cpp:12)"
  std::vector<std::string> notes;
  std::uint64_t run_count = 0;
  double wall_s = 0;
  bool ended_early = false;  // by --time

  std::size_t count(RowState state) const;
  std::size_t moved_count(Kind kind) const;
};

/// Errors: io (files of runs).
Result<ShakeReport> run_shake(const ShakeOptions& options);

}  // namespace ticktrue::shake
