// The hashes of files in a folder at their last reading, so that an unchanged file need not be read again.
// SPDX-License-Identifier: MIT
//
// A row is valid for a file with the same size, inode, device, time of modification and time of change (ctime). Both
// times are compared to the nanosecond. A program can set the time of modification, but not the time of change.
// A file gets no row if it changed in the last ten minutes, or in the future, by the clock of this machine. The clock
// of its file system can differ by minutes and have coarse steps. So the file could change again within one step.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "base/hash128.h"
#include "replay/file/file_calls.h"
#include "verifier/store/store_folder.h"

namespace ticktrue::verifier {

/// Whether the file was neither written nor replaced between the two times.
bool is_unchanged(const replay::FileFacts& before, const replay::FileFacts& after);

class StatIndex {
 public:
  /// The index of this machine for a folder of traces. A missing or damaged index counts as empty.
  StatIndex(const StoreFolder& folder, const std::string& traces);

  std::optional<Hash128> find(const std::string& file, const replay::FileFacts& facts) const;
  /// Thread-safe. `facts`: equal before and after the bytes were read.
  void note(const std::string& file, const replay::FileFacts& facts, const Hash128& hash);
  /// Writes the index if it has changed. Errors: io.
  Status save();

 private:
  struct Row {
    replay::FileFacts facts;
    Hash128 hash;
  };
  void read(ByteView bytes);

  StoreFolder folder_;
  std::string name_;
  mutable std::mutex lock_;
  std::map<std::string, Row> rows_;
  bool has_changed_ = false;
};

}  // namespace ticktrue::verifier
