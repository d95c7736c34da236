// Facts about this build and this machine, for reports and traces. No hash contains them.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace ticktrue {

struct BuildInfo {
  std::string version;   // of ticktrue
  std::string commit;    // short git hash, "unknown" outside a checkout
  std::string compiler;  // "gcc 12.2.0"
  std::string flags;     // optimisation and target flags
  std::string target;    // "x86_64 little-endian 64-bit"
  bool has_zstd;
  bool has_box2d;
  bool has_threads;
};

const BuildInfo& build_info();

/// One line: "ticktrue 0.1.0 (3f2a1c) gcc 12.2.0 -O3 x86_64".
std::string build_line();

}  // namespace ticktrue
