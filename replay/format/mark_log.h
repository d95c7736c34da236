// The file that a session writes for `ticktrue trail`: the marks of each tick, and a list with stacks for one tick.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "replay/format/marks.h"

namespace ticktrue::replay {

/// Variables that a session reads: the file, the tick with listed marks, and the calls that the preload library marks
/// ("random,libm").
inline constexpr const char* trail_variable = "TICKTRUE_TRAIL";
inline constexpr const char* trail_tick_variable = "TICKTRUE_TRAIL_TICK";
inline constexpr const char* calls_variable = "TICKTRUE_CALLS";

/// Limits of a list. A session keeps within the limits; a longer list is refused.
inline constexpr std::size_t listed_mark_count_max = std::size_t{1} << 20;
inline constexpr std::size_t listed_stack_count_max = 16'385;  // different stacks; the last stands for all others
inline constexpr std::size_t listed_stack_depth_max = 32;
inline constexpr std::size_t listed_module_count_max = 4'096;

/// A file that the program had mapped, and its address.
struct LogModule {
  std::string path;
  std::uint64_t base = 0;

  bool operator==(const LogModule&) const = default;
};

/// An address as a module and the offset in it.
struct LogFrame {
  std::uint32_t module = 0;
  std::uint64_t offset = 0;

  bool operator==(const LogFrame&) const = default;
};

/// The call stacks of the marks in a list. Empty on platforms without stacks.
struct MarkStacks {
  std::vector<LogModule> modules;
  std::vector<std::vector<LogFrame>> stacks;  // return addresses, the innermost first
  std::vector<std::uint32_t> of_marks;        // [mark] index in `stacks`

  bool operator==(const MarkStacks&) const = default;
};

struct LoggedTick {
  std::uint64_t tick = 0;
  std::optional<TickMarks> marks;  // absent: the tick has none
};

struct LoggedList {
  std::uint64_t tick = 0;
  MarkList list;
  MarkStacks stacks;
};

struct MarkLog {
  std::vector<LoggedTick> ticks;  // ascending
  std::optional<LoggedList> list;
};

void encode_logged_tick(const LoggedTick& tick, ByteWriter& out);
void encode_logged_list(const LoggedList& list, ByteWriter& out);
/// Decodes the complete parts at the start of `bytes`. A program that dies can leave an incomplete part.
MarkLog decode_mark_log(ByteView bytes);

}  // namespace ticktrue::replay
