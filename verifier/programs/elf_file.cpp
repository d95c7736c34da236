// Reads program headers and segments of ELF files.
// SPDX-License-Identifier: MIT
#include "verifier/programs/elf_file.h"

#include <algorithm>
#include <array>
#include <limits>

namespace ticktrue::verifier {
namespace {

constexpr std::size_t segment_count_max = 1'024;
constexpr std::size_t notes_size_max = 64u << 10;
constexpr std::size_t linker_name_size_max = 4'096;
constexpr std::uint32_t linker_segment = 3;  // PT_INTERP
constexpr std::uint32_t note_segment = 4;    // PT_NOTE

/// The offsets of fields in an ELF file, for 32-bit and 64-bit programs.
struct ElfLayout {
  std::size_t file_header_size;
  std::size_t word_size;
  std::size_t headers_offset;  // of the field in the file header
  std::size_t header_size;     // of the field
  std::size_t header_count;    // of the field
  std::size_t segment_size;    // of a program header
  std::size_t offset;          // of the field in a program header; the size in the file is at `file_size`
  std::size_t file_size;
  std::size_t alignment;
};
constexpr ElfLayout elf32{52, 4, 28, 42, 44, 32, 4, 16, 28};
constexpr ElfLayout elf64{64, 8, 32, 54, 56, 56, 8, 32, 48};

}  // namespace

std::optional<ElfFile> ElfFile::open(std::istream& in) {
  ElfFile file(in);
  const Bytes header = file.read_at(0, elf64.file_header_size);
  constexpr std::array<std::uint8_t, 4> magic{0x7f, 'E', 'L', 'F'};
  if (header.size() < elf32.file_header_size || !std::equal(magic.begin(), magic.end(), header.begin()))
    return std::nullopt;
  if (header[4] < 1 || header[4] > 2 || header[5] < 1 || header[5] > 2) return std::nullopt;
  const ElfLayout& layout = header[4] == 1 ? elf32 : elf64;
  if (header.size() < layout.file_header_size) return std::nullopt;
  file.order_ = header[5] == 1 ? ByteOrder::little : ByteOrder::big;
  const std::uint64_t begin = file.number(header, layout.headers_offset, layout.word_size);
  const std::uint64_t count = file.number(header, layout.header_count, 2);
  if (count > segment_count_max) return std::nullopt;
  if (count > 0 && file.number(header, layout.header_size, 2) != layout.segment_size) return std::nullopt;
  const Bytes rows = file.read_at(begin, static_cast<std::size_t>(count) * layout.segment_size);
  if (rows.size() < count * layout.segment_size) return std::nullopt;
  for (std::size_t at = 0; at < rows.size(); at += layout.segment_size) {
    const ByteView row = ByteView(rows).subspan(at, layout.segment_size);
    file.segments_.push_back(
        {static_cast<std::uint32_t>(file.number(row, 0, 4)), file.number(row, layout.offset, layout.word_size),
         file.number(row, layout.file_size, layout.word_size), file.number(row, layout.alignment, layout.word_size)});
  }
  return file;
}

Bytes ElfFile::read(const ElfSegment& segment, std::size_t size_max) {
  if (segment.size > size_max) return {};
  return read_at(segment.offset, static_cast<std::size_t>(segment.size));
}

Bytes ElfFile::read_at(std::uint64_t offset, std::size_t size) {
  Bytes bytes;
  if (offset > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) return bytes;
  in_->clear();
  if (!in_->seekg(static_cast<std::streamoff>(offset))) return bytes;
  bytes.resize(size);
  in_->read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(in_->gcount()));
  return bytes;
}

std::uint64_t ElfFile::number(ByteView bytes, std::size_t offset, std::size_t size) const {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i)
    value = value << 8 | bytes[offset + (order_ == ByteOrder::big ? i : size - 1 - i)];
  return value;
}

std::string elf_build_id(std::istream& in) {
  std::optional<ElfFile> file = ElfFile::open(in);
  if (!file) return "";
  for (const ElfSegment& segment : file->segments()) {
    if (segment.type != note_segment) continue;
    std::string id = build_id_among(file->read(segment, notes_size_max), segment.alignment == 8 ? 8 : 4, file->order());
    if (!id.empty()) return id;
  }
  return "";
}

std::string elf_linker_name(std::istream& in) {
  std::optional<ElfFile> file = ElfFile::open(in);
  if (!file) return "";
  for (const ElfSegment& segment : file->segments()) {
    if (segment.type != linker_segment) continue;
    const Bytes name = file->read(segment, linker_name_size_max);
    return std::string(name.begin(), std::find(name.begin(), name.end(), 0));
  }
  return "";
}

}  // namespace ticktrue::verifier
