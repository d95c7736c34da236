// Maps files: mmap of POSIX, sections of Windows. Other systems refuse.
// SPDX-License-Identifier: MIT
#ifndef _FILE_OFFSET_BITS
#define _FILE_OFFSET_BITS 64  // boxes beyond 2 GiB on 32-bit machines
#endif
#include "replay/file/mapped_file.h"

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "replay/file/file_calls.h"

#ifdef _WIN32
#include <io.h>
#include <windows.h>
#elif !defined(__EMSCRIPTEN__)
#define TICKTRUE_HAS_MMAP 1
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace ticktrue::replay {

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)),
      size_(other.size_),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

#ifdef TICKTRUE_HAS_MMAP
namespace {

/// Returns 0 or an error number. A store into a page without disk space would end the process: pages are reserved
/// first.
int reserve(int descriptor, std::uint64_t size) {
#ifdef __linux__
  return ::posix_fallocate(descriptor, 0, static_cast<off_t>(size));
#else
  return ::ftruncate(descriptor, static_cast<off_t>(size)) == 0 ? 0 : errno;
#endif
}

}  // namespace

Result<MappedFile> MappedFile::create(const std::string& path, std::uint64_t size) {
  MappedFile file;
  file.size_ = size;
  if (size > SIZE_MAX / 2) return io_error(path, "cannot map", ENOMEM);
  file.descriptor_ = create_movable_file(path);
  if (file.descriptor_ < 0) return io_error(path, "cannot create", errno);
  const auto give_up = [&](const char* action, int code) {
    std::error_code ignored;
    std::filesystem::remove(system_path(path), ignored);
    return io_error(path, action, code);
  };
  if (const int code = reserve(file.descriptor_, size); code != 0)
    return give_up(("cannot reserve " + std::to_string(size) + " bytes").c_str(), code);
  void* at = ::mmap(nullptr, static_cast<std::size_t>(size), PROT_READ | PROT_WRITE, MAP_SHARED, file.descriptor_, 0);
  if (at == MAP_FAILED) return give_up("cannot map", errno);
  file.data_ = static_cast<std::uint8_t*>(at);
  lock_file(file.descriptor_);
  return file;
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(data_, static_cast<std::size_t>(size_));
  if (descriptor_ < 0) return;
  unlock_file(descriptor_);
  close_file(descriptor_);
}

#elif defined(_WIN32)

Result<MappedFile> MappedFile::create(const std::string& path, std::uint64_t size) {
  MappedFile file;
  file.size_ = size;
  file.descriptor_ = create_movable_file(path);
  if (file.descriptor_ < 0) return io_error(path, "cannot create", errno);
  const auto give_up = [&](const std::string& action) -> Error {
    const std::error_code code(static_cast<int>(::GetLastError()), std::system_category());
    close_file(std::exchange(file.descriptor_, -1));  // Windows cannot remove an open file
    std::error_code ignored;
    std::filesystem::remove(system_path(path), ignored);
    return io_error(path, action, code);
  };
  // The section has the requested size: the file grows to this size, and its pages are reserved.
  const auto handle = reinterpret_cast<HANDLE>(::_get_osfhandle(file.descriptor_));
  const HANDLE section = ::CreateFileMappingW(handle, nullptr, PAGE_READWRITE, static_cast<DWORD>(size >> 32),
                                              static_cast<DWORD>(size), nullptr);
  if (section == nullptr) return give_up("cannot reserve " + std::to_string(size) + " bytes");
  void* at = ::MapViewOfFile(section, FILE_MAP_READ | FILE_MAP_WRITE, 0, 0, static_cast<SIZE_T>(size));
  const DWORD failure = ::GetLastError();
  ::CloseHandle(section);  // the view keeps the section open
  ::SetLastError(failure);
  if (at == nullptr) return give_up("cannot map");
  file.data_ = static_cast<std::uint8_t*>(at);
  lock_file(file.descriptor_);
  return file;
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::UnmapViewOfFile(data_);
  if (descriptor_ < 0) return;
  unlock_file(descriptor_);
  close_file(descriptor_);
}

#else

Result<MappedFile> MappedFile::create(const std::string& path, std::uint64_t) {
  return Error{ErrorCode::unsupported, path + ": this platform cannot map files into memory", "record a trace"};
}

MappedFile::~MappedFile() = default;

#endif

}  // namespace ticktrue::replay
