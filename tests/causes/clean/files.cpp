// Clean: lists its own folder in sorted order, reads the environment and prints; none of this reaches the state.
// SPDX-License-Identifier: MIT
#include <dirent.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  std::vector<std::string> names;
  DIR* folder = opendir("/usr/share");
  while (const dirent* entry = folder != nullptr ? readdir(folder) : nullptr) names.emplace_back(entry->d_name);
  if (folder != nullptr) closedir(folder);
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) game.units[1].score += name == "." ? 1 : 0;
  std::uint32_t salt = 0;
  if (getrandom(&salt, sizeof salt, 0) == sizeof salt && tick == 30)
    std::fprintf(stderr, "session %x in %s\n", salt, std::getenv("HOME") != nullptr ? "a home" : "no home");
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("files", argc, argv, rules);
}
