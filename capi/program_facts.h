// What is known about the build of the program that calls the library, as build facts of a trace.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "replay/format/trace.h"

namespace ticktrue::capi {

class ProgramFacts {
 public:
  /// `build`: the program's own text about its build; may be empty.
  explicit ProgramFacts(std::string build = "") : build_(std::move(build)) {}

  /// Adds the facts of one unit, one "name=value" per line: as caller.NAME, or as caller.UNIT.NAME if the unit has a
  /// name.
  /// Errors: usage (a line without '=', a wrong name, a repeated unit or name), limit.
  Status add(std::string_view unit, const char* text);

  /// All facts of a session: of the library, the program, the floats of this thread and the units.
  replay::BuildFacts all() const;

 private:
  std::string build_;
  std::vector<std::string> units_;
  replay::BuildFacts units_facts_;
};

/// The build id of the program's file in hexadecimal, from the note of an ELF file; empty: the file has none.
std::string program_build_id();

/// The words that started this program, quoted for a shell, as `ticktrue shake` takes them. `--verify TRACE` is left
/// out. Other occurrences of the trace become {trace}. The options `left_out` are removed with their values. Empty:
/// unknown.
std::string program_command(const std::string& trace, std::span<const std::string_view> left_out = {});

}  // namespace ticktrue::capi
