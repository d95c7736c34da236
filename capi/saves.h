// The save and load callbacks of a program: called with guards, their faults told by name.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "base/result.h"
#include "include/ticktrue.h"

namespace ticktrue::capi {

class SaveCalls {
 public:
  SaveCalls() = default;
  SaveCalls(ticktrue_saver saver, ticktrue_loader loader, void* user) : save_(saver), load_(loader), user_(user) {}

  bool is_set() const { return save_ != nullptr; }

  /// What brings the program back to its state with `tick` ticks done; nothing where the callback says that it cannot
  /// now. Errors: usage (no bytes, more than it said, an exception), limit.
  Result<std::optional<Bytes>> save(std::uint64_t tick);
  /// Errors: usage (the callback refuses, an exception).
  Status load(std::uint64_t tick, ByteView bytes);

 private:
  Result<std::size_t> call_save(std::uint64_t tick, Bytes& buffer, std::size_t size);

  ticktrue_saver save_ = nullptr;
  ticktrue_loader load_ = nullptr;
  void* user_ = nullptr;
  std::size_t usual_size_ = std::size_t{64} << 10;  // bytes that the next save probably has
};

}  // namespace ticktrue::capi
