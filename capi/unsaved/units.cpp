// Joins pieces by the pointers in them: a list with new nodes, a vector at another address.
// SPDX-License-Identifier: MIT
#include "capi/unsaved/units.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>

namespace ticktrue::capi {
namespace {

constexpr std::uint64_t cell = 4;       // bytes; differences in a block are counted in cells of this size
constexpr std::uint64_t long_run = 64;  // bytes; a longer run of differing bytes is one unit: a generator, an array
constexpr std::uint64_t node_size_max = 256;  // bytes; a larger block is not a node of a container
constexpr std::uint64_t page_size = 4096;

const std::uint8_t* here(std::uint64_t address) {
  return reinterpret_cast<const std::uint8_t*>(address);
}

std::uint64_t word_at(const std::uint8_t* bytes) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, sizeof word);
  return word;
}

class Finder {
 public:
  Finder(const ProgramMemory& memory, const OtherMemory& other, const shim::KeptHeap& before,
         const shim::KeptHeap& after)
      : memory_(memory),
        other_(other),
        begin_(reinterpret_cast<std::uint64_t>(before.begin != nullptr ? before.begin : after.begin)),
        top_before_(before.begin != nullptr ? reinterpret_cast<std::uint64_t>(before.top) : begin_),
        top_after_(reinterpret_cast<std::uint64_t>(after.top)) {}

  Differences run(const std::vector<std::uint64_t>& moved, std::vector<std::ptrdiff_t>& moved_group) {
    for (const MemoryRange& range : memory_.ranges) compare_range(range);
    read_blocks();
    for (HeapBlock& block : blocks_)
      if (!block.is_new && !block.is_gone) compare_block(block);
    join();
    std::vector<std::ptrdiff_t> of_root(parents_.size(), -1);
    for (std::size_t unit = 0; unit < found_.units.size(); ++unit) {
      std::ptrdiff_t& group = of_root[root(unit)];
      if (group < 0) {
        group = static_cast<std::ptrdiff_t>(found_.groups.size());
        found_.groups.emplace_back();
      }
      found_.groups[static_cast<std::size_t>(group)].push_back(unit);
    }
    moved_group.clear();
    for (const std::uint64_t address : moved) {
      const std::optional<std::size_t> block = block_of(address);
      moved_group.push_back(block && blocks_[*block].is_new ? of_root[root(node_of(*block))] : -1);
    }
    return std::move(found_);
  }

 private:
  void compare_range(const MemoryRange& range) {
    const std::uint8_t* other = other_.at(range.begin, range.size);
    if (other == nullptr) {
      found_.left_out += range.size;
      return;
    }
    if (range.kind == RangeKind::generator) return add_generator(range, other);
    for (std::uint64_t at = 0; at < range.size;) {
      const std::uint64_t size = std::min(page_size, range.size - at);
      if (std::memcmp(here(range.begin + at), other + at, size) == 0) {
        at += size;
        continue;
      }
      std::uint64_t end = at;
      while (end < range.size && *here(range.begin + end) == other[end]) ++end;
      at = range.kind == RangeKind::stack ? add_cells(range.begin, end, range.size, other, PieceOwner::stack)
                                          : add_variable(range, end, other);
    }
  }

  void add_generator(const MemoryRange& range, const std::uint8_t* other) {
    Unit unit;
    unit.owner = PieceOwner::generator;
    unit.begin = range.begin;
    unit.size = range.size;
    add_pieces(unit, range.begin, range.begin + range.size, other);
    if (!unit.pieces.empty()) found_.units.push_back(std::move(unit));
  }

