// Portable wrappers of the operating system's file calls, for replay/ and the store of verdicts.
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

// On every system, one call transfers less than 2 GiB. A smaller limit keeps the loops simple.
inline constexpr std::size_t transfer_size_max = 64u << 20;

/// The path as UTF-8. Windows: a path that is not valid UTF-8 is decoded with the code page of the process, because
/// arguments of a C program use it. Elsewhere: the same bytes.
std::string utf8_path(const std::string& path);

/// Converts a UTF-8 path for std::filesystem, which on Windows does not read narrow text as UTF-8.
std::filesystem::path system_path(const std::string& path);

/// -1: see errno. Flags are the flags of open(2). On every system the path is UTF-8 and line ends stay unchanged.
int open_file(const std::string& path, int flags);
/// Creates a file for reading and writing that can be renamed while it is open. -1: see errno.
int create_movable_file(const std::string& path);
/// Returns the number of bytes written, which may be less than `size`; -1: see errno.
std::int64_t write_some(int descriptor, const std::uint8_t* data, std::size_t size);
std::int64_t read_some(int descriptor, std::uint8_t* data, std::size_t size, std::uint64_t offset);
int sync_file(int descriptor);
int close_file(int descriptor);

Error io_error(const std::string& path, const std::string& action, int code);
Error io_error(const std::string& path, const std::string& action, const std::error_code& code);

/// The identity and the version of a file.
struct FileFacts {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::uint64_t size = 0;
  std::int64_t modified_ns = 0;
  std::int64_t changed_ns = 0;
};
std::optional<FileFacts> file_facts(int descriptor);
std::optional<FileFacts> file_facts(const std::string& path);
/// Always true on Windows: an open file can be neither removed nor replaced.
bool is_same_file(const FileFacts& a, const FileFacts& b);

/// Takes the lock that a recorder holds on its file. False: another process has the lock. True also if the file system
/// has no locks. The lock ends when the descriptor is closed, or with unlock_file.
bool lock_file(int descriptor);
void unlock_file(int descriptor);
/// The owner of the lock: "process 4711 (ticktrue)", or "another process" if the system does not report it.
std::string lock_holder(int descriptor);

}  // namespace ticktrue::replay
