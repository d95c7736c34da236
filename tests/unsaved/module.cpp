// A shared library with a variable that no save holds.
// SPDX-License-Identifier: MIT
namespace {
int level_of_module = 0;
}

extern "C" int raise_level(int by) {
  level_of_module += by;
  return level_of_module;
}
