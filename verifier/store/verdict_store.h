// Verdicts by what they are about: the bytes of a trace, the engine that ran it, and how.
// SPDX-License-Identifier: MIT
//
// A verdict is a file STORE/ab/cdef... that is written once and never changed. Readers check length, checksum and key
// before they believe anything in it. A file that fails a check is moved to STORE/damaged/ and counts as absent.
// Two verdicts of one key that differ are a conflict: both stay in STORE/conflicts/, and the key has no verdict until
// people have removed the file that names them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/hash128.h"
#include "verifier/report/report.h"
#include "verifier/store/store_folder.h"

namespace ticktrue::verifier {

/// All that a verdict depends on.
struct VerdictSubject {
  Hash128 trace;           // of the bytes of the file
  std::uint64_t size = 0;  // bytes of the file
  Hash128 engine;          // of the sources, flags and compiler of this build
  Hash128 libraries;       // of the libraries that this process has mapped
  std::string options;     // mode and all else that chooses what is compared
};

/// The name of a verdict: 32 hexadecimal digits.
std::string verdict_key(const VerdictSubject& subject);

/// What the store holds of a key.
struct FoundVerdict {
  enum class Kind { none, verdict, damaged, conflict };
  Kind kind = Kind::none;
  std::optional<Report> report;  // of verdict
  std::string file;              // its file; of damaged: where it is now; of conflict: the one that says so
  std::string what;              // of damaged and conflict: for people
  bool is_new = false;           // of verdict, by add: the store did not have it
};

class VerdictStore {
 public:
  explicit VerdictStore(const StoreFolder& folder) : folder_(folder) {}

  /// Errors: io (a file that cannot be read or moved).
  Result<FoundVerdict> find(const std::string& key) const;

  /// Of `kind` verdict: the report that the store has now, the same as this one. Conflict: it has another.
  /// Requires: the report is of a trace that could be read. Errors: io. After an error the store has no verdict of the
  /// key that differs from this one, as far as it can be removed.
  Result<FoundVerdict> add(const std::string& key, const Report& report) const;

  const StoreFolder& folder() const { return folder_; }

 private:
  /// `bytes` (may be null): the entry as it is in the file.
  Result<FoundVerdict> read_entry(const std::string& key, Bytes* bytes) const;
  Result<FoundVerdict> set_aside(const std::string& key, const std::string& why) const;
  struct Side {
    const Report& report;
    ByteView entry;
  };
  Result<FoundVerdict> add_conflict(const std::string& key, const Side& there, const Side& here) const;

  const StoreFolder& folder_;
};

/// Whether two reports of one key say the same: verdict, ticks compared, last state, first difference.
bool is_same_verdict(const Report& a, const Report& b);

}  // namespace ticktrue::verifier
