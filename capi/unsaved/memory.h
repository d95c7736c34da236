// The writable memory of the program: variables of its modules, of its thread, its stack and its heap.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shim/kept_block.h"

namespace ticktrue::capi {

/// A variable from the symbol table of a module.
struct Variable {
  std::uint64_t address = 0;
  std::uint64_t size = 0;  // bytes
  std::string name;        // mangled
};

/// `generator`: the state of rand and random of the C library.
enum class RangeKind : std::uint8_t { module, thread, stack, generator };

/// A contiguous range of writable memory.
struct MemoryRange {
  RangeKind kind = RangeKind::module;
  std::uint64_t begin = 0;
  std::uint64_t size = 0;  // bytes
  std::size_t module = 0;  // for module and thread
};

struct LoadedModule {
  std::string path;
  std::uint64_t base = 0;
  std::uint64_t end = 0;
};

struct ProgramMemory {
  std::vector<LoadedModule> modules;
  std::vector<MemoryRange> ranges;
  std::vector<Variable> variables;  // sorted by address
  std::uint64_t left_out = 0;       // bytes of ranges that are too large
};

/// The writable memory that the calling thread can reach, without the C library, the C++ library and libticktrue.
/// `stack_begin`: the stack from here on belongs to the program. Empty without GNU/Linux.
ProgramMemory program_memory(const void* stack_begin);

/// The heap of the preload library; all null: the library is not loaded.
shim::KeptHeap kept_heap();
/// Stops the reuse of freed blocks. New blocks are placed at or after `from.top`.
void keep_heap_blocks(const shim::KeptHeap& from);

/// During its lifetime, rand and random of the C library use another state. So their own state can be read and written.
class ParkedGenerator {
 public:
  ParkedGenerator();
  ParkedGenerator(const ParkedGenerator&) = delete;
  ParkedGenerator& operator=(const ParkedGenerator&) = delete;
  ~ParkedGenerator();
  /// 0: the state is in memory of the program.
  std::uint64_t address() const;

 private:
  char other_[8] = {};
  char* state_ = nullptr;
};

/// Threads of this process.
std::size_t thread_count();

}  // namespace ticktrue::capi
