// Cause: the size of a cache is the system's limit of open files, and cached units are simulated first.
// SPDX-License-Identifier: MIT
#include <sys/resource.h>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick % 20 != 3) return;
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const auto room = is_mended ? 64 : static_cast<std::int64_t>(limit.rlim_cur % 1'000'003);
  game.units[5].score += room;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("file_limit", argc, argv, rules);
}
