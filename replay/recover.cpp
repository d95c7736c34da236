// Makes a complete trace of what is intact at the start of a broken one.
// SPDX-License-Identifier: MIT
#include <filesystem>
#include <system_error>
#include <utility>

#include "replay/trace_reader.h"
#include "replay/trace_writer.h"

namespace ticktrue::replay {
namespace {

Status copy_item(const TraceReader::Item& item, TraceWriter& writer) {
  if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item))
    return writer.checkpoint_encoded(checkpoint->image, checkpoint->root_hash);
  const auto& tick = std::get<TickRecord>(item);
  if (const Status status = writer.begin_tick({tick.dt, tick.inputs}); !status) return status;
  return writer.end_tick_encoded(tick.root_hash, tick.stage_hashes, tick.image, tick.cells);
}

/// A trace without ticks proves nothing, unless it was recorded so.
bool nothing_saved(const TraceWriter& writer, const TraceTail& tail) {
  return writer.tick_count() == 0 && tail.condition != TraceCondition::complete;
}

Status copy(TraceReader& reader, TraceWriter& writer) {
  for (;;) {
    const TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    if (const Status status = copy_item(item, writer); !status) return status;
  }
  const TraceTail& tail = reader.tail();
  if (nothing_saved(writer, tail)) return {};
  if (tail.has_pending_inputs)
    if (const Status status = writer.begin_tick({tail.pending_dt, tail.pending_inputs}); !status) return status;
  // With its end record, no tick was lost: only index or footer were.
  if (tail.end) return writer.finish(tail.end->reason, tail.end->note);
  return writer.finish(EndReason::recovered, tail.message);
}

}  // namespace

Result<RecoverResult> recover_trace(const std::string& input, const std::string& output, bool overwrite) {
  std::error_code ignored;
  if (std::filesystem::equivalent(input, output, ignored))
    return Error{ErrorCode::usage, output + ": is the trace to recover: it is never changed", "name another output"};
  Result<TraceReader> reader = TraceReader::open(input);
  if (!reader) return reader.error();
  WriterOptions options;
  options.overwrite = overwrite;
  options.compress = reader->is_compressed();
  Result<TraceWriter> writer = TraceWriter::create(output, reader->setup(), reader->facts(), options);
  if (!writer) return writer.error();
  if (const Status status = copy(*reader, *writer); !status) {
    writer->discard();
    return status.error();
  }
  if (nothing_saved(*writer, reader->tail())) writer->discard();
  return RecoverResult{reader->tail(), writer->tick_count()};
}

}  // namespace ticktrue::replay
