// The save and load callbacks of a program or plug-in, called with guards that turn their faults into errors.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "base/result.h"

namespace ticktrue {

/// As ticktrue_saver and ticktrue_loader of include/ticktrue.h.
using SaveFunction = std::size_t (*)(void* user, void* buffer, std::size_t size);
using LoadFunction = int (*)(void* user, const void* bytes, std::size_t size);
inline constexpr std::size_t save_refused = static_cast<std::size_t>(-1);  // TICKTRUE_SAVE_FAILED

class SaveCalls {
 public:
  SaveCalls() = default;
  SaveCalls(SaveFunction saver, LoadFunction loader, void* user) : save_(saver), load_(loader), user_(user) {}

  bool is_set() const { return save_ != nullptr; }

  /// What brings the program back to its state with `tick` ticks done; nothing where the callback says that it cannot
  /// now. Errors: usage (no bytes, more than it said, an exception), limit.
  Result<std::optional<Bytes>> save(std::uint64_t tick);
  /// Errors: usage (the callback refuses, an exception).
  Status load(std::uint64_t tick, ByteView bytes);

 private:
  Result<std::size_t> call_save(std::uint64_t tick, Bytes& buffer, std::size_t size);

  SaveFunction save_ = nullptr;
  LoadFunction load_ = nullptr;
  void* user_ = nullptr;
  std::size_t usual_size_ = std::size_t{64} << 10;  // bytes that the next save probably has
};

}  // namespace ticktrue
