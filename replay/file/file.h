// Files for traces: unbuffered append, read at an offset, every error reported.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "base/bytes.h"
#include "base/result.h"

namespace ticktrue::replay {

/// Refuses paths to which no trace can be written: an empty name, a directory, a device, a pipe, a link to nothing, a
/// file that another process is recording to. Changes nothing. An existing file of another kind is not refused.
/// Errors: io.
Status check_output(const std::string& path);

/// An append-only file, locked against other recorders. The operating system has the bytes of an append when the call
/// returns.
class OutputFile {
 public:
  /// With `overwrite`, an existing file is renamed to `<path>.old`. Errors: io, and what check_output refuses.
  static Result<OutputFile> create(const std::string& path, bool overwrite);
  /// An output without a file: each append calls `call`, and the other functions do nothing. `path` is for messages.
  static OutputFile to(const std::string& path, std::function<Status(ByteView)> call);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile();

  Status append(ByteView bytes);
  /// Waits until the bytes are on the disk.
  Status sync();
  /// Refuses a file that another process removed, replaced or wrote to since create. Errors: io.
  Status check_in_place() const;
  /// Calls check_in_place, closes the file, and removes the overwritten file.
  Status commit();
  /// Closes and removes the file (if it is still this file), and restores the overwritten file.
  void discard();

  const std::string& path() const { return path_; }
  /// Path of the overwritten file until commit or discard; empty: no file was overwritten.
  const std::string& old_path() const { return old_path_; }

 private:
  OutputFile() = default;
  Status set_aside(bool overwrite);
  void put_back();
  void close();
  std::string path_;
  std::string old_path_;
  std::function<Status(ByteView)> call_;  // called instead of a file; may be empty
  std::uint64_t size_ = 0;                // bytes appended
  int descriptor_ = -1;
  int old_descriptor_ = -1;  // of the overwritten file, locked
};

/// Bytes to read: a regular file, or memory that outlives this object.
class InputFile {
 public:
  /// Errors: io.
  static Result<InputFile> open(const std::string& path);
  static InputFile of_bytes(ByteView bytes);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;
  ~InputFile();

  /// Size at the time of opening.
  std::uint64_t size() const { return size_; }
  /// Checks that the file is unchanged since it was opened. Errors: io.
  Status check_unchanged(const std::string& path) const;
  /// From now on, ignores all bytes after the first `size_max`.
  void cut(std::uint64_t size_max) { size_ = size_max < size_ ? size_max : size_; }
  /// Fills `out` with at most `size` bytes from `offset`. Fewer bytes: the file ends, or cannot be read.
  void read(std::uint64_t offset, std::size_t size, Bytes& out);

 private:
  InputFile() = default;
  ByteView memory_;
  std::uint64_t size_ = 0;
  // At the time of opening.
  std::uint64_t opened_size_ = 0;
  std::int64_t modified_ns_ = 0;
  std::int64_t changed_ns_ = 0;
  int descriptor_ = -1;
};

}  // namespace ticktrue::replay
