// The results of a campaign: one row for each seed that was judged, in a file that only grows.
// SPDX-License-Identifier: MIT
//
// DIR/results.tsv: lines of tab-separated columns seed, program, verdict, ticks, tick, table, column, trace, second,
// reason. tick, table, column, trace and second are - where there is none. Of several rows of a seed the last counts.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "verifier/report/report.h"

namespace ticktrue::campaign {

inline constexpr const char* results_name = "results.tsv";

struct SeedResult {
  std::uint64_t seed = 0;
  std::string program;  // digest of words and files, see campaign.h
  verifier::Verdict verdict = verifier::Verdict::error;
  std::uint64_t ticks = 0;            // compared
  std::optional<std::uint64_t> tick;  // of the divergence
  std::string table;                  // of the first difference; empty: not known
  std::string column;
  std::string trace;   // its name in the folder; empty: it was removed
  std::string second;  // of a second recording, likewise
  std::string reason;  // one sentence

  bool operator==(const SeedResult&) const = default;
};

/// A line with its end. Tabs and line ends in texts are escaped as in base/plain_text.h.
std::string result_line(const SeedResult& result);
/// The line of the column names.
std::string results_head();

/// Both included.
struct SeedRange {
  std::uint64_t first = 0;
  std::uint64_t last = ~std::uint64_t{0};
};

/// By seed, of the seeds in the range alone. Lines that no campaign wrote whole count for nothing: of one that was
/// killed, or of another hand (a verdict `error`, a trace outside of the folder).
std::map<std::uint64_t, SeedResult> parse_results(std::string_view text, SeedRange seeds);

/// The file of a folder, locked against another campaign until the end.
class ResultsFile {
 public:
  /// Creates it where there is none. Holds results of these seeds alone, however many the file has. Errors: io (also a
  /// campaign that runs in this folder), limit.
  static Result<ResultsFile> open(const std::string& folder, SeedRange seeds);
  ResultsFile(ResultsFile&& other) noexcept;
  ResultsFile& operator=(ResultsFile&&) = delete;
  ~ResultsFile();

  /// As the file was when it was opened.
  const std::map<std::uint64_t, SeedResult>& before() const { return before_; }
  /// Hands the row to the operating system. Errors: io.
  Status append(const SeedResult& result);

 private:
  ResultsFile(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}
  Status read_all(std::string& text) const;
  Status write_all(std::string_view text) const;

  std::string path_;
  int descriptor_ = -1;
  std::map<std::uint64_t, SeedResult> before_;
};

}  // namespace ticktrue::campaign
