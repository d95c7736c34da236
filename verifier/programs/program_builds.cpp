// Reads program headers and notes of ELF files; all sizes in them are bounded before anything is read by them.
// SPDX-License-Identifier: MIT
#include "verifier/programs/program_builds.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <limits>
#include <system_error>
#include <utility>

#include "base/bytes.h"
#include "replay/trace_reader.h"
#include "verifier/programs/command_words.h"
#include "verifier/report/build_id_note.h"

namespace ticktrue::verifier {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t file_count_max = 100'000;
constexpr std::size_t segment_count_max = 1'024;
constexpr std::uint64_t notes_size_max = 64u << 10;
constexpr std::uint32_t note_segment = 4;  // PT_NOTE

/// Where the fields of an ELF file stand: of 32-bit and of 64-bit programs.
struct ElfLayout {
  std::size_t word_size;
  std::size_t headers_offset;  // of the field in the file header
  std::size_t header_size;     // of the field
  std::size_t header_count;    // of the field
  std::size_t segment_size;    // of a program header
  std::size_t offset;          // of the field in a program header; the size in the file is `file_size`
  std::size_t file_size;
  std::size_t alignment;
};
constexpr ElfLayout elf32{4, 28, 42, 44, 32, 4, 16, 28};
constexpr ElfLayout elf64{8, 32, 54, 56, 56, 8, 32, 48};
constexpr std::size_t elf_header_size_max = 64;

class ElfFile {
 public:
  explicit ElfFile(std::istream& in) : in_(in) {}

  std::string build_id() {
    const Bytes header = read(0, elf_header_size_max);
    constexpr std::array<std::uint8_t, 4> magic{0x7f, 'E', 'L', 'F'};
    if (header.size() < elf_header_size_max || !std::equal(magic.begin(), magic.end(), header.begin())) return "";
    if (header[4] < 1 || header[4] > 2 || header[5] < 1 || header[5] > 2) return "";
    const ElfLayout& layout = header[4] == 1 ? elf32 : elf64;
    order_ = header[5] == 1 ? ByteOrder::little : ByteOrder::big;
    const std::uint64_t begin = number(header, layout.headers_offset, layout.word_size);
    const std::uint64_t count = number(header, layout.header_count, 2);
    if (number(header, layout.header_size, 2) != layout.segment_size || count > segment_count_max) return "";
    const Bytes segments = read(begin, static_cast<std::size_t>(count) * layout.segment_size);
    for (std::size_t at = 0; at + layout.segment_size <= segments.size(); at += layout.segment_size) {
      const ByteView segment = ByteView(segments).subspan(at, layout.segment_size);
      if (number(segment, 0, 4) != note_segment) continue;
      const std::uint64_t size = number(segment, layout.file_size, layout.word_size);
      if (size > notes_size_max) continue;
      const Bytes notes = read(number(segment, layout.offset, layout.word_size), static_cast<std::size_t>(size));
      const bool is_wide = number(segment, layout.alignment, layout.word_size) == 8;
      std::string id = build_id_among(notes, is_wide ? 8 : 4, order_);
      if (!id.empty()) return id;
    }
    return "";
  }

 private:
  /// Fewer bytes where the file ends.
  Bytes read(std::uint64_t offset, std::size_t size) {
    Bytes bytes;
    if (offset > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) return bytes;
    in_.clear();
    if (!in_.seekg(static_cast<std::streamoff>(offset))) return bytes;
    bytes.resize(size);
    in_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    bytes.resize(static_cast<std::size_t>(in_.gcount()));
    return bytes;
  }

  std::uint64_t number(ByteView bytes, std::size_t offset, std::size_t size) const {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value = value << 8 | bytes[offset + (order_ == ByteOrder::big ? i : size - 1 - i)];
    return value;
  }

  std::istream& in_;
  ByteOrder order_ = ByteOrder::little;
};

bool is_executable(const fs::directory_entry& entry) {
  std::error_code failure;
  if (!entry.is_regular_file(failure) || failure) return false;
  const fs::perms perms = entry.status(failure).permissions();
  return !failure && (perms & fs::perms::owner_exec) != fs::perms::none;
}

/// Sorted, so that of two copies the choice does not depend on the disk.
Result<std::vector<std::string>> executables_in(const std::string& folder) {
  std::vector<std::string> paths;
  std::size_t count = 0;
  std::error_code failure;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied, failure);
  if (failure) return Error{ErrorCode::usage, folder + ": " + failure.message() + ", expected a folder", ""};
  for (; entry != fs::recursive_directory_iterator() && !failure; entry.increment(failure)) {
    if (++count > file_count_max)
      return Error{ErrorCode::limit,
                   folder + ": found more than " + std::to_string(file_count_max) + " files, expected at most that",
                   "name a folder that holds builds alone"};
    if (is_executable(*entry)) paths.push_back(entry->path().string());
  }
  if (failure) return Error{ErrorCode::usage, folder + ": " + failure.message(), ""};
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace

std::string elf_build_id(std::istream& in) {
  return ElfFile(in).build_id();
}

Result<ProgramBuilds> ProgramBuilds::find(const std::string& folder) {
  const Result<std::vector<std::string>> paths = executables_in(folder);
  if (!paths) return paths.error();
  ProgramBuilds builds(folder);
  for (const std::string& path : *paths) {
    std::ifstream in(path, std::ios::binary);
    if (std::string id = elf_build_id(in); !id.empty()) builds.paths_.emplace(std::move(id), path);
  }
  if (!builds.paths_.empty()) return builds;
  return Error{ErrorCode::usage, folder + ": found no program with a build id, expected one at least",
               "a linker writes it with -Wl,--build-id; files without the right to execute do not count"};
}

Result<std::string> ProgramBuilds::recorder_of(const std::string& trace) const {
  const Result<replay::TraceReader> reader = replay::TraceReader::open(trace);
  if (!reader) return reader.error();
  const replay::BuildFacts& facts = reader->facts();
  const auto fact =
      std::find_if(facts.begin(), facts.end(), [](const auto& one) { return one.first == build_id_fact; });
  if (fact == facts.end())
    return Error{ErrorCode::incompatible, trace + ": names no build id of the program that recorded it",
                 "link the program with -Wl,--build-id; --command verifies by a program that you name"};
  const auto found = paths_.find(fact->second);
  if (found != paths_.end()) return found->second;
  return Error{ErrorCode::incompatible,
               trace + ": recorded by build id " + fact->second + ": found none such in " + folder_ + " (" +
                   std::to_string(paths_.size()) + " builds)",
               "keep each build that records; --command verifies by a program that you name"};
}

bool replace_build(std::vector<std::string>& words, const std::string& program) {
  const CommandMark marks[] = {{"{build}", program}};
  return replace_marks(words, marks)[0];
}

}  // namespace ticktrue::verifier
