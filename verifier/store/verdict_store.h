// Verdicts by their subject: the bytes of a trace, the engine that ran it, and the options.
// SPDX-License-Identifier: MIT
//
// A verdict is a file STORE/ab/cdef... that is written once and never changed. Readers check length, checksum and key
// before they use anything else. A file that fails a check is moved to STORE/damaged/ and counts as absent.
// Two different verdicts of one key are a conflict: both stay in STORE/conflicts/. The key has no verdict until a
// person removes the file that names them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/hash128.h"
#include "verifier/report/report.h"
#include "verifier/store/store_folder.h"

namespace ticktrue::verifier {

/// Everything on which a verdict depends.
struct VerdictSubject {
  Hash128 trace;           // of the bytes of the file
  std::uint64_t size = 0;  // bytes of the file
  Hash128 engine;          // of the sources, flags and compiler of this build
  Hash128 libraries;       // of the mapped libraries of this process
  std::string options;     // mode and all other options that choose what is compared
};

/// The name of a verdict: 32 hexadecimal digits.
std::string verdict_key(const VerdictSubject& subject);

/// The entry of the store for a key.
struct FoundVerdict {
  enum class Kind { none, verdict, damaged, conflict };
  Kind kind = Kind::none;
  std::optional<Report> report;  // for a verdict
  std::string file;              // file of the entry; damaged: its new place; conflict: the file that names both sides
  std::string what;              // for damaged and conflict: text for people
  bool is_new = false;           // for a verdict returned by add: the store did not have it
};

class VerdictStore {
 public:
  explicit VerdictStore(const StoreFolder& folder) : folder_(folder) {}

  /// Errors: io (a file that cannot be read or moved).
  Result<FoundVerdict> find(const std::string& key) const;

  /// `kind` verdict: the store now has this report. Conflict: the store has a different one. Requires: the report is
  /// about a readable trace.
  /// Errors: io. After an error the store has no different verdict for the key, as far as it can be removed.
  Result<FoundVerdict> add(const std::string& key, const Report& report) const;

  const StoreFolder& folder() const { return folder_; }

 private:
  /// `bytes` (may be null): set to the entry in the file.
  Result<FoundVerdict> read_entry(const std::string& key, Bytes* bytes) const;
  Result<FoundVerdict> set_aside(const std::string& key, const std::string& why) const;
  struct Side {
    const Report& report;
    ByteView entry;
  };
  Result<FoundVerdict> add_conflict(const std::string& key, const Side& there, const Side& here) const;

  const StoreFolder& folder_;
};

/// Whether two reports for one key agree in verdict, ticks compared, last state and first difference.
bool is_same_verdict(const Report& a, const Report& b);

}  // namespace ticktrue::verifier
