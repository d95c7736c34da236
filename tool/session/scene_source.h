// A scene and its inputs as a source of records without results. Mode `twice` uses it without a recording.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "engine/engine.h"
#include "replay/recorder.h"
#include "verifier/verify/trace_source.h"

namespace ticktrue::tool {

class SceneSource : public verifier::TraceSource {
 public:
  /// `inputs` must outlive this object and is read once. `tick_count` absent: runs until the inputs end.
  SceneSource(const engine::Engine& engine, replay::InputSource& inputs, std::optional<std::uint64_t> tick_count);

  const replay::TraceSetup& setup() const override { return setup_; }
  const replay::TraceReader::Item& next() override;
  bool seek(std::uint64_t) override { return false; }
  void rewind() override {}  // the source is read only once, from its start
  const replay::TraceTail& tail() const override { return tail_; }
  std::optional<std::uint64_t> tick_count_hint() const override { return tick_count_; }

  /// The error that ended the inputs early, if any.
  const std::optional<Error>& error() const { return error_; }

 private:
  replay::TraceSetup setup_;
  replay::InputSource& inputs_;
  std::optional<std::uint64_t> tick_count_;
  replay::TraceTail tail_;
  replay::TraceReader::Item item_;
  std::optional<Error> error_;
  bool at_end_ = false;
};

}  // namespace ticktrue::tool
