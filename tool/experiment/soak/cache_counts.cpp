// Reading, writing and comparing tests/worlds/cache_counts.tsv.
// SPDX-License-Identifier: MIT
#include "tool/experiment/soak/cache_counts.h"

#include <sstream>

namespace ticktrue::verifier::soak {
namespace {

const char* const renew_hint =
    "if the structure is meant to be used again that often: `ticktrue soak --hashes H --write-cache-counts C`";

std::string counts_text(engine::CacheCounts counts) {
  return std::to_string(counts.hits) + " hits and " + std::to_string(counts.invalidations) + " invalidations";
}

}  // namespace

std::string print_cache_counts(const engine::CacheReport& counts) {
  std::string text =
      "# How often each cached structure was used again, over the worlds of hashes.tsv (docs/soak.md).\n"
      "# Written by `ticktrue soak --hashes H --write-cache-counts C`.\n# cache\thits\tinvalidations\n";
  for (std::size_t i = 0; i < counts.size(); ++i)
    text += std::string(engine::cache_kinds[i].name) + "\t" + std::to_string(counts[i].hits) + "\t" +
            std::to_string(counts[i].invalidations) + "\n";
  return text;
}

Result<engine::CacheReport> parse_cache_counts(const std::string& text, const std::string& place) {
  engine::CacheReport counts;
  std::istringstream lines(text);
  std::string line;
  std::size_t found = 0;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    std::string name;
    engine::CacheCounts read;
    const bool is_row = (fields >> name >> read.hits >> read.invalidations) && (fields >> std::ws).eof();
    if (!is_row || found == counts.size() || name != engine::cache_kinds[found].name)
      return Error{
          ErrorCode::corrupt,
          place + ":" + std::to_string(number) + ": found \"" + line + "\", expected " +
              (found == counts.size() ? std::string("no more lines")
                                      : std::string(engine::cache_kinds[found].name) + ", hits and invalidations"),
          renew_hint};
    counts[found++] = read;
  }
  if (found < counts.size())
    return Error{
        ErrorCode::corrupt,
        place + ": found " + std::to_string(found) + " cached structures, expected " + std::to_string(counts.size()),
        renew_hint};
  return counts;
}

Status compare_cache_counts(const engine::CacheReport& expected, const engine::CacheReport& found,
                            const std::string& place) {
  for (std::size_t i = 0; i < expected.size(); ++i)
    if (expected[i].hits != found[i].hits || expected[i].invalidations != found[i].invalidations)
      return Error{ErrorCode::inconsistent,
                   place + ": " + std::string(engine::cache_kinds[i].name) + ": found " + counts_text(found[i]) +
                       ", expected " + counts_text(expected[i]),
                   renew_hint};
  return {};
}

}  // namespace ticktrue::verifier::soak
