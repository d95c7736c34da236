// File calls of POSIX and Windows; file locks of POSIX.
// SPDX-License-Identifier: MIT
#ifndef _FILE_OFFSET_BITS
#define _FILE_OFFSET_BITS 64  // traces beyond 2 GiB on 32-bit machines
#endif
#include "replay/file/file_calls.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#ifdef _WIN32
#include <io.h>
#else
#include <unistd.h>
#endif
#if !defined(_WIN32) && !defined(__EMSCRIPTEN__)
#define TICKTRUE_HAS_FILE_LOCKS 1
#include <sys/file.h>
#endif
#ifdef __linux__
#include <sys/sysmacros.h>
#endif

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

namespace ticktrue::replay {

#ifdef _WIN32
int open_file(const std::string& path, int flags) {
  return ::_open(path.c_str(), flags | _O_BINARY, _S_IREAD | _S_IWRITE);
}
std::int64_t write_some(int descriptor, const std::uint8_t* data, std::size_t size) {
  return ::_write(descriptor, data, static_cast<unsigned>(size));
}
std::int64_t read_some(int descriptor, std::uint8_t* data, std::size_t size, std::uint64_t offset) {
  if (::_lseeki64(descriptor, static_cast<std::int64_t>(offset), SEEK_SET) < 0) return -1;
  return ::_read(descriptor, data, static_cast<unsigned>(size));
}
int sync_file(int descriptor) {
  return ::_commit(descriptor);
}
int close_file(int descriptor) {
  return ::_close(descriptor);
}
#else
int open_file(const std::string& path, int flags) {
  return ::open(path.c_str(), flags | O_CLOEXEC, 0666);
}
std::int64_t write_some(int descriptor, const std::uint8_t* data, std::size_t size) {
  return ::write(descriptor, data, size);
}
std::int64_t read_some(int descriptor, std::uint8_t* data, std::size_t size, std::uint64_t offset) {
  return ::pread(descriptor, data, size, static_cast<off_t>(offset));
}
int sync_file(int descriptor) {
  return ::fsync(descriptor);
}
int close_file(int descriptor) {
  return ::close(descriptor);
}
#endif

Error io_error(const std::string& path, const std::string& action, int code) {
  Error error{ErrorCode::io, path + ": " + action + ": " + std::strerror(code), ""};
  if (code == ENOSPC) error.hint = "make room or write to another disk";
  if (code == EFBIG) error.hint = "raise the limit on the size of files (ulimit -f), or write to another disk";
  if (code == ENOENT) error.hint = "check the spelling, and that the directory exists";
  if (code == EACCES || code == EPERM || code == EROFS) error.hint = "choose a place you may write to and read from";
  return error;
}

namespace {

#ifdef _WIN32
using SystemFacts = struct _stat64;
std::int64_t modified_ns(const SystemFacts& found) {
  return std::int64_t{found.st_mtime} * 1'000'000'000;
}
std::int64_t changed_ns(const SystemFacts& found) {
  return std::int64_t{found.st_ctime} * 1'000'000'000;
}
int system_facts(int descriptor, SystemFacts& found) {
  return ::_fstat64(descriptor, &found);
}
int system_facts(const std::string& path, SystemFacts& found) {
  return ::_stat64(path.c_str(), &found);
}
#else
using SystemFacts = struct stat;
std::int64_t in_ns(const timespec& time) {
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}
#ifdef __APPLE__
std::int64_t modified_ns(const SystemFacts& found) {
  return in_ns(found.st_mtimespec);
}
std::int64_t changed_ns(const SystemFacts& found) {
  return in_ns(found.st_ctimespec);
}
#else
std::int64_t modified_ns(const SystemFacts& found) {
  return in_ns(found.st_mtim);
}
std::int64_t changed_ns(const SystemFacts& found) {
  return in_ns(found.st_ctim);
}
#endif
int system_facts(int descriptor, SystemFacts& found) {
  return ::fstat(descriptor, &found);
}
int system_facts(const std::string& path, SystemFacts& found) {
  return ::stat(path.c_str(), &found);
}
#endif

template <typename File>
std::optional<FileFacts> facts_of(const File& file) {
  SystemFacts found{};
  if (system_facts(file, found) != 0) return std::nullopt;
  return FileFacts{static_cast<std::uint64_t>(found.st_dev), static_cast<std::uint64_t>(found.st_ino),
                   static_cast<std::uint64_t>(found.st_size), modified_ns(found), changed_ns(found)};
}

}  // namespace

std::optional<FileFacts> file_facts(int descriptor) {
  return facts_of(descriptor);
}

std::optional<FileFacts> file_facts(const std::string& path) {
  return facts_of(path);
}

bool is_same_file([[maybe_unused]] const FileFacts& a, [[maybe_unused]] const FileFacts& b) {
#ifdef _WIN32
  return true;
#else
  return a.device == b.device && a.inode == b.inode;
#endif
}

#ifdef TICKTRUE_HAS_FILE_LOCKS

namespace {

// A test whether a file is locked holds the lock for at most this long.
constexpr int lock_tries_max = 10;
constexpr std::chrono::milliseconds lock_pause{10};

#ifdef __linux__

/// The command of a process, printable.
std::string command_name(const std::string& process) {
  std::ifstream in("/proc/" + process + "/comm");
  std::string name;
  std::getline(in, name);
  for (char& c : name)
    if (c < ' ' || c > '~') c = '?';
  return name;
}

/// The process of a line of /proc/locks about this file: "1: FLOCK  ADVISORY  WRITE 4711 08:01:1234 0 EOF".
std::string lock_process(const FileFacts& file) {
  std::ifstream in("/proc/locks");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string number, kind, mode, access, process;
    unsigned device_major = 0, device_minor = 0;
    std::uint64_t inode = 0;
    char colon = 0;
    words >> number >> kind >> mode >> access >> process;
    if (kind != "FLOCK" || access != "WRITE") continue;
    words >> std::hex >> device_major >> colon >> device_minor >> colon >> std::dec >> inode;
    if (words && inode == file.inode && device_major == major(file.device) && device_minor == minor(file.device) &&
        process.find_first_not_of("0123456789") == std::string::npos)
      return process;
  }
  return "";
}

#endif

}  // namespace

bool lock_file(int descriptor) {
  for (int tries = 0; tries < lock_tries_max; ++tries) {
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return true;
    std::this_thread::sleep_for(lock_pause);
  }
  return false;
}

void unlock_file(int descriptor) {
  ::flock(descriptor, LOCK_UN);
}

std::string lock_holder([[maybe_unused]] int descriptor) {
#ifdef __linux__
  const std::optional<FileFacts> facts = file_facts(descriptor);
  const std::string process = facts ? lock_process(*facts) : "";
  if (!process.empty()) return "process " + process + " (" + command_name(process) + ")";
#endif
  return "another process";
}

#else

bool lock_file(int) {
  return true;
}

void unlock_file(int) {}

std::string lock_holder(int) {
  return "another process";
}

#endif

}  // namespace ticktrue::replay
