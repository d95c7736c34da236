// The operating system's calls, and nothing of the format.
// SPDX-License-Identifier: MIT
#ifndef _FILE_OFFSET_BITS
#define _FILE_OFFSET_BITS 64  // traces beyond 2 GiB on 32-bit machines
#endif
#include "replay/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#ifdef _WIN32
#include <io.h>
#else
#include <unistd.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

namespace ticktrue::replay {
namespace {

// One call may transfer less than 2 GiB on every system; a smaller bound keeps the loop simple.
constexpr std::size_t transfer_size_max = 64u << 20;

#ifdef _WIN32
constexpr int binary_flag = _O_BINARY;
int open_file(const std::string& path, int flags) {
  return ::_open(path.c_str(), flags | binary_flag, _S_IREAD | _S_IWRITE);
}
int write_some(int descriptor, const std::uint8_t* data, std::size_t size) {
  return ::_write(descriptor, data, static_cast<unsigned>(size));
}
int read_some(int descriptor, std::uint8_t* data, std::size_t size, std::uint64_t offset) {
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
ssize_t write_some(int descriptor, const std::uint8_t* data, std::size_t size) {
  return ::write(descriptor, data, size);
}
ssize_t read_some(int descriptor, std::uint8_t* data, std::size_t size, std::uint64_t offset) {
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
  if (code == ENOSPC) error.hint = "make room or write to another disk; what was written so far stays readable";
  if (code == ENOENT) error.hint = "check the spelling, and that the directory exists";
  if (code == EACCES || code == EPERM || code == EROFS) error.hint = "choose a place you may write to and read from";
  return error;
}

}  // namespace

Result<OutputFile> OutputFile::create(const std::string& path, bool overwrite) {
  OutputFile file;
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(path, failure);
  // What a link points at is replaced, not the link.
  file.path_ = path;
  if (std::filesystem::is_symlink(std::filesystem::symlink_status(path, failure)) &&
      std::filesystem::is_regular_file(status))
    file.path_ = std::filesystem::canonical(path, failure).string();
  if (std::filesystem::is_directory(status))
    return Error{ErrorCode::io, path + ": cannot write: found a directory, expected a file name", "name a file in it"};
  file.is_regular_ = !std::filesystem::exists(status) || std::filesystem::is_regular_file(status);
  if (std::filesystem::exists(status)) {
    if (!overwrite) return Error{ErrorCode::io, path + ": exists: it is not overwritten", "use --force to replace it"};
    if (file.is_regular_) {
      const std::string old_path = file.path_ + ".old";
      // It may be the last good recording, set aside by a recorder that was killed: never ours to replace.
      if (std::filesystem::exists(std::filesystem::symlink_status(old_path, failure)))
        return Error{ErrorCode::io, old_path + ": exists: it is not overwritten",
                     "--force sets the old file aside under this name while it records; move or remove it first"};
      std::filesystem::rename(file.path_, old_path, failure);
      if (failure) return io_error(path, "cannot set aside as " + old_path, failure.value());
      file.old_path_ = old_path;
    }
  }
  const int flags = file.is_regular_ ? O_WRONLY | O_CREAT | O_EXCL : O_WRONLY;
  file.descriptor_ = open_file(file.path_, flags);
  if (file.descriptor_ < 0) {
    const int code = errno;
    if (!file.old_path_.empty()) std::filesystem::rename(file.old_path_, file.path_, failure);
    return io_error(path, "cannot create", code);
  }
  return file;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      old_path_(std::move(other.old_path_)),
      is_regular_(other.is_regular_),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  if (this == &other) return *this;
  close();
  path_ = std::move(other.path_);
  old_path_ = std::move(other.old_path_);
  is_regular_ = other.is_regular_;
  descriptor_ = std::exchange(other.descriptor_, -1);
  return *this;
}

OutputFile::~OutputFile() {
  close();
}

void OutputFile::close() {
  if (descriptor_ >= 0) close_file(descriptor_);
  descriptor_ = -1;
}

Status OutputFile::append(ByteView bytes) {
  while (!bytes.empty()) {
    const std::size_t size = std::min(bytes.size(), transfer_size_max);
    const auto written = write_some(descriptor_, bytes.data(), size);
    if (written < 0) {
      if (errno == EINTR) continue;
      return io_error(path_, "cannot write", errno);
    }
    if (written == 0) return io_error(path_, "cannot write", ENOSPC);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

Status OutputFile::sync() {
  if (!is_regular_) return {};
  while (sync_file(descriptor_) != 0) {
    if (errno == EINTR) continue;
    if (errno == EINVAL || errno == ENOSYS) return {};  // a file system without it
    return io_error(path_, "cannot sync", errno);
  }
  return {};
}

Status OutputFile::commit() {
  const int descriptor = std::exchange(descriptor_, -1);
  // Some network file systems report a full disk only here.
  if (close_file(descriptor) != 0 && errno != EINTR) return io_error(path_, "cannot close", errno);
  std::error_code ignored;
  if (!old_path_.empty()) std::filesystem::remove(old_path_, ignored);
  old_path_.clear();
  return {};
}

void OutputFile::discard() {
  close();
  if (!is_regular_) return;
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
  if (!old_path_.empty()) std::filesystem::rename(old_path_, path_, ignored);
  old_path_.clear();
}

Result<InputFile> InputFile::open(const std::string& path) {
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(path, failure);
  if (!std::filesystem::exists(status)) {
    const int code = failure ? failure.value() : ENOENT;
    return io_error(path, "cannot open", code);
  }
  if (std::filesystem::is_directory(status))
    return Error{ErrorCode::io, path + ": cannot read: found a directory, expected a trace", "name a file in it"};
  if (!std::filesystem::is_regular_file(status))
    return Error{ErrorCode::io, path + ": cannot read: found a device or pipe, expected a file",
                 "copy it to a file first"};
  InputFile file;
  file.descriptor_ = open_file(path, O_RDONLY);
  if (file.descriptor_ < 0) return io_error(path, "cannot open", errno);
  file.size_ = std::filesystem::file_size(path, failure);
  if (failure) return io_error(path, "cannot read its size", failure.value());
  return file;
}

InputFile InputFile::of_bytes(ByteView bytes) {
  InputFile file;
  file.memory_ = bytes;
  file.size_ = bytes.size();
  return file;
}

InputFile::InputFile(InputFile&& other) noexcept
    : memory_(other.memory_), size_(other.size_), descriptor_(std::exchange(other.descriptor_, -1)) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  if (this == &other) return *this;
  if (descriptor_ >= 0) close_file(descriptor_);
  memory_ = other.memory_;
  size_ = other.size_;
  descriptor_ = std::exchange(other.descriptor_, -1);
  return *this;
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) close_file(descriptor_);
}

void InputFile::read(std::uint64_t offset, std::size_t size, Bytes& out) {
  if (offset >= size_) {
    out.clear();
    return;
  }
  size = static_cast<std::size_t>(std::min<std::uint64_t>(size, size_ - offset));
  if (descriptor_ < 0) {
    const ByteView part = memory_.subspan(static_cast<std::size_t>(offset), size);
    out.assign(part.begin(), part.end());
    return;
  }
  out.resize(size);
  std::size_t done = 0;
  while (done < size) {
    const std::size_t part = std::min(size - done, transfer_size_max);
    const auto got = read_some(descriptor_, out.data() + done, part, offset + done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  out.resize(done);
}

}  // namespace ticktrue::replay
