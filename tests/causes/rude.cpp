// A program that misbehaves as soon as its environment changes: it crashes, hangs, prints, leaves processes behind.
// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <vector>

#include "tests/causes/game.h"

namespace {

const char* way = "";

void misbehave() {
  if (std::strcmp(way, "crash") == 0) std::raise(SIGSEGV);
  if (std::strcmp(way, "exit") == 0) std::_Exit(7);
  while (std::strcmp(way, "hang") == 0) pause();
  if (std::strcmp(way, "close") == 0)
    for (int descriptor = 0; descriptor < 256; ++descriptor)
      if (descriptor < 3 || descriptor >= 16) close(descriptor);  // descriptors 3 to 15 belong to the session
  if (std::strcmp(way, "escape") == 0) {
    const pid_t child = fork();
    if (child == 0) {
      setsid();
      for (;;) pause();
    }
    while (child > 0 && getsid(child) != child) usleep(100);  // until the child has left the process group
  }
  if (std::strcmp(way, "print") == 0) {
    const std::vector<char> line(1 << 20, 'x');
    for (int i = 0; i < 1024; ++i) std::fwrite(line.data(), 1, line.size(), stdout);
  }
}

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  if (tick == 9 && std::getenv("TICKTRUE_ADDED") != nullptr) misbehave();
  game.units[0].score += 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) way = argv[1];
  return gallery::play("rude", argc, argv, rules);
}
