// The output of a soak as text and JSON.
// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tool/experiment/soak/soak.h"

namespace ticktrue::soak {

/// Counts of physics violations that must not rise: (cause, check) to worlds.
using KnownCounts = std::map<std::pair<std::string, std::string>, std::uint64_t>;

struct KnownFile {
  std::uint64_t seed = 0;
  std::uint64_t world_count = 0;  // number of first worlds of that seed
  KnownCounts counts;
};
/// tests/worlds/known.tsv: a line "# seed S worlds N", then cause, check and count, separated by tabs. Errors: corrupt.
Result<KnownFile> parse_known(const std::string& text, const std::string& place);
std::string print_known(const KnownFile& known);

/// Lines about counts that rose (`rose`) or fell (`fell`).
struct KnownComparison {
  std::vector<std::string> rose;
  std::vector<std::string> fell;
};
KnownComparison compare_known(const KnownCounts& expected, const KnownCounts& found);

/// Names of caches without a hit after `hits_expected_after` worlds. A cache without hits is not examined.
std::vector<std::string> never_hit(const SoakOptions& options, const SoakCounters& counters);

/// The facts of the JSON as text.
std::string soak_text(const SoakOptions& options, const SoakReport& report, const KnownComparison& known);
std::string soak_json(const SoakOptions& options, const SoakReport& report, const KnownComparison& known);

}  // namespace ticktrue::soak
