// The result of a copy of the process, in memory that both processes share.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "capi/unsaved/probe.h"
#include "shim/kept_block.h"

namespace ticktrue::capi {

/// `none`: the copy ended without a result. `lost`: the program left the window early.
enum class CopyEnd : std::uint32_t { none, same, moved, load_differs, load_failed, lost };

inline constexpr std::size_t moved_column_count_max = 256;
inline constexpr std::size_t name_room = 128;
inline constexpr int copy_time_ms = 20'000;  // limit for a copy

struct SharedColumn {
  char table[name_room];
  char column[name_room];
  ColumnSource source;
};

struct WindowResult {
  CopyEnd end;
  std::uint32_t has_crashed;
  std::uint64_t tick;            // moved: the first tick with another end state
  std::uint64_t straight_count;  // ticks of the first run
  std::uint64_t column_count;    // number of columns that differ; their flags follow this struct
  const void* frame;             // stack frame of the copy when its memory was copied
  shim::KeptHeap heap;           // of the copy
  std::uint64_t heap_copied;     // bytes
  std::uint64_t moved_column_count;
  SharedColumn moved_columns[moved_column_count_max];
  char message[256];
};

}  // namespace ticktrue::capi
