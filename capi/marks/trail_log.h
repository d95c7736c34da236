// Writes the marks of a verification for `ticktrue trail`.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "capi/marks/marks.h"

namespace ticktrue::capi {

class TrailLog {
 public:
  /// Null unless TICKTRUE_TRAIL names a file. Only the first session of the process gets the log.
  static std::unique_ptr<TrailLog> from_environment();

  /// Whether the marks of this tick are listed with their stacks.
  bool wants_list(std::uint64_t tick) const { return list_tick_ == tick; }
  void write(std::uint64_t tick, const BoundContents& contents);

 private:
  TrailLog(std::string path, std::optional<std::uint64_t> list_tick) : path_(std::move(path)), list_tick_(list_tick) {}

  std::string path_;
  std::optional<std::uint64_t> list_tick_;
};

}  // namespace ticktrue::capi
