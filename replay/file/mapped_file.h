// A shared mapped file of fixed size: bytes stored in it survive the process.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/result.h"

namespace ticktrue::replay {

class MappedFile {
 public:
  /// Creates `path`, which must not exist. All bytes are 0 and reserved on disk. The file is locked as by a recorder.
  /// Errors: io; unsupported (a platform that cannot map files).
  static Result<MappedFile> create(const std::string& path, std::uint64_t size);
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile();

  std::uint8_t* data() { return data_; }
  std::uint64_t size() const { return size_; }

 private:
  MappedFile() = default;
  std::uint8_t* data_ = nullptr;
  std::uint64_t size_ = 0;
  int descriptor_ = -1;
};

}  // namespace ticktrue::replay
