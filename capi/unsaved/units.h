// Units: pieces of memory that load left changed. A pointer and the new block it points to are one unit.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capi/unsaved/memory.h"

namespace ticktrue::capi {

/// The memory of another process, which had the same addresses.
class OtherMemory {
 public:
  void add(std::uint64_t begin, std::uint64_t size, const std::uint8_t* bytes) {
    parts_.push_back({begin, size, bytes});
  }
  /// Null: it was not copied.
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

/// Bytes that differ: of a variable, or side by side in a block.
struct Unit {
  PieceOwner owner = PieceOwner::variable;
  std::string name;                // of a variable, mangled
  std::uint64_t begin = 0;         // of the owner
  std::uint64_t size = 0;          // of the owner
  std::size_t module = 0;          // of variable, module and thread
  std::string holder;              // of a block: the variable that points to it, mangled; empty: none does
  std::vector<const void*> stack;  // of a block: where it was allocated
  std::vector<Piece> pieces;
};

/// The variable of the program that points into the block of the unit becomes its holder.
void find_holder(const ProgramMemory& memory, Unit& unit);

struct HeapBlock {
  std::uint64_t begin = 0;
  std::uint64_t size = 0;
  bool is_new = false;   // of the other process alone
  bool is_gone = false;  // of this process alone
  std::vector<std::size_t> units;
};

struct Differences {
  std::vector<Unit> units;
  std::vector<std::vector<std::size_t>> groups;  // of units, each to be written as a whole
  std::uint64_t left_out = 0;                    // bytes that were not compared
};

/// `heap_before`, `heap_after`: of this and of the other process. `moved`: where columns lie that load registered anew;
/// the group that has this memory has the number that comes back in `moved_group`, -1 for none.
Differences find_differences(const ProgramMemory& memory, const OtherMemory& other, const shim::KeptHeap& heap_before,
                             const shim::KeptHeap& heap_after, const std::vector<std::uint64_t>& moved,
                             std::vector<std::ptrdiff_t>& moved_group);

}  // namespace ticktrue::capi
