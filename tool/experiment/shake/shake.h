// The order of runs: control, all of A at once, one perturbation at a time, narrowing.
// SPDX-License-Identifier: MIT
//
// For a program that does not repeat itself, finds the sources that must be fixed to make it repeat.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tool/experiment/shake/narrow.h"
#include "tool/experiment/shake/perturbations.h"

namespace ticktrue::shake {

/// A requested perturbation, and the range in which it acts.
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
  std::optional<double> time_s;  // no run begins after this time
  bool narrows = true;
  bool each_alone = false;  // omits the common run of all A
  std::string rebuild;      // command that builds the program; empty: none
  std::function<void(std::uint64_t done, std::uint64_t expected)> progress;  // may be empty
};

enum class RowState : std::uint8_t { same, same_together, moved, not_applicable, not_run };

struct RowResult {
  Choice choice;
  RowState state = RowState::not_run;
  std::string reason;  // for not_applicable and not_run
  unsigned run_count = 0;
  double wall_s = 0;         // total of these runs
  Outcome outcome;           // moved: of the first run that differed
  unsigned moved_count = 0;  // of `repeat_count` runs under the same conditions
  unsigned repeat_count = 0;
  std::optional<Cause> cause;  // if moved and narrowed
};

/// The fixes that make the program repeat itself.
struct FixResult {
  std::vector<std::string> names;  // perturbations whose source was fixed; all are needed
  std::vector<std::string> mends;
  std::optional<Cause> cause;
  bool is_found = false;
  std::vector<std::string> not_tried;  // sources that only the preload library can fix, where it cannot be used
};

struct ShakeReport {
  std::vector<Outcome> control;
  std::vector<Outcome> control_with_shim;
  bool repeats = false;  // the control runs are equal
  std::string failure;   // why nothing could be examined; empty: examined
  std::string no_shim;   // why the preload library cannot be used; empty: usable
  std::vector<RowResult> rows;
  std::vector<std::string> together;  // perturbations that only move the program together
  Outcome together_outcome;
  FixResult fix;
  std::vector<std::string> instructions;  // of the program, out of reach of any fix: "rdrand in draw (game.cpp:12)"
  std::vector<std::string> notes;
  std::uint64_t run_count = 0;
  double wall_s = 0;
  bool ended_early = false;  // because of --time

  std::size_t count(RowState state) const;
  std::size_t moved_count(Kind kind) const;
};

/// Errors: io (files of runs).
Result<ShakeReport> run_shake(const ShakeOptions& options);

}  // namespace ticktrue::shake
