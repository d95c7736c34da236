// A folder to which many processes on many machines write at once: each file is published whole under a new name.
// SPDX-License-Identifier: MIT
//
// Requirements on the file system, also on NFS (version 3 and later):
// - link(2) is atomic on the server and fails if the name exists. A repeated request can report this failure although
// it succeeded: then the temporary file has two links, and the call counts as successful.
// - rename(2) is atomic on the server: a reader of the name sees the old file or the new one.
// - close(2) passes the written bytes to the server, and open(2) asks the server for the present file. A file is
// published only after it was closed, and a file is read only after it was opened anew.
// No lock (flock, fcntl) and no clock is needed.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"

namespace ticktrue::verifier {

class StoreFolder {
 public:
  enum class Use { reading, writing };
  /// `writing`: makes the folder if it is missing or empty. `syncs`: a file is on the disk before it gets its name.
  /// Errors: io; usage (a folder with other files); unsupported (no hard links).
  static Result<StoreFolder> open(const std::string& path, Use use, bool syncs);

  /// The same folder and owner, for files that need not survive a power failure.
  StoreFolder unsynced() const;

  /// A name of this folder as a path.
  std::string path_of(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }
  /// Host, process and a random number: no other process has the same.
  const std::string& owner() const { return owner_; }

  enum class Publish { created, exists };
  /// Makes a file with this name, unless it exists. Errors: io.
  Result<Publish> publish(const std::string& name, ByteView bytes) const;
  /// Makes a file with this name, and replaces an existing file. Errors: io.
  Status replace(const std::string& name, ByteView bytes) const;

  /// The bytes of a file; nothing: there is no such file. Errors: io; limit (larger than `size_max`).
  Result<std::optional<Bytes>> read(const std::string& name, std::size_t size_max) const;
  /// Moves a file to damaged/ and returns its new name. Empty: another process moved it. Errors: io.
  Result<std::string> set_aside(const std::string& name) const;
  /// Moves a file back after set_aside. If the old name is taken by now, the file stays.
  void put_back(const std::string& aside, const std::string& name) const;
  void remove(const std::string& name) const;
  bool exists(const std::string& name) const;
  /// The files of a folder, sorted by name; empty if there is no such folder.
  std::vector<std::string> list(const std::string& name) const;

 private:
  StoreFolder(std::string path, bool syncs);
  Status prepare(Use use) const;
  void remove_old_temporaries() const;
  std::string temporary_name() const;
  Status write_temporary(const std::string& path, ByteView bytes) const;

  std::string path_;
  bool syncs_;
  std::string owner_;
};

/// "ab/cdef..." for "abcdef...": a folder has at most a 256th of the files.
std::string spread_name(const std::string& name);

}  // namespace ticktrue::verifier
