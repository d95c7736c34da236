// Portable wrappers of the operating system's file calls. Used by replay/ and the store of verdicts.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include "base/result.h"

namespace ticktrue::replay {

// One call may transfer less than 2 GiB on every system; a smaller bound keeps the loops simple.
inline constexpr std::size_t transfer_size_max = 64u << 20;

/// The path as UTF-8. On Windows, a path that is no UTF-8 is read in the code page of the process: the arguments of a C
/// program come so. Elsewhere: the same bytes.
std::string utf8_path(const std::string& path);

/// A path of UTF-8 for std::filesystem, which on Windows reads narrow text byte by byte.
std::filesystem::path system_path(const std::string& path);

/// -1: see errno. Flags are those of open(2). On every system the path is UTF-8 and no line end is changed.
int open_file(const std::string& path, int flags);
/// A new file, for reading and writing, that may be renamed while it is open. -1: see errno.
int create_movable_file(const std::string& path);
/// -1: see errno; otherwise the number of bytes, which may be less.
std::int64_t write_some(int descriptor, const std::uint8_t* data, std::size_t size);
std::int64_t read_some(int descriptor, std::uint8_t* data, std::size_t size, std::uint64_t offset);
int sync_file(int descriptor);
int close_file(int descriptor);

Error io_error(const std::string& path, const std::string& action, int code);
Error io_error(const std::string& path, const std::string& action, const std::error_code& code);

/// Which file it is, and in which state.
struct FileFacts {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::uint64_t size = 0;
  std::int64_t modified_ns = 0;
  std::int64_t changed_ns = 0;
};
std::optional<FileFacts> file_facts(int descriptor);
std::optional<FileFacts> file_facts(const std::string& path);
/// Always true on Windows, where an open file can be neither removed nor replaced.
bool is_same_file(const FileFacts& a, const FileFacts& b);

/// Takes the lock that every recorder takes on the file it writes: false if another process has it. True also
/// where the file system has no locks. Ends with the descriptor, or unlock_file.
bool lock_file(int descriptor);
void unlock_file(int descriptor);
/// Who has the lock: "process 4711 (ticktrue)", or "another process" where the system does not say.
std::string lock_holder(int descriptor);

}  // namespace ticktrue::replay
