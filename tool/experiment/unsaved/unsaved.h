// Finds state that the save of a program omits. The program runs once, and its session does the search (capi/unsaved/).
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "tool/experiment/shake/launch.h"

namespace ticktrue::unsaved {

struct UnsavedOptions {
  std::string trace;
  shake::LaunchOptions launch;  // the words are the program and its arguments, with the trace
  std::string shake_command;    // command that shows why the program does not repeat itself
};

enum class ThingKind : std::uint8_t { variable, heap, stack, generator, memory };
const char* name_of(ThingKind kind);

/// A variable, or a byte range of a block.
struct Thing {
  ThingKind kind = ThingKind::variable;
  std::string name;  // of a variable, as in the source
  std::string file;  // of the definition or of the allocation; empty: unknown
  unsigned line = 0;
  std::string holder;       // variable that points to the block; empty: unknown
  std::string function;     // function that allocated the block
  std::string module;       // path
  std::uint64_t size = 0;   // bytes of the variable or block
  std::uint64_t first = 0;  // first byte that differs
  std::uint64_t last = 0;

  /// "combo (game.cpp:41), 4 bytes"
  std::string text() const;
};

struct UnsavedFinding {
  std::vector<Thing> things;  // the most important thing is first
  bool is_joint = false;      // the things only have an effect together
  std::uint64_t tick = 0;     // the first tick at whose end a column differs
  std::uint64_t window = 0;   // ticks done when the state was saved
  std::vector<std::string> columns;
};

/// `not_reproducible`: the same ticks from the same memory end in different states.
enum class UnsavedVerdict : std::uint8_t { nothing, found, not_reproducible };
const char* name_of(UnsavedVerdict verdict);

struct UnsavedReport {
  UnsavedVerdict verdict = UnsavedVerdict::nothing;
  std::vector<UnsavedFinding> findings;
  std::vector<UnsavedFinding> unexplained;  // columns that moved without a cause in the compared memory
  std::vector<UnsavedFinding> not_loaded;   // columns that load does not restore
  std::vector<Thing> harmless;              // things that differ after load, and move no column
  std::uint64_t tick_count = 0;
  std::uint64_t window_count = 0;
  std::uint64_t trial_count = 0;
  std::vector<std::string> notes;
  std::vector<std::string> next;  // next steps and commands
  shake::Outcome outcome;
};

/// Errors: io, usage (nothing to compare).
Result<UnsavedReport> run_unsaved(const UnsavedOptions& options);

}  // namespace ticktrue::unsaved
