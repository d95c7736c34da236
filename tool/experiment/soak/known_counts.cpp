// Reads, writes and compares tests/worlds/known.tsv.
// SPDX-License-Identifier: MIT
#include <sstream>

#include "tool/experiment/soak/soak_report.h"

namespace ticktrue::soak {

Result<KnownFile> parse_known(const std::string& text, const std::string& place) {
  KnownFile known;
  std::istringstream lines(text);
  std::string line;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    const std::string at = place + ":" + std::to_string(number);
    if (line.empty() || line == "cause\tcheck\tcount") continue;
    if (line[0] == '#') {
      std::istringstream words(line);
      std::string hash, seed_word, worlds_word;
      std::uint64_t seed = 0, world_count = 0;
      if (!(words >> hash >> seed_word >> seed >> worlds_word >> world_count) || seed_word != "seed") continue;
      known.seed = seed;
      known.world_count = world_count;
      continue;
    }
    std::istringstream fields(line);
    std::string cause, check, count_text;
    std::uint64_t count = 0;
    const bool is_split = std::getline(fields, cause, '\t') && std::getline(fields, check, '\t') && (fields >> count);
    if (!is_split)
      return Error{ErrorCode::corrupt, at + ": found \"" + line + "\", expected cause, check and count", ""};
    known.counts[{cause, check}] = count;
  }
  if (known.world_count == 0)
    return Error{ErrorCode::corrupt, place + ": found no line \"# seed S worlds N\"",
                 "ticktrue soak --write-known " + place + " makes the file"};
  return known;
}

std::string print_known(const KnownFile& known) {
  std::string text = "# seed " + std::to_string(known.seed) + " worlds " + std::to_string(known.world_count) +
                     "\n# Worlds that break a rule of physics, by cause: docs/soak.md. A soak of this seed fails if a "
                     "count rises.\ncause\tcheck\tcount\n";
  for (const auto& [names, count] : known.counts)
    text += names.first + "\t" + names.second + "\t" + std::to_string(count) + "\n";
  return text;
}

KnownComparison compare_known(const KnownCounts& expected, const KnownCounts& found) {
  KnownComparison comparison;
  const auto line = [](const auto& names, std::uint64_t was, std::uint64_t is) {
    return names.first + ", " + names.second + ": found " + std::to_string(is) + " worlds, expected " +
           std::to_string(was);
  };
  KnownCounts all = expected;
  all.insert(found.begin(), found.end());
  for (const auto& entry : all) {
    const auto count_in = [&](const KnownCounts& counts) {
      const auto at = counts.find(entry.first);
      return at == counts.end() ? 0 : at->second;
    };
    const std::uint64_t was = count_in(expected), is = count_in(found);
    if (is > was) comparison.rose.push_back(line(entry.first, was, is));
    if (is < was) comparison.fell.push_back(line(entry.first, was, is));
  }
  return comparison;
}

}  // namespace ticktrue::soak
