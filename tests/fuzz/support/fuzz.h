// What the fuzz harnesses share: properties that must hold, files in memory, and a few ticks of a small world.
// SPDX-License-Identifier: MIT
//
// Each harness is one file with LLVMFuzzerTestOneInput: any bytes must be read or refused, without a crash, undefined
// behaviour, a leak, or more time and memory than the limits of base/limits.h allow. ./dev fuzz builds and runs them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/result.h"
#include "engine/engine.h"
#include "engine/scene/scene.h"

namespace ticktrue::fuzz {

/// Aborts with `property` on standard error where it does not hold.
void require(bool holds, const char* property);

/// A refusal must be one line that says something.
void require_message(const Error& error);

inline std::string_view text_of(ByteView bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A file that lives in memory, for code that takes a path.
class MemoryFile {
 public:
  explicit MemoryFile(ByteView bytes);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  int descriptor_ = -1;
  std::string path_;
};

/// Whether a tick of the scene is little work. A scene within the limits may be far too slow for a fuzzer.
bool is_small(const engine::Scene& scene);

/// Steps `tick_count` ticks; a state that is finite must load again and then be the same state.
void run_a_little(engine::Engine& engine, double dt, int tick_count);

}  // namespace ticktrue::fuzz
