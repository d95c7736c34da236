// Finds what the save of a program forgets: one run of the program, whose session does the search (capi/unsaved/).
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
  shake::LaunchOptions launch;  // with the words of the program, the trace in them
  std::string shake_command;    // what tells why the program does not repeat itself
};

enum class ThingKind : std::uint8_t { variable, heap, stack, generator, memory };
const char* name_of(ThingKind kind);

/// A variable, or bytes of a block.
struct Thing {
  ThingKind kind = ThingKind::variable;
  std::string name;  // of a variable, as in the source
  std::string file;  // of the definition, or of the allocation; empty: not known
  unsigned line = 0;
  std::string holder;       // the variable that points to the block; empty: not known
  std::string function;     // that allocated the block
  std::string module;       // path
  std::uint64_t size = 0;   // bytes, of the variable or block
  std::uint64_t first = 0;  // byte that differs
  std::uint64_t last = 0;

  /// "combo (game.cpp:41), 4 bytes"
  std::string text() const;
};

struct UnsavedFinding {
  std::vector<Thing> things;  // the first is the one to look at
  bool is_joint = false;      // none of them is enough alone
  std::uint64_t tick = 0;     // the first at whose end a column differs
  std::uint64_t window = 0;   // ticks done at the save
  std::vector<std::string> columns;
};

/// `not_reproducible`: the same ticks from the same memory end otherwise.
enum class UnsavedVerdict : std::uint8_t { nothing, found, not_reproducible };
const char* name_of(UnsavedVerdict verdict);

struct UnsavedReport {
  UnsavedVerdict verdict = UnsavedVerdict::nothing;
  std::vector<UnsavedFinding> findings;
  std::vector<UnsavedFinding> unexplained;  // columns that moved, by nothing in the memory that was compared
  std::vector<UnsavedFinding> not_loaded;   // columns that load does not bring back
  std::vector<Thing> harmless;              // differ behind load, and move no column
  std::uint64_t tick_count = 0;
  std::uint64_t window_count = 0;
  std::uint64_t trial_count = 0;
  std::vector<std::string> notes;
  std::vector<std::string> next;  // what to do, and commands
  shake::Outcome outcome;
};

/// Errors: io, usage (nothing can be compared).
Result<UnsavedReport> run_unsaved(const UnsavedOptions& options);

}  // namespace ticktrue::unsaved
