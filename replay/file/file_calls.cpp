// File calls and file locks of POSIX and Windows.
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
#include <windows.h>
#else
#include <unistd.h>
#endif
#ifndef __EMSCRIPTEN__
#define TICKTRUE_HAS_FILE_LOCKS 1
#ifndef _WIN32
#include <sys/file.h>
#endif
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
namespace {

/// Nothing: the bytes are not valid text of this code page.
std::optional<std::wstring> decode(const std::string& text, unsigned code_page) {
  if (text.empty()) return std::wstring();
  const int size = static_cast<int>(text.size());
  const int count = ::MultiByteToWideChar(code_page, MB_ERR_INVALID_CHARS, text.data(), size, nullptr, 0);
  if (count <= 0) return std::nullopt;
  std::wstring wide(static_cast<std::size_t>(count), L'\0');
  ::MultiByteToWideChar(code_page, MB_ERR_INVALID_CHARS, text.data(), size, wide.data(), count);
  return wide;
}

std::string encode_utf8(const std::wstring& wide) {
  if (wide.empty()) return "";
  const int count = static_cast<int>(wide.size());
  const int size = ::WideCharToMultiByte(CP_UTF8, 0, wide.data(), count, nullptr, 0, nullptr, nullptr);
  std::string text(static_cast<std::size_t>(size), '\0');
  ::WideCharToMultiByte(CP_UTF8, 0, wide.data(), count, text.data(), size, nullptr, nullptr);
  return text;
}

}  // namespace

std::string utf8_path(const std::string& path) {
  if (decode(path, CP_UTF8)) return path;
  const std::optional<std::wstring> wide = decode(path, CP_ACP);
  return wide ? encode_utf8(*wide) : path;
}

std::filesystem::path system_path(const std::string& path) {
  return decode(path, CP_UTF8).value_or(L"");
}

int open_file(const std::string& path, int flags) {
  const std::optional<std::wstring> wide = decode(path, CP_UTF8);
  if (!wide) {
    errno = EINVAL;
    return -1;
  }
  return ::_wopen(wide->c_str(), flags | _O_BINARY | _O_NOINHERIT, _S_IREAD | _S_IWRITE);
}
int create_movable_file(const std::string& path) {
  const std::optional<std::wstring> wide = decode(path, CP_UTF8);
  constexpr DWORD shared = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
  const HANDLE file = ::CreateFileW(wide ? wide->c_str() : L"", GENERIC_READ | GENERIC_WRITE, shared, nullptr,
                                    CREATE_NEW, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (file == INVALID_HANDLE_VALUE) {
    const std::error_code code(static_cast<int>(::GetLastError()), std::system_category());
    errno = code.default_error_condition().value();
    return -1;
  }
  return ::_open_osfhandle(reinterpret_cast<std::intptr_t>(file), _O_RDWR | _O_BINARY | _O_NOINHERIT);
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
std::string utf8_path(const std::string& path) {
  return path;
}
std::filesystem::path system_path(const std::string& path) {
  return path;
}
int open_file(const std::string& path, int flags) {
  return ::open(path.c_str(), flags | O_CLOEXEC, 0666);
}
int create_movable_file(const std::string& path) {
  return open_file(path, O_RDWR | O_CREAT | O_EXCL);
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

Error io_error(const std::string& path, const std::string& action, const std::error_code& code) {
  // Error numbers of Windows differ from errno.
  return io_error(path, action, code.default_error_condition().value());
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
  const std::optional<std::wstring> wide = decode(path, CP_UTF8);
  return wide ? ::_wstat64(wide->c_str(), &found) : -1;
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

// A test for a lock holds the lock for at most this long.
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

/// The process in a line of /proc/locks about this file: "1: FLOCK  ADVISORY  WRITE 4711 08:01:1234 0 EOF".
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

#ifdef _WIN32

/// A byte after the end of every file. A lock on Windows keeps other processes from the locked bytes.
OVERLAPPED lock_place() {
  OVERLAPPED place{};
  place.OffsetHigh = 0x7fffffff;
  return place;
}

bool try_lock(int descriptor) {
  OVERLAPPED place = lock_place();
  const auto file = reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor));
  return ::LockFileEx(file, LOCKFILE_EXCLUSIVE_LOCK | LOCKFILE_FAIL_IMMEDIATELY, 0, 1, 0, &place) != 0 ||
         (::GetLastError() != ERROR_LOCK_VIOLATION && ::GetLastError() != ERROR_IO_PENDING);
}

#else

bool try_lock(int descriptor) {
  return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

#endif

}  // namespace

bool lock_file(int descriptor) {
  for (int tries = 0; tries < lock_tries_max; ++tries) {
    if (try_lock(descriptor)) return true;
    std::this_thread::sleep_for(lock_pause);
  }
  return false;
}

void unlock_file(int descriptor) {
#ifdef _WIN32
  OVERLAPPED place = lock_place();
  ::UnlockFileEx(reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor)), 0, 1, 0, &place);
#else
  ::flock(descriptor, LOCK_UN);
#endif
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
