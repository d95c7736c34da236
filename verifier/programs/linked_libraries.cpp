// Program headers of ELF, and the lines of --list.
// SPDX-License-Identifier: MIT
//
// Source: System V ABI, ELF header and program header; the numbers are those of elf.h.
#include "verifier/programs/linked_libraries.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <sstream>
#include <string_view>

#include "base/plain_text.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t linker_name_size_max = 4'096;
constexpr std::uint32_t interpreter_type = 3;  // PT_INTERP

/// Where a kind of ELF has its fields: offsets in bytes.
struct ElfLayout {
  std::size_t header_size;
  std::size_t table;       // in the header: where the program headers are
  std::size_t row_size;    // in the header
  std::size_t row_offset;  // in a program header: where its bytes are
  std::size_t row_bytes;   // in a program header: how many
  bool is_wide;
};
constexpr ElfLayout elf_32{52, 28, 42, 4, 16, false};
constexpr ElfLayout elf_64{64, 32, 54, 8, 32, true};

/// Bytes [at, at + size) as a number; nothing outside of the view.
std::optional<std::uint64_t> number_at(ByteView bytes, std::uint64_t at, std::size_t size) {
  if (at > bytes.size() || size > bytes.size() - at) return std::nullopt;
  ByteReader in(bytes.subspan(static_cast<std::size_t>(at), size));
  return size == sizeof(std::uint64_t) ? in.u64() : size == sizeof(std::uint32_t) ? in.u32() : in.u16();
}

}  // namespace

std::optional<FilePart> linker_name_part(ByteView begin) {
  constexpr std::uint8_t magic[] = {0x7f, 'E', 'L', 'F'};
  constexpr std::size_t class_at = 4, order_at = 5;
  if (begin.size() < elf_32.header_size || !std::equal(std::begin(magic), std::end(magic), begin.begin()))
    return std::nullopt;
  if (begin[order_at] != 1 || begin[class_at] < 1 || begin[class_at] > 2) return std::nullopt;
  const ElfLayout& layout = begin[class_at] == 2 ? elf_64 : elf_32;
  const std::size_t word = layout.is_wide ? sizeof(std::uint64_t) : sizeof(std::uint32_t);
  const auto table = number_at(begin, layout.table, word);
  const auto row_size = number_at(begin, layout.row_size, sizeof(std::uint16_t));
  const auto row_count = number_at(begin, layout.row_size + sizeof(std::uint16_t), sizeof(std::uint16_t));
  if (!table || !row_size || !row_count || *table > begin.size()) return std::nullopt;
  for (std::uint64_t i = 0; i < *row_count; ++i) {
    const std::uint64_t row = *table + i * *row_size;
    const auto type = number_at(begin, row, sizeof(std::uint32_t));
    if (!type) return std::nullopt;
    if (*type != interpreter_type) continue;
    const auto at = number_at(begin, row + layout.row_offset, word),
               size = number_at(begin, row + layout.row_bytes, word);
    if (!at || !size || *size > linker_name_size_max) return std::nullopt;
    return FilePart{*at, *size};
  }
  return FilePart{};
}

Result<std::vector<std::string>> listed_libraries(const std::string& program, const std::string& text) {
  // "\tlibm.so.6 => /lib/libm.so.6 (0x7f...)", "\t/lib64/ld-linux-x86-64.so.2 (0x7f...)", "\tlinux-vdso.so.1
  // (0x7f...)".
  constexpr std::string_view arrow = " => ";
  std::vector<std::string> libraries;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line.erase(0, std::min(line.find_first_not_of(" \t"), line.size()));
    const std::size_t at = line.find(arrow);
    std::string path = at == std::string::npos ? line : line.substr(at + arrow.size());
    if (path == "not found")
      return Error{ErrorCode::io,
                   program + ": its library " + plain_line(line.substr(0, at)) + " was not found, expected one",
                   "the variable LD_LIBRARY_PATH names more folders"};
    path = path.substr(0, path.rfind(" ("));
    if (path.find('/') != std::string::npos) libraries.push_back(path);
  }
  return libraries;
}

}  // namespace ticktrue::verifier
