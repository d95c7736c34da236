// TraceSource: a source of records for verify: a file, or an excerpt in memory.
// SPDX-License-Identifier: MIT
//
// ReaderSource goes on where TraceReader stops inside a damaged ticks chunk: it gives out the ticks that
// replay::recover_trace would save. Their root hashes are proven by the chained 16-bit checks of their records.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "replay/trace_reader.h"

namespace ticktrue::verifier {

/// The part of TraceReader that verify uses; see the functions of TraceReader.
class TraceSource {
 public:
  virtual ~TraceSource() = default;
  virtual const replay::TraceSetup& setup() const = 0;
  virtual const replay::TraceReader::Item& next() = 0;
  virtual bool seek(std::uint64_t tick) = 0;
  virtual void rewind() = 0;
  virtual const replay::TraceTail& tail() const = 0;
  virtual std::optional<std::uint64_t> tick_count_hint() const = 0;
  virtual std::uint64_t first_tick() const { return 0; }
  /// The first tick of a damaged chunk that next() gives out or gave out; nothing: none so far.
  virtual std::optional<std::uint64_t> salvaged_from() const { return std::nullopt; }
};

class ReaderSource : public TraceSource {
 public:
  /// The reader must outlive this object, and nothing else must move it.
  explicit ReaderSource(replay::TraceReader& reader) : reader_(reader) {}
  const replay::TraceSetup& setup() const override { return reader_.setup(); }
  const replay::TraceReader::Item& next() override;
  bool seek(std::uint64_t tick) override;
  void rewind() override;
  /// Of a trace that is damaged inside a ticks chunk, `ticks_intact` includes the ticks of this chunk.
  const replay::TraceTail& tail() const override { return is_salvaging_ ? tail_ : reader_.tail(); }
  std::optional<std::uint64_t> tick_count_hint() const override { return reader_.tick_count_hint(); }
  std::uint64_t first_tick() const override { return reader_.first_tick(); }
  std::optional<std::uint64_t> salvaged_from() const override { return salvaged_from_; }
  /// As TraceReader::offset().
  std::uint64_t offset() const { return is_salvaging_ ? before_damage_->offset() : reader_.offset(); }

 private:
  void begin_salvage();
  const replay::TraceReader::Item& next_salvaged();

  replay::TraceReader& reader_;
  std::optional<replay::TraceReader> before_damage_;  // the same file, as if it ended at the damage
  bool is_salvaging_ = false;                         // next() reads before_damage_
  replay::TraceTail tail_;                            // of the salvage
  std::optional<std::uint64_t> salvaged_from_;
  const replay::TraceReader::Item end_;
};

/// A source that owns its reader.
class OwnedReaderSource : public TraceSource {
 public:
  explicit OwnedReaderSource(replay::TraceReader reader) : reader_(std::move(reader)), source_(reader_) {}
  OwnedReaderSource(const OwnedReaderSource&) = delete;
  OwnedReaderSource& operator=(const OwnedReaderSource&) = delete;
  const replay::TraceSetup& setup() const override { return source_.setup(); }
  const replay::TraceReader::Item& next() override { return source_.next(); }
  bool seek(std::uint64_t tick) override { return source_.seek(tick); }
  void rewind() override { source_.rewind(); }
  const replay::TraceTail& tail() const override { return source_.tail(); }
  std::optional<std::uint64_t> tick_count_hint() const override { return source_.tick_count_hint(); }
  std::uint64_t first_tick() const override { return source_.first_tick(); }
  std::optional<std::uint64_t> salvaged_from() const override { return source_.salvaged_from(); }
  const replay::BuildFacts& facts() const { return reader_.facts(); }

 private:
  replay::TraceReader reader_;
  ReaderSource source_;
};

}  // namespace ticktrue::verifier
