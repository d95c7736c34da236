// Traces whose records differ from the recorded ones, with valid checksums.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <variant>

#include "replay/trace_reader.h"
#include "replay/trace_writer.h"
#include "tests/support/catch.h"
#include "verifier/locate/compare_tick.h"

namespace ticktrue::test {

/// Changes of the records. Each function may be empty.
struct Forgery {
  std::function<void(verifier::StoredTick&)> tick = {};
  std::function<void(verifier::StoredCheckpoint&)> checkpoint = {};
};

/// Writes the trace `from` to `to`, uncompressed, with the forged records.
inline void forge_trace(const std::string& from, const std::string& to, const Forgery& forgery) {
  auto reader = replay::TraceReader::open(from);
  REQUIRE(reader.has_value());
  replay::WriterOptions options;
  options.compress = false;
  options.sync = false;
  auto writer = replay::TraceWriter::create(to, reader->setup(), reader->facts(), options);
  REQUIRE(writer.has_value());
  for (;;) {
    const replay::TraceReader::Item& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    if (const auto* record = std::get_if<replay::TickRecord>(&item)) {
      verifier::StoredTick tick = verifier::copy_of(*record);
      if (forgery.tick) forgery.tick(tick);
      REQUIRE(writer->begin_tick({tick.dt, tick.inputs}));
      std::optional<ByteView> image;
      if (tick.image) image = ByteView(*tick.image);
      REQUIRE(writer->end_tick_encoded(tick.root_hash, tick.stage_hashes, image, tick.cells ? &*tick.cells : nullptr));
    } else {
      verifier::StoredCheckpoint checkpoint = verifier::copy_of(std::get<replay::CheckpointRecord>(item));
      if (forgery.checkpoint) forgery.checkpoint(checkpoint);
      REQUIRE(writer->checkpoint_encoded(checkpoint.image, checkpoint.root_hash));
    }
  }
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
}

}  // namespace ticktrue::test
