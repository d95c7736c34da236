// Which bytes the files of a folder had when they were last read, so that an unchanged file need not be read again.
// SPDX-License-Identifier: MIT
//
// A row holds for a file of the same size, inode, device, time of modification and time of change (ctime), all to the
// nanosecond; a program can set the time of modification, but not the time of change. A file that changed in the last
// ten minutes by the clock of this machine, or in its future, gets no row: it could change once more within the same
// step of the clock of its file system, which may be minutes apart.
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

/// Nothing of the file was written to or replaced between the two looks at it.
bool is_unchanged(const replay::FileFacts& before, const replay::FileFacts& after);

class StatIndex {
 public:
  /// The index of this machine for a folder of traces. A missing or damaged one is empty.
  StatIndex(const StoreFolder& folder, const std::string& traces);

  std::optional<Hash128> find(const std::string& file, const replay::FileFacts& facts) const;
  /// Any thread. `facts`: as they were before and after the bytes were read.
  void note(const std::string& file, const replay::FileFacts& facts, const Hash128& hash);
  /// Writes it, if anything was noted. Errors: io.
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
