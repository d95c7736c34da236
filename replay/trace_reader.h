// Reads a trace from start to end in bounded memory, checks every byte, and reports the intact part of a damaged one.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "base/result.h"
#include "replay/format/trace.h"

namespace ticktrue::replay {

class TraceReader {
 public:
  /// Opens a file and reads its setup and build facts. `size_max`: later bytes of the file are ignored.
  /// Errors: io (no such file, a directory); corrupt, truncated (the setup is damaged or incomplete, or the file is not
  /// a trace); incompatible (a newer format), unsupported (compressed, and this build has no zstd).
  static Result<TraceReader> open(const std::string& path, std::uint64_t size_max = UINT64_MAX);
  /// The same for bytes in memory, which must outlive the reader.
  static Result<TraceReader> open_bytes(ByteView bytes, const std::string& name);
  TraceReader(TraceReader&&) noexcept;
  TraceReader& operator=(TraceReader&&) noexcept;
  ~TraceReader();

  const TraceSetup& setup() const;
  const BuildFacts& facts() const;
  const std::string& name() const;
  std::uint64_t size() const;  // bytes of the file
  bool is_compressed() const;  // whether its state images may be compressed
  /// The tick of the first checkpoint: 0, unless the trace begins late.
  std::uint64_t first_tick() const;
  /// Refuses a trace that begins late, for callers that run a trace from its setup. Errors: incompatible.
  Status check_from_start() const;

  using Item = std::variant<std::monostate, TickRecord, CheckpointRecord>;
  /// The next tick or checkpoint, in file order; monostate: the end, see tail(). A tick is returned only after the
  /// 64-bit checksum of its whole chunk was checked. In the last chunk of a truncated trace, the checks of its records
  /// suffice.
  const Item& next();
  /// Bytes from the start of the file to the end of the last item that next() returned, for progress.
  std::uint64_t offset() const;

  /// Requires: next() returned monostate.
  const TraceTail& tail() const;

  /// Continues at the last checkpoint with tick <= `tick`: next() returns this checkpoint. Uses the index; if the index
  /// is missing or damaged, scans the file. False: there is no such checkpoint before damage or cut, and reading begins
  /// at the start again. Earlier records are not read: tail() then describes only the rest.
  bool seek(std::uint64_t tick);
  void rewind();

  /// The number of ticks in the end record; nothing: the end record is missing. Reads only the end of the file, and
  /// uses only checked records.
  std::optional<std::uint64_t> tick_count_hint() const;

  /// Refuses a file that another process has changed since it was opened. Errors: io.
  Status check_unchanged() const;

 private:
  struct Impl;
  explicit TraceReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Copies the intact part at the start of `input` into a new, complete trace. If a ticks chunk is damaged inside, its
/// ticks before the damage are copied, except the last salvage_margin ticks. Only the 16-bit checks of their records
/// and of later records prove these ticks. `tail` describes the loss. No file is written if the trace is broken and no
/// tick is intact.
/// Errors: io (also if the input changes meanwhile), and the errors of TraceReader::open.
inline constexpr std::size_t salvage_margin = 3;  // a wrong tick passes in one of 2^64 damaged chunks
struct RecoverResult {
  TraceTail tail;
  std::uint64_t ticks_written = 0;
};
Result<RecoverResult> recover_trace(const std::string& input, const std::string& output, bool overwrite);

}  // namespace ticktrue::replay
