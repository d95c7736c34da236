// Files as the trace code needs them: append without buffer, read at an offset, every error told.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/bytes.h"
#include "base/result.h"

namespace ticktrue::replay {

/// A file that only grows. Each append is in the hands of the operating system when it returns.
class OutputFile {
 public:
  /// With `overwrite`, an existing regular file is renamed to `<path>.old`; a device or pipe is written to as it is.
  /// Errors: io.
  static Result<OutputFile> create(const std::string& path, bool overwrite);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile();

  Status append(ByteView bytes);
  /// To the disk itself, where the target is one.
  Status sync();
  /// Closes, and removes what was overwritten.
  Status commit();
  /// Closes, removes the file and puts back what was overwritten.
  void discard();

  const std::string& path() const { return path_; }

 private:
  OutputFile() = default;
  void close();
  std::string path_;
  std::string old_path_;  // of the overwritten file, empty if there was none
  bool is_regular_ = false;
  int descriptor_ = -1;
};

/// Bytes to read: a regular file, or memory that must outlive this.
class InputFile {
 public:
  /// Errors: io.
  static Result<InputFile> open(const std::string& path);
  static InputFile of_bytes(ByteView bytes);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;
  ~InputFile();

  /// Size when it was opened.
  std::uint64_t size() const { return size_; }
  /// Nothing behind `size_max` bytes is seen from now on.
  void cut(std::uint64_t size_max) { size_ = size_max < size_ ? size_max : size_; }
  /// Fills `out` with at most `size` bytes from `offset`; fewer only where the file ends or cannot be read.
  void read(std::uint64_t offset, std::size_t size, Bytes& out);

 private:
  InputFile() = default;
  ByteView memory_;
  std::uint64_t size_ = 0;
  int descriptor_ = -1;
};

}  // namespace ticktrue::replay
