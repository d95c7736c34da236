// What is known of the build of the program that calls the library, as build facts of a trace.
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
  /// `build`: what the program says of its build in a text of its own; may be empty.
  explicit ProgramFacts(std::string build = "") : build_(std::move(build)) {}

  /// Adds the facts of one unit, "name=value" a line: as caller.NAME, of a named unit as caller.UNIT.NAME.
  /// Errors: usage (a line without '=', a wrong name, a unit or a name that stands twice), limit.
  Status add(std::string_view unit, const char* text);

  /// All facts of a session: of the library, the program, the floats of this thread and the units.
  replay::BuildFacts all() const;

 private:
  std::string build_;
  std::vector<std::string> units_;
  replay::BuildFacts units_facts_;
};

/// The build id of the program's file in hexadecimal, from the note of an ELF file; empty where it has none.
std::string program_build_id();

/// The words that started this program, for a shell, as `ticktrue shake` wants them: without `--verify TRACE`, and with
/// {trace} where the trace stands elsewhere. The options `left_out` go with their values. Empty: not known.
std::string program_command(const std::string& trace, std::span<const std::string_view> left_out = {});

}  // namespace ticktrue::capi
