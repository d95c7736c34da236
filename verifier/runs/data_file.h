// An output file of a command: never overwrites a file without --overwrite, never leaves a partial file.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace ticktrue::verifier {

class DataFile {
 public:
  /// Creates the file. With `overwrite` an existing one stays as it is until close().
  /// Errors: io (exists, unwritable).
  static Result<DataFile> create(const std::string& path, bool overwrite);
  DataFile(DataFile&& other) noexcept;
  DataFile& operator=(DataFile&&) = delete;
  ~DataFile();  // removes what was written unless close() succeeded

  /// Errors: io (disk full).
  Status write(std::string_view text);
  /// Hands everything to the operating system and puts the file in its place. Call once, last.
  Status close();

  std::uint64_t size() const { return size_; }  // bytes written so far

 private:
  DataFile() = default;
  Error failure(int error_number) const;
  void remove_new() const;

  std::FILE* file_ = nullptr;
  std::string path_;       // as asked for, for messages too
  std::string new_path_;   // what is being written; renamed to path_ at the end where it differs
  bool removable_ = true;  // false: a device or a pipe, not ours to remove
  std::uint64_t size_ = 0;
};

/// A whole file, over an older one. Errors: io.
Status write_data_file(const std::string& path, std::string_view text);

/// What DataFile::create refuses, without creating anything: asked before long work begins.
Status check_writable_target(const std::string& path, bool overwrite);

/// Refuses an output that is one of the files the command reads, under whatever name.
Status check_not_read(const std::string& output, const std::vector<std::string>& inputs);

/// "what the operating system says" for an errno value.
std::string system_message(int error_number);

}  // namespace ticktrue::verifier
