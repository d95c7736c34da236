// Names the memory that the session found: variables by symbol, blocks by the allocating function.
// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tool/experiment/shake/call_site.h"
#include "tool/experiment/unsaved/unsaved.h"

namespace ticktrue::unsaved {

class ThingNames {
 public:
  /// Names a unit in the log of the session. Requires: the fields of capi/unsaved/probe_log.cpp.
  Thing thing(const nlohmann::ordered_json& unit);
  /// Names several units. Units of one variable or block are merged, and the most important thing is first.
  std::vector<Thing> things(const nlohmann::ordered_json& units);

 private:
  struct SourceLine {
    std::string file;
    unsigned line = 0;
  };
  const std::map<std::string, SourceLine>& lines_of(const std::string& module);
  const std::vector<shake::CallSite>& frames(const std::string& module, std::uint64_t base, std::uint64_t offset);

  std::map<std::string, std::map<std::string, SourceLine>> lines_;  // [module][symbol]
  std::map<std::pair<std::string, std::uint64_t>, std::vector<shake::CallSite>> frames_;
};

/// Whether both are the same variable, or bytes of the same kind of block.
bool is_same_place(const Thing& a, const Thing& b);
/// Extends the byte range of `into` by that of `from`.
void merge(Thing& into, const Thing& from);

}  // namespace ticktrue::unsaved