  /// Adds the variable at this place, or the bytes up to the next variable. Returns the address after it.
  std::uint64_t add_variable(const MemoryRange& range, std::uint64_t at, const std::uint8_t* other) {
    const std::uint64_t address = range.begin + at;
    auto next = std::upper_bound(memory_.variables.begin(), memory_.variables.end(), address,
                                 [](std::uint64_t wanted, const Variable& v) { return wanted < v.address; });
    Unit unit;
    unit.module = range.module;
    unit.owner = range.kind == RangeKind::thread ? PieceOwner::thread : PieceOwner::module;
    unit.begin = address;
    unit.size = std::min(range.size - at, (next == memory_.variables.end() ? address + cell : next->address) - address);
    unit.size = std::min<std::uint64_t>(unit.size, 8);
    for (auto v = next; v != memory_.variables.begin();) {
      --v;
      if (v->address + v->size <= address) break;
      unit.owner = PieceOwner::variable;
      unit.name = v->name;
      unit.begin = v->address;
      unit.size = v->size;
    }
    const std::uint64_t end = std::min(range.begin + range.size, unit.begin + unit.size);
    add_pieces(unit, address, end, other + at);
    found_.units.push_back(std::move(unit));
    return end - range.begin;
  }

  static void add_pieces(Unit& unit, std::uint64_t begin, std::uint64_t end, const std::uint8_t* other) {
    for (std::uint64_t at = begin; at < end; ++at) {
      if (*here(at) == other[at - begin]) continue;
      if (!unit.pieces.empty() && at - (unit.pieces.back().address + unit.pieces.back().size) < 8)
        unit.pieces.back().size = at + 1 - unit.pieces.back().address;
      else
        unit.pieces.push_back({at, 1, other + (at - begin)});
    }
  }

  bool is_pointer(std::uint64_t word) const { return word >= begin_ && word < top_after_; }

  /// Adds a run of differing cells that begins at `at`. Returns the offset after it.
  std::uint64_t add_cells(std::uint64_t begin, std::uint64_t at, std::uint64_t size, const std::uint8_t* other,
                          PieceOwner owner) {
    const auto differs = [&](std::uint64_t from) {
      return from < size && std::memcmp(here(begin + from), other + from, std::min(cell, size - from)) != 0;
    };
    const std::uint64_t first = at / cell * cell;
    std::uint64_t end = first;
    while (differs(end) || differs(end + cell)) end += cell;
    end = std::min(end, size);
    for (std::uint64_t from = first; from < end;) {
      std::uint64_t count = end - first >= long_run ? end - first : cell;
      const std::uint64_t aligned = from / 8 * 8;
      if (count == cell && aligned + 8 <= size &&
          (is_pointer(word_at(here(begin + aligned))) || is_pointer(word_at(other + aligned))))
        count = aligned + 8 - from;
      count = std::min(count, size - from);
      Unit unit;
      unit.owner = owner;
      unit.begin = begin;
      unit.size = size;
      add_pieces(unit, begin + from, begin + from + count, other + from);
      if (!unit.pieces.empty()) found_.units.push_back(std::move(unit));
      from += count;
    }
    return std::max(end, at + 1);
  }

  /// Reads the blocks of both processes. The headers of this process show the blocks that are gone.
  void read_blocks() {
    if (begin_ == 0) return;
    for (std::uint64_t at = begin_; at < top_after_;) {
      const std::uint8_t* bytes = other_.at(at, sizeof(shim::KeptBlock));
      if (bytes == nullptr) {
        found_.left_out += top_after_ - at;
        break;
      }
      const auto* after = reinterpret_cast<const shim::KeptBlock*>(bytes);
      if (after->magic != shim::kept_magic || after->whole == 0) break;
      const bool was_there = at < top_before_;
      const auto* before = reinterpret_cast<const shim::KeptBlock*>(here(at));
      const bool was_live = was_there && before->is_live != 0;
      HeapBlock block;
      block.begin = at + after->offset;
      block.size = after->size;
      block.is_new = !was_there && after->is_live != 0;
      block.is_gone = was_live && after->is_live == 0;
      if (block.is_new || was_live) blocks_.push_back(block);
      at += after->whole;
    }
  }

  void compare_block(HeapBlock& block) {
    const std::uint8_t* other = other_.at(block.begin, block.size);
    if (other == nullptr || std::memcmp(here(block.begin), other, block.size) == 0) return;
    const auto* header = *reinterpret_cast<shim::KeptBlock* const*>(block.begin - sizeof(void*));
    for (std::uint64_t at = 0; at < block.size;) {
      while (at < block.size && *here(block.begin + at) == other[at]) ++at;
      if (at == block.size) break;
      const std::size_t first = found_.units.size();
      at = add_cells(block.begin, at, block.size, other, PieceOwner::block);
      for (std::size_t unit = first; unit < found_.units.size(); ++unit) {
        found_.units[unit].stack.assign(header->stack,
                                        header->stack + std::min<std::size_t>(header->depth, shim::kept_depth_max));
        block.units.push_back(unit);
      }
    }
  }

