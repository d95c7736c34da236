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
  /// Opens a file and reads its setup and build facts. With `size_max`, as if the file ended there.
  /// Errors: io (no such file, a directory); corrupt, truncated (the setup itself is not whole, or it is no trace);
  /// incompatible (a newer format), unsupported (compressed, and this build has no zstd).
  static Result<TraceReader> open(const std::string& path, std::uint64_t size_max = UINT64_MAX);
  /// The same over bytes in memory, which must outlive the reader.
  static Result<TraceReader> open_bytes(ByteView bytes, const std::string& name);
  TraceReader(TraceReader&&) noexcept;
  TraceReader& operator=(TraceReader&&) noexcept;
  ~TraceReader();

  const TraceSetup& setup() const;
  const BuildFacts& facts() const;
  const std::string& name() const;
  std::uint64_t size() const;  // bytes of the file
  bool is_compressed() const;  // whether its state images may be
  /// The tick of the first checkpoint: 0, but of a trace that begins late.
  std::uint64_t first_tick() const;
  /// Refuses a trace that begins late: for what runs it from its setup. Errors: incompatible.
  Status check_from_start() const;

  using Item = std::variant<std::monostate, TickRecord, CheckpointRecord>;
  /// The next tick or checkpoint, in file order; monostate when there is no more: then see tail(). A tick is returned
  /// only after the 64-bit checksum of its whole chunk was found right (or, in the last chunk of a truncated trace,
  /// the checks of its records).
  const Item& next();
  /// Bytes from the start of the file to the end of the last item that next() returned, for progress.
  std::uint64_t offset() const;

  /// Requires: next() gave monostate.
  const TraceTail& tail() const;

  /// Continues at the last checkpoint with tick <= `tick`: next() returns that checkpoint. Uses the index, or scans
  /// where it is missing or damaged. False if there is none before damage or cut; then reading begins at the start
  /// again. Records before that checkpoint are not read: tail() then describes only the rest.
  bool seek(std::uint64_t tick);
  void rewind();

  /// Ticks recorded according to the end record; nothing where that is missing. Reads the end of the file only, and
  /// believes nothing that is not checked.
  std::optional<std::uint64_t> tick_count_hint() const;

  /// Refuses a file that another process has changed since it was opened. Errors: io.
  Status check_unchanged() const;

 private:
  struct Impl;
  explicit TraceReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Copies all that is intact from the start of `input` into a new, complete trace. Of a ticks chunk that is damaged
/// inside, these are the ticks before the damage, but for the last salvage_margin of them: they are known by the 16-bit
/// checks of their records only, and by those of the records behind them. `tail` describes what was lost. No file is
/// written where no tick of a broken trace is intact. Errors: io (also an input that changes meanwhile), and what
/// TraceReader::open refuses.
inline constexpr std::size_t salvage_margin = 3;  // so that a wrong tick passes once in 2^64 damaged chunks
struct RecoverResult {
  TraceTail tail;
  std::uint64_t ticks_written = 0;
};
Result<RecoverResult> recover_trace(const std::string& input, const std::string& output, bool overwrite);

}  // namespace ticktrue::replay
