// Cause: units get their kind in the order in which a directory lists its files.
// SPDX-License-Identifier: MIT
#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/causes/game.h"

namespace {

/// Makes files "unit_A" to "unit_H", like an installation.
std::string make_assets() {
  std::string folder = "/tmp/ticktrue-assets-XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) return "/";
  for (char name = 'A'; name < 'A' + 8; ++name)
    if (std::FILE* file = std::fopen((folder + "/unit_" + name).c_str(), "w")) std::fclose(file);
  return folder;
}

std::vector<std::string> list(const std::string& folder) {
  std::vector<std::string> names;
  DIR* directory = opendir(folder.c_str());
  while (const dirent* entry = directory != nullptr ? readdir(directory) : nullptr)
    if (entry->d_name[0] != '.') names.emplace_back(entry->d_name);
  if (directory != nullptr) closedir(directory);
  return names;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick != 3) return;
  const std::string folder = make_assets();
  std::vector<std::string> names = list(folder);
  if (is_mended) std::sort(names.begin(), names.end());
  for (std::size_t i = 0; i < names.size() && i < gallery::unit_count; ++i) game.units[i].score = names[i].back() - 'A';
  for (const std::string& name : names) unlink((folder + "/" + name).c_str());
  rmdir(folder.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("directory_order", argc, argv, rules);
}