  std::optional<std::size_t> block_of(std::uint64_t address) const {
    auto behind = std::upper_bound(blocks_.begin(), blocks_.end(), address,
                                   [](std::uint64_t wanted, const HeapBlock& block) { return wanted < block.begin; });
    if (behind == blocks_.begin()) return {};
    --behind;
    if (address > behind->begin + behind->size) return {};
    return static_cast<std::size_t>(behind - blocks_.begin());
  }

  std::size_t node_of(std::size_t block) const { return found_.units.size() + block; }
  std::size_t root(std::size_t node) {
    while (parents_[node] != node) node = parents_[node] = parents_[parents_[node]];
    return node;
  }
  void unite(std::size_t a, std::size_t b) { parents_[root(a)] = root(b); }

  void join_word(std::size_t node, std::uint64_t word) {
    const std::optional<std::size_t> target = is_pointer(word) ? block_of(word) : std::nullopt;
    if (!target) return;
    const HeapBlock& block = blocks_[*target];
    if (block.is_new || block.is_gone) return unite(node, node_of(*target));
    if (block.size > node_size_max) return;
    for (const std::size_t unit : block.units) unite(node, unit);
  }

  void join() {
    parents_.resize(found_.units.size() + blocks_.size());
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
    for (std::size_t unit = 0; unit < found_.units.size(); ++unit)
      for (const Piece& piece : found_.units[unit].pieces)
        for (std::uint64_t at = piece.address / 8 * 8; at < piece.address + piece.size; at += 8) {
          const std::uint8_t* other = other_.at(at, 8);
          if (other == nullptr || word_at(other) == word_at(here(at))) continue;
          join_word(unit, word_at(here(at)));
          join_word(unit, word_at(other));
        }
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (!blocks_[i].is_new) continue;
      const std::uint8_t* bytes = other_.at(blocks_[i].begin, blocks_[i].size);
      for (std::uint64_t at = 0; bytes != nullptr && at + 8 <= blocks_[i].size; at += 8)
        join_word(node_of(i), word_at(bytes + at));
    }
  }

  const ProgramMemory& memory_;
  const OtherMemory& other_;
  std::uint64_t begin_, top_before_, top_after_;
  std::vector<HeapBlock> blocks_;  // sorted by address
  std::vector<std::size_t> parents_;
  Differences found_;
};

}  // namespace

const std::uint8_t* OtherMemory::at(std::uint64_t address, std::uint64_t size) const {
  for (const Part& part : parts_)
    if (address >= part.begin && size <= part.size && address - part.begin <= part.size - size)
      return part.bytes + (address - part.begin);
  return nullptr;
}

void find_holder(const ProgramMemory& memory, Unit& unit) {
  for (const Variable& variable : memory.variables) {
    const bool is_writable = std::any_of(memory.ranges.begin(), memory.ranges.end(), [&](const MemoryRange& range) {
      return variable.address >= range.begin && variable.address + variable.size <= range.begin + range.size;
    });
    for (std::uint64_t at = (variable.address + 7) / 8 * 8; is_writable && at + 8 <= variable.address + variable.size;
         at += 8) {
      const std::uint64_t word = word_at(here(at));
      if (word < unit.begin || word > unit.begin + unit.size) continue;
      unit.holder = variable.name;
      return;
    }
  }
}

Differences find_differences(const ProgramMemory& memory, const OtherMemory& other, const shim::KeptHeap& heap_before,
                             const shim::KeptHeap& heap_after, const std::vector<std::uint64_t>& moved,
                             std::vector<std::ptrdiff_t>& moved_group) {
  return Finder(memory, other, heap_before, heap_after).run(moved, moved_group);
}

}  // namespace ticktrue::capi
