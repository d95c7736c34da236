// Reads the list of the dynamic linker, and the files in it.
// SPDX-License-Identifier: MIT
//
// Verified: a library that is replaced on the disk while its old file is mapped. Not verified: code that a plug-in maps
// without the dynamic linker.
#include "verifier/store/mapped_libraries.h"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>

#include "base/bytes.h"
#include "replay/file/file.h"
#ifdef __linux__
#include <link.h>

#include <fstream>
#include <sstream>
#include <string_view>
#endif

namespace ticktrue::verifier {
namespace {

constexpr std::size_t read_size = 1u << 20;

std::string base_name(const std::string& path) {
  return path.substr(path.rfind('/') + 1);
}

#ifdef __linux__

std::vector<std::string> linked_paths() {
  std::vector<std::string> paths;
  ::dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* list) {
        const std::string name = info->dlpi_name == nullptr ? "" : info->dlpi_name;
        // The program itself has no name. Mappings of the kernel have no file.
        if (name.find('/') != std::string::npos) static_cast<std::vector<std::string>*>(list)->push_back(name);
        return 0;
      },
      &paths);
  return paths;
}

/// Checks the lines of /proc/self/maps: "START-END MODE OFFSET DEVICE INODE PATH", with " (deleted)" after the path of
/// a file that has lost its name. (Inodes are useless here: on overlayfs they belong to another file system.)
Status check_mapped() {
  constexpr std::string_view deleted = " (deleted)";
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    std::istringstream words(line);
    std::string range, mode, offset, device, inode, path;
    words >> range >> mode >> offset >> device >> inode;
    std::getline(words >> std::ws, path);
    const bool is_code = mode.find('x') != std::string::npos && path.find(".so") != std::string::npos;
    if (!is_code || path.size() <= deleted.size() ||
        path.compare(path.size() - deleted.size(), deleted.size(), deleted))
      continue;
    return Error{ErrorCode::io,
                 path.substr(0, path.size() - deleted.size()) +
                     ": found that the library was replaced since it was mapped, expected the same file",
                 "start the command again"};
  }
  return {};
}

#endif

}  // namespace

Result<Hash128> file_hash(const std::string& path) {
  Result<replay::InputFile> file = replay::InputFile::open(path);
  if (!file) return file.error();
  Hash128Stream stream;
  Bytes part;
  for (std::uint64_t at = 0; at < file->size(); at += part.size()) {
    file->read(at, read_size, part);
    if (part.empty())
      return Error{ErrorCode::io, path + ": cannot be read from byte " + std::to_string(at) + " on", ""};
    stream.add(part);
  }
  if (const Status status = file->check_unchanged(path); !status) return status.error();
  return stream.value();
}

Result<std::vector<MappedLibrary>> mapped_libraries() {
#ifdef __linux__
  std::vector<MappedLibrary> libraries;
  for (std::string& path : linked_paths()) {
    const Result<Hash128> content = file_hash(path);
    if (!content) return content.error();
    libraries.push_back({std::move(path), *content});
  }
  if (const Status status = check_mapped(); !status) return status.error();
  return libraries;
#else
  return Error{ErrorCode::unsupported, "this system does not say which libraries a process has mapped",
               "use the command verify, which needs no store"};
#endif
}

Hash128 libraries_digest(const std::vector<MappedLibrary>& libraries) {
  std::vector<std::tuple<std::string, std::uint64_t, std::uint64_t>> rows;
  for (const MappedLibrary& library : libraries)
    rows.emplace_back(base_name(library.path), library.content.high, library.content.low);
  std::sort(rows.begin(), rows.end());
  ByteWriter out;
  for (const auto& [name, high, low] : rows) {
    out.text(name);
    out.u64(high);
    out.u64(low);
  }
  return hash128(out.view());
}

}  // namespace ticktrue::verifier
