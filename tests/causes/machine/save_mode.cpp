// Cause: the game checks whether its save file is public. The umask of the user decides.
// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick != 25) return;
  char folder[] = "/tmp/save-XXXXXX";
  if (mkdtemp(folder) == nullptr) return;
  char path[64];
  std::snprintf(path, sizeof path, "%s/game.save", folder);
  const int file = open(path, O_CREAT | O_WRONLY, 0666);
  struct stat facts {};
  if (fstat(file, &facts) == 0 && !is_mended) game.units[4].score += facts.st_mode & 0777;
  close(file);
  unlink(path);
  rmdir(folder);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("save_mode", argc, argv, rules);
}
