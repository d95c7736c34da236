// Creates and locks the file of a recorder; renames an overwritten file and restores it on failure.
// SPDX-License-Identifier: MIT
#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "replay/file/file.h"
#include "replay/file/file_calls.h"

namespace ticktrue::replay {
namespace {

namespace fs = std::filesystem;

Error busy_error(const std::string& path, int descriptor) {
  return Error{ErrorCode::io, path + ": cannot write: " + lock_holder(descriptor) + " is recording to it",
               "give another name, or let that recording end"};
}

/// Refuses a file that must not be written to.
Status check_kind(const std::string& path, const fs::file_status& status) {
  const auto refuse = [&](const std::string& found, const std::string& hint) {
    return Error{ErrorCode::io, path + ": cannot write: found " + found + ", expected a file name", hint};
  };
  if (path.empty()) return Error{ErrorCode::io, "output: found an empty name, expected a file name", "name a file"};
  if (fs::is_directory(status)) return refuse("a directory", "name a file in it");
  std::error_code failure;
  if (!fs::exists(status) && fs::is_symlink(fs::symlink_status(system_path(path), failure)))
    return refuse("a link to " + fs::read_symlink(system_path(path), failure).string() + ", which does not exist",
                  "remove the link, or name the file itself");
  if (!fs::exists(status) || fs::is_regular_file(status)) return {};
  return refuse(fs::is_fifo(status)     ? "a pipe"
                : fs::is_socket(status) ? "a socket"
                                        : "a device",
                "a trace is written to a file: recovery and verification read it at any place");
}

/// Opens a file to lock it. Without write permission it is opened for reading: this suffices on local file systems.
int open_existing(const std::string& path) {
  const int descriptor = open_file(path, O_RDWR);
  return descriptor >= 0 ? descriptor : open_file(path, O_RDONLY);
}

}  // namespace

Status check_output(const std::string& path) {
  std::error_code failure;
  const fs::file_status status = fs::status(system_path(path), failure);
  if (const Status kind = check_kind(path, status); !kind) return kind;
  if (!fs::exists(status)) return {};
  const int descriptor = open_existing(path);
  if (descriptor < 0) return {};  // the first write reports the error
  const bool is_free = lock_file(descriptor);
  const Error busy = is_free ? Error{} : busy_error(path, descriptor);
  if (is_free) unlock_file(descriptor);
  close_file(descriptor);
  return is_free ? Status() : busy;
}

Result<OutputFile> OutputFile::create(const std::string& path, bool overwrite) {
  std::error_code failure;
  const fs::file_status status = fs::status(system_path(path), failure);
  if (const Status kind = check_kind(path, status); !kind) return kind.error();
  OutputFile file;
  // A link stays; the file that it points to is replaced.
  file.path_ = fs::is_symlink(fs::symlink_status(system_path(path), failure))
                   ? fs::canonical(system_path(path), failure).string()
                   : std::string(path);
  if (fs::exists(status))
    if (const Status aside = file.set_aside(overwrite); !aside) return aside.error();
  file.descriptor_ = open_file(file.path_, O_WRONLY | O_CREAT | O_EXCL | O_APPEND);
  if (file.descriptor_ < 0) {
    const int code = errno;
    file.put_back();
    return io_error(path, "cannot create", code);
  }
  if (lock_file(file.descriptor_)) return file;
  // Another recorder with --force was faster: the file belongs to that recorder.
  const Error busy = busy_error(path, file.descriptor_);
  file.close();
  return busy;
}

OutputFile OutputFile::to(const std::string& path, std::function<Status(ByteView)> call) {
  OutputFile file;
  file.path_ = path;
  file.call_ = std::move(call);
  return file;
}

Status OutputFile::set_aside(bool overwrite) {
  old_descriptor_ = open_existing(path_);
  if (old_descriptor_ >= 0 && !lock_file(old_descriptor_)) {
    const Error busy = busy_error(path_, old_descriptor_);
    close_file(std::exchange(old_descriptor_, -1));
    return busy;
  }
  if (!overwrite) return Error{ErrorCode::io, path_ + ": exists: it is not overwritten", "use --force to replace it"};
  const std::string aside = path_ + ".old";
  std::error_code failure;
  // The file can be the last good recording of a killed recorder: it is never replaced.
  if (fs::exists(fs::symlink_status(system_path(aside), failure)))
    return Error{ErrorCode::io, aside + ": exists: it is not overwritten",
                 "--force sets the old file aside under this name while it records; move or remove it first"};
  const auto locked = old_descriptor_ < 0 ? std::nullopt : file_facts(old_descriptor_);
  const auto present = file_facts(path_);
  if (locked && (!present || !is_same_file(*locked, *present)))
    return Error{ErrorCode::io, path_ + ": cannot write: another program replaced it just now", "try again"};
#ifdef _WIN32
  if (old_descriptor_ >= 0) close_file(std::exchange(old_descriptor_, -1));  // Windows cannot rename an open file
#endif
  fs::rename(system_path(path_), system_path(aside), failure);
  if (failure) return io_error(path_, "cannot set aside as " + aside, failure);
  old_path_ = aside;
  return {};
}

/// Restores the overwritten file. If another file has its name by now, both files stay.
void OutputFile::put_back() {
  if (old_path_.empty()) return;
  std::error_code failure;
  fs::create_hard_link(system_path(old_path_), system_path(path_), failure);
  if (!failure)
    fs::remove(system_path(old_path_), failure);
  else if (!fs::exists(fs::symlink_status(system_path(path_), failure)))
    fs::rename(system_path(old_path_), system_path(path_), failure);  // for a file system without hard links
  old_path_.clear();
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      old_path_(std::move(other.old_path_)),
      call_(std::move(other.call_)),
      size_(other.size_),
      descriptor_(std::exchange(other.descriptor_, -1)),
      old_descriptor_(std::exchange(other.old_descriptor_, -1)) {}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  if (this == &other) return *this;
  close();
  path_ = std::move(other.path_);
  old_path_ = std::move(other.old_path_);
  call_ = std::move(other.call_);
  size_ = other.size_;
  descriptor_ = std::exchange(other.descriptor_, -1);
  old_descriptor_ = std::exchange(other.old_descriptor_, -1);
  return *this;
}

OutputFile::~OutputFile() {
  close();
}

void OutputFile::close() {
  for (int* descriptor : {&descriptor_, &old_descriptor_}) {
    if (*descriptor < 0) continue;
    unlock_file(*descriptor);  // a forked process may have inherited the descriptor
    close_file(std::exchange(*descriptor, -1));
  }
}

Status OutputFile::append(ByteView bytes) {
  if (call_) {
    size_ += bytes.size();
    return call_(bytes);
  }
  while (!bytes.empty()) {
    const std::size_t size = std::min(bytes.size(), transfer_size_max);
    const std::int64_t written = write_some(descriptor_, bytes.data(), size);
    if (written < 0) {
      if (errno == EINTR) continue;
      return io_error(path_, "cannot write", errno);
    }
    if (written == 0) return io_error(path_, "cannot write", ENOSPC);
    size_ += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

Status OutputFile::sync() {
  if (call_) return {};
  while (sync_file(descriptor_) != 0) {
    if (errno == EINTR) continue;
    if (errno == EINVAL || errno == ENOSYS) return {};  // the file system has no fsync
    return io_error(path_, "cannot sync", errno);
  }
  return {};
}

Status OutputFile::check_in_place() const {
  if (call_) return {};
  const std::optional<FileFacts> mine = file_facts(descriptor_);
  if (!mine) return io_error(path_, "cannot read its size", errno);
  const std::optional<FileFacts> there = file_facts(path_);
  const std::string old = old_path_.empty() ? "" : "; the file from before is " + old_path_;
  if (!there)
    return Error{ErrorCode::io, path_ + ": was removed while it was written",
                 "record again, to a place that no other program clears" + old};
  if (!is_same_file(*mine, *there))
    return Error{ErrorCode::io, path_ + ": was replaced by another file while it was written",
                 "record again, to a name that no other program writes" + old};
  if (mine->size != size_)
    return Error{ErrorCode::io,
                 path_ + ": was changed by another program while it was written: size: found " +
                     std::to_string(mine->size) + ", expected " + std::to_string(size_),
                 "record again, to a name that no other program writes" + old};
  return {};
}

Status OutputFile::commit() {
  if (call_) return {};
  if (const Status in_place = check_in_place(); !in_place) {
    close();
    return in_place;
  }
  unlock_file(descriptor_);
  // Some network file systems report a full disk only when a file is closed.
  if (close_file(std::exchange(descriptor_, -1)) != 0 && errno != EINTR) return io_error(path_, "cannot close", errno);
  std::error_code ignored;
  if (!old_path_.empty()) fs::remove(system_path(old_path_), ignored);
  old_path_.clear();
  close();
  return {};
}

void OutputFile::discard() {
  if (call_) return;
  const std::optional<FileFacts> mine = descriptor_ < 0 ? std::nullopt : file_facts(descriptor_);
  const std::optional<FileFacts> there = file_facts(path_);
  const bool is_mine = mine && there && is_same_file(*mine, *there);
#ifdef _WIN32
  close();  // Windows cannot remove an open file
#endif
  std::error_code ignored;
  if (is_mine) fs::remove(system_path(path_), ignored);
  put_back();
  close();
}

}  // namespace ticktrue::replay
