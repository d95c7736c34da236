// Reads, writes and compares tests/worlds/cache_counts.tsv.
// SPDX-License-Identifier: MIT
#include "tool/experiment/soak/cache_counts.h"

#include <sstream>

#include "engine/builtin_scenes/builtin_scenes.h"

namespace ticktrue::soak {
namespace {

struct CountedScene {
  const char* name;
  int tick_count;
};
// Scenes with bodies that rest within their margins, contacts for more than two blocks of islands, and enough joints
// for a wavefront sweep.
constexpr CountedScene counted_scenes[] = {
    {"pyramid?base=24&substeps=4", 90},
    {"mixed_pile?bodies=150&substeps=4", 150},
    {"many_pyramids?rows=6&columns=8&substeps=4", 12},
    {"joint_grid?columns=30", 20},
};

const char* const renew_hint =
    "if the structure is meant to be used again that often: `ticktrue soak --hashes H --write-cache-counts C`";

std::string counts_text(engine::CacheCounts counts) {
  return std::to_string(counts.hits) + " hits and " + std::to_string(counts.invalidations) + " invalidations";
}

}  // namespace

Status add_counts_of_scenes(engine::CacheReport& counts) {
  for (const CountedScene& counted : counted_scenes) {
    const auto scene = engine::make_builtin_scene(counted.name);
    if (!scene) return scene.error();
    const auto made = engine::make_engine(*scene);
    if (!made) return made.error();
    for (int tick = 0; tick < counted.tick_count; ++tick)
      if (const Status did = (*made)->step({scene->settings.dt, {}}, nullptr); !did) return did;
    engine::add_counts(counts, (*made)->cache_report());
  }
  return {};
}

std::string print_cache_counts(const engine::CacheReport& counts) {
  std::string text =
      "# How often each cached structure was used again, over the worlds of hashes.tsv and a few scenes "
      "(docs/soak.md).\n"
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

}  // namespace ticktrue::soak
