// The parts of ELF programs and libraries that identify them: segments, build id, dynamic linker.
// SPDX-License-Identifier: MIT
//
// Source: System V ABI, ELF header and program header; the numbers are those of elf.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "verifier/report/build_id_note.h"

namespace ticktrue::verifier {

struct ElfSegment {
  std::uint32_t type = 0;       // PT_INTERP, PT_NOTE, ...
  std::uint64_t offset = 0;     // bytes from the start of the file
  std::uint64_t size = 0;       // bytes in the file
  std::uint64_t alignment = 0;  // bytes
};

/// Reads parts of an ELF file with either word size and byte order. Each size in the file is limited before anything is
/// read with it.
class ElfFile {
 public:
  /// Nothing: the file is not an ELF program or library, or its headers are damaged. Requires: the stream outlives this
  /// object.
  static std::optional<ElfFile> open(std::istream& in);

  const std::vector<ElfSegment>& segments() const { return segments_; }
  ByteOrder order() const { return order_; }
  /// Fewer bytes: the file ends. Empty: the segment is longer than `size_max`.
  Bytes read(const ElfSegment& segment, std::size_t size_max);

 private:
  explicit ElfFile(std::istream& in) : in_(&in) {}
  Bytes read_at(std::uint64_t offset, std::size_t size);
  std::uint64_t number(ByteView bytes, std::size_t offset, std::size_t size) const;

  std::istream* in_;
  ByteOrder order_ = ByteOrder::little;
  std::vector<ElfSegment> segments_;
};

/// The build id of a program or library in hexadecimal digits; empty: it has none, or is not an ELF file.
std::string elf_build_id(std::istream& in);
/// The dynamic linker that a program names, at most 4,096 bytes; empty: it names none, or is not a program.
std::string elf_linker_name(std::istream& in);

}  // namespace ticktrue::verifier
