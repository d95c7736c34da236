// Reads the file of a trace and detects changes made by other processes.
// SPDX-License-Identifier: MIT
#include "replay/file/file.h"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "replay/file/file_calls.h"

namespace ticktrue::replay {

Result<InputFile> InputFile::open(const std::string& path) {
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(system_path(path), failure);
  if (!std::filesystem::exists(status)) {
    if (!failure) return io_error(path, "cannot open", ENOENT);
    return io_error(path, "cannot open", failure);
  }
  if (std::filesystem::is_directory(status))
    return Error{ErrorCode::io, path + ": cannot read: found a directory, expected a trace", "name a file in it"};
  if (!std::filesystem::is_regular_file(status))
    return Error{ErrorCode::io, path + ": cannot read: found a device or pipe, expected a file",
                 "copy it to a file first"};
  InputFile file;
  file.descriptor_ = open_file(path, O_RDONLY);
  if (file.descriptor_ < 0) return io_error(path, "cannot open", errno);
  const std::optional<FileFacts> facts = file_facts(file.descriptor_);
  if (!facts) return io_error(path, "cannot read its size", errno);
  file.size_ = file.opened_size_ = facts->size;
  file.modified_ns_ = facts->modified_ns;
  file.changed_ns_ = facts->changed_ns;
  return file;
}

InputFile InputFile::of_bytes(ByteView bytes) {
  InputFile file;
  file.memory_ = bytes;
  file.size_ = bytes.size();
  return file;
}

InputFile::InputFile(InputFile&& other) noexcept
    : memory_(other.memory_),
      size_(other.size_),
      opened_size_(other.opened_size_),
      modified_ns_(other.modified_ns_),
      changed_ns_(other.changed_ns_),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  if (this == &other) return *this;
  if (descriptor_ >= 0) close_file(descriptor_);
  memory_ = other.memory_;
  size_ = other.size_;
  opened_size_ = other.opened_size_;
  modified_ns_ = other.modified_ns_;
  changed_ns_ = other.changed_ns_;
  descriptor_ = std::exchange(other.descriptor_, -1);
  return *this;
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) close_file(descriptor_);
}

Status InputFile::check_unchanged(const std::string& path) const {
  if (descriptor_ < 0) return {};
  const std::optional<FileFacts> now = file_facts(descriptor_);
  if (!now) return io_error(path, "cannot read its size", errno);
  const std::string hint = "let the program that writes it end, or take a copy, and try again";
  if (now->size != opened_size_)
    return Error{ErrorCode::io,
                 path + ": changed while it was read: size: found " + std::to_string(now->size) + ", expected " +
                     std::to_string(opened_size_),
                 hint};
  if (now->modified_ns != modified_ns_ || now->changed_ns != changed_ns_)
    return Error{ErrorCode::io, path + ": changed while it was read: its times are others than when it was opened",
                 hint};
  return {};
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
