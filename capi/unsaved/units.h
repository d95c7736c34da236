// Units: pieces of memory that load left changed. A pointer and the new block that it points to are one unit.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capi/unsaved/memory.h"

namespace ticktrue::capi {

/// The memory of another process with the same addresses.
class OtherMemory {
 public:
  void add(std::uint64_t begin, std::uint64_t size, const std::uint8_t* bytes) {
    parts_.push_back({begin, size, bytes});
  }
  /// Null: this memory was not copied.
  const std::uint8_t* at(std::uint64_t address, std::uint64_t size) const;

 private:
  struct Part {
    std::uint64_t begin, size;
    const std::uint8_t* bytes;
  };
  std::vector<Part> parts_;
};

struct Piece {
  std::uint64_t address = 0;
  std::uint64_t size = 0;  // bytes
  const std::uint8_t* other = nullptr;
};

enum class PieceOwner : std::uint8_t { variable, module, thread, stack, generator, block };

/// Differing bytes: of a variable, or contiguous in a block.
struct Unit {
  PieceOwner owner = PieceOwner::variable;
  std::string name;                // mangled name of the variable
  std::uint64_t begin = 0;         // of the owner
  std::uint64_t size = 0;          // of the owner
  std::size_t module = 0;          // of variable, module and thread
  std::string holder;              // of a block: mangled name of the variable that points to it; empty: none
  std::vector<const void*> stack;  // of a block: the call stack of its allocation
  std::vector<Piece> pieces;
};

/// Sets `holder` to the variable of the program that points into the block of the unit.
void find_holder(const ProgramMemory& memory, Unit& unit);

struct HeapBlock {
  std::uint64_t begin = 0;
  std::uint64_t size = 0;
  bool is_new = false;   // only in the other process
  bool is_gone = false;  // only in this process
  std::vector<std::size_t> units;
};

struct Differences {
  std::vector<Unit> units;
  std::vector<std::vector<std::size_t>> groups;  // indices of units; a group is written as a whole
  std::uint64_t left_out = 0;                    // bytes that were not compared
};

/// `heap_before`, `heap_after`: the heaps of this and of the other process. `moved`: addresses of columns that load
/// registered again. `moved_group`: for each, the index of the group with this memory; -1: none.
Differences find_differences(const ProgramMemory& memory, const OtherMemory& other, const shim::KeptHeap& heap_before,
                             const shim::KeptHeap& heap_after, const std::vector<std::uint64_t>& moved,
                             std::vector<std::ptrdiff_t>& moved_group);

}  // namespace ticktrue::capi
