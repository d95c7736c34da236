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
  /// Creates the file. With `overwrite`, an existing file stays unchanged until close().
  /// Errors: io (exists, unwritable).
  static Result<DataFile> create(const std::string& path, bool overwrite);
  DataFile(DataFile&& other) noexcept;
  DataFile& operator=(DataFile&&) = delete;
  ~DataFile();  // removes the new file unless close() succeeded

  /// Errors: io (disk full).
  Status write(std::string_view text);
  /// Passes all bytes to the operating system and moves the file to its path. To be called once, as the last call.
  Status close();

 private:
  DataFile() = default;
  Error failure(int error_number) const;
  void remove_new() const;

  std::FILE* file_ = nullptr;
  std::string path_;       // as requested; also in messages
  std::string new_path_;   // the file being written; renamed to path_ at the end if it differs
  bool removable_ = true;  // false: a device or a pipe, which is never removed
};

/// Writes a whole file and replaces an older one, or with `overwrite` false refuses to. Errors: io.
Status write_data_file(const std::string& path, std::string_view text, bool overwrite = true);

/// Refuses what DataFile::create refuses, without creating a file. To be called before long work.
Status check_writable_target(const std::string& path, bool overwrite);

/// Refuses an output that is one of the input files of the command, under any name.
Status check_not_read(const std::string& output, const std::vector<std::string>& inputs);

/// The system's text for an errno value.
std::string system_message(int error_number);

}  // namespace ticktrue::verifier
