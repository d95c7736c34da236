// Clean: starts a child process, closes descriptors that are not its own, handles signals.
// SPDX-License-Identifier: MIT
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "tests/causes/game.h"

namespace {

volatile std::sig_atomic_t child_count = 0;

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  if (tick == 0) {
    std::signal(SIGCHLD, [](int) { child_count = child_count + 1; });
    for (int descriptor = 20; descriptor < 64; ++descriptor) close(descriptor);
  }
  if (tick % 30 == 11) {
    const pid_t child = fork();
    if (child == 0) {
      void* block = std::malloc(1000);
      std::free(block);
      _exit(block != nullptr ? 3 : 4);
    }
    int status = 0;
    while (child > 0 && waitpid(child, &status, 0) < 0) {
    }
    game.units[6].score += WEXITSTATUS(status);
  }
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("processes", argc, argv, rules);
}
