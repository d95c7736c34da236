// TraceSource: a source of records for verify: a file, or an excerpt in memory.
// SPDX-License-Identifier: MIT
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
};

class ReaderSource : public TraceSource {
 public:
  /// The reader must outlive this object.
  explicit ReaderSource(replay::TraceReader& reader) : reader_(reader) {}
  const replay::TraceSetup& setup() const override { return reader_.setup(); }
  const replay::TraceReader::Item& next() override { return reader_.next(); }
  bool seek(std::uint64_t tick) override { return reader_.seek(tick); }
  void rewind() override { reader_.rewind(); }
  const replay::TraceTail& tail() const override { return reader_.tail(); }
  std::optional<std::uint64_t> tick_count_hint() const override { return reader_.tick_count_hint(); }
  std::uint64_t first_tick() const override { return reader_.first_tick(); }

 private:
  replay::TraceReader& reader_;
};

/// A source that owns its reader.
class OwnedReaderSource : public TraceSource {
 public:
  explicit OwnedReaderSource(replay::TraceReader reader) : reader_(std::move(reader)), source_(reader_) {}
  const replay::TraceSetup& setup() const override { return source_.setup(); }
  const replay::TraceReader::Item& next() override { return source_.next(); }
  bool seek(std::uint64_t tick) override { return source_.seek(tick); }
  void rewind() override { source_.rewind(); }
  const replay::TraceTail& tail() const override { return source_.tail(); }
  std::optional<std::uint64_t> tick_count_hint() const override { return source_.tick_count_hint(); }
  std::uint64_t first_tick() const override { return source_.first_tick(); }

 private:
  replay::TraceReader reader_;
  ReaderSource source_;
};

}  // namespace ticktrue::verifier
