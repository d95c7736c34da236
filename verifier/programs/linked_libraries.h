// What an ELF program says of its dynamic linker, and what that linker says of the libraries.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"

namespace ticktrue::verifier {

/// Bytes of a file.
struct FilePart {
  std::uint64_t at = 0;
  std::uint64_t size = 0;
};
/// Where an ELF program names its dynamic linker, in at most 4096 bytes; of size 0: it names none. Nothing: these are
/// no bytes of an ELF program, or damaged ones. `begin`: the first bytes of the file, with all of its program headers.
std::optional<FilePart> linker_name_part(ByteView begin);
inline constexpr std::size_t elf_begin_size = 16u << 10;

/// The paths in what a dynamic linker prints for --list. Errors: io (a library that it did not find).
Result<std::vector<std::string>> listed_libraries(const std::string& program, const std::string& text);

}  // namespace ticktrue::verifier
