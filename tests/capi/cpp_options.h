// Options of sessions that tests of the C++ layer open: short checkpoint intervals, nothing printed.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <ticktrue.hpp>

namespace ticktrue::test {

/// Requires: `path` outlives the options.
inline ticktrue::Options cpp_options(const std::string& path, int mode, int detail = TICKTRUE_DETAIL_FULL) {
  ticktrue::Options options("cpp-test", nullptr);
  options.mode = mode;
  options.path = path.c_str();
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC;
  options.detail = detail;
  options.checkpoint_interval = 8;
  return options;
}

}  // namespace ticktrue::test
