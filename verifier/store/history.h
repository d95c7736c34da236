// The verdicts of all builds on a trace, and their durations: for `corpus log`, and to plan the next run.
// SPDX-License-Identifier: MIT
//
// A row is a file STORE/history/ab/cdef.../KEY: the folder name identifies the trace, the file name the verdict. No
// verdict is taken from the history. The format does not depend on the build, so each build reads the rows of all
// builds.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/hash128.h"
#include "verifier/report/report.h"
#include "verifier/store/store_folder.h"

namespace ticktrue::verifier {

struct HistoryRow {
  std::string key;  // of the verdict
  Hash128 engine;
  Hash128 libraries;
  std::string options;
  std::string mode;
  std::string commit;       // of the build
  std::string build;        // one line
  std::int64_t when_s = 0;  // since 1970, by the clock of the verifying machine
  double seconds = 0;       // work in seconds of one thread
  std::string verdict;      // its name
  std::uint64_t ticks_recorded = 0;
  std::uint64_t ticks_compared = 0;
  std::uint64_t root_hash = 0;            // of the last state compared
  std::optional<std::uint64_t> diverged;  // first tick with a difference
};

/// The name of a trace in the history.
std::string history_name(const Hash128& trace, std::uint64_t size);

/// Nothing: the bytes are damaged.
std::optional<HistoryRow> decode_history_row(ByteView bytes);

struct TraceHistory {
  std::vector<HistoryRow> rows;       // the oldest first
  std::vector<std::string> warnings;  // rows that are damaged or unreadable
};

class History {
 public:
  /// A row may be lost in a power failure: it is only informative.
  explicit History(const StoreFolder& folder) : folder_(folder.unsynced()) {}

  /// Errors: io.
  Status add(const std::string& trace, const HistoryRow& row) const;
  TraceHistory find(const std::string& trace) const;

 private:
  StoreFolder folder_;
};

}  // namespace ticktrue::verifier
