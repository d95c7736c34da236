// Makes a complete trace from the intact beginning of a damaged one.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <deque>
#include <filesystem>
#include <system_error>
#include <utility>

#include "replay/format/payload.h"
#include "replay/trace_copy.h"
#include "replay/trace_reader.h"
#include "replay/trace_writer.h"

namespace ticktrue::replay {
namespace {

Status copy_checkpoint(const CheckpointRecord& checkpoint, TraceWriter& writer) {
  // Only the first checkpoint itself has the time of a trace that begins late.
  if (!writer.has_checkpoint() && checkpoint.tick > 0) writer.begin_at(checkpoint.tick, checkpoint.time_s.value_or(0));
  if (const Status status = writer.checkpoint_encoded(checkpoint.image, checkpoint.root_hash); !status) return status;
  if (checkpoint.shown)
    if (const Status status = writer.shown(*checkpoint.shown); !status) return status;
  return checkpoint.save ? writer.save(*checkpoint.save) : Status();
}

/// The chunks of the copy begin at other ticks: names are written again.
Status copy_bound(const TickRecord& tick, TraceWriter& writer) {
  bool has_list = false;
  for (const BoundRecord& record : tick.bound) {
    Status status;
    if (record.tag == static_cast<std::uint8_t>(RecordTag::marks)) status = writer.marks(*tick.marks);
    if (record.tag == static_cast<std::uint8_t>(RecordTag::mark_list) && !std::exchange(has_list, true))
      status = writer.mark_list(*tick.mark_list);
    if (record.tag == static_cast<std::uint8_t>(RecordTag::note)) status = writer.note(decode_note(record.body));
    if (!status) return status;
  }
  return {};
}

/// Copies the notes of an incomplete tick. Without its inputs, the tick has not begun.
Status copy_pending_notes(const TraceTail& tail, TraceWriter& writer) {
  if (tail.pending_notes.empty()) return {};
  if (!tail.has_pending_inputs)
    if (const Status status = writer.begin_tick({tail.pending_dt, {}}); !status) return status;
  for (const Note& note : tail.pending_notes)
    if (const Status status = writer.note(note); !status) return status;
  return {};
}

/// A trace without ticks is useless, unless it was recorded without ticks.
bool nothing_saved(const TraceWriter& writer, std::uint64_t first_tick, const TraceTail& tail) {
  return (!writer.has_checkpoint() || writer.tick_count() == first_tick) && tail.condition != TraceCondition::complete;
}

/// A tick that is written only after enough later ticks were read without damage.
struct UnconfirmedTick {
  double dt = 0;
  Bytes inputs;
  std::uint64_t root_hash = 0;
  std::vector<std::uint64_t> stage_hashes;
};

bool is_same_setup(const TraceSetup& a, const TraceSetup& b) {
  ByteWriter bytes_a, bytes_b;
  encode_setup(a, bytes_a);
  encode_setup(b, bytes_b);
  const ByteView left = bytes_a.view(), right = bytes_b.view();
  return std::equal(left.begin(), left.end(), right.begin(), right.end());
}

/// Copies the ticks before the damage in its chunk. A file that ended at the damage would be a truncated trace, and the
/// last chunk of a truncated trace is read record by record.
Status salvage(const std::string& input, const TraceSetup& setup, std::uint64_t damage_offset, TraceWriter& writer) {
  Result<TraceReader> reader = TraceReader::open(input, damage_offset);
  if (!reader) return {};  // damage in the setup or the build facts: no ticks before the damage
  if (!is_same_setup(reader->setup(), setup)) return {};  // the file was replaced; reported at the end
  if (!writer.has_checkpoint()) return {};
  std::deque<UnconfirmedTick> unconfirmed;
  for (;;) {
    const TraceReader::Item& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) return {};
    const auto* tick = std::get_if<TickRecord>(&item);
    if (tick == nullptr || tick->tick < writer.tick_count()) continue;
    if (tick->tick != writer.tick_count() + unconfirmed.size()) return {};  // the file was replaced
    unconfirmed.push_back(
        {tick->dt, Bytes(tick->inputs.begin(), tick->inputs.end()), tick->root_hash, tick->stage_hashes});
    if (unconfirmed.size() <= salvage_margin) continue;
    const UnconfirmedTick& confirmed = unconfirmed.front();
    if (const Status status = writer.begin_tick({confirmed.dt, confirmed.inputs}); !status) return status;
    if (const Status status = writer.end_tick_encoded(confirmed.root_hash, confirmed.stage_hashes, std::nullopt);
        !status)
      return status;
    unconfirmed.pop_front();
  }
}

Status copy(TraceReader& reader, const std::string& input, TraceWriter& writer) {
  for (;;) {
    const TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    if (const Status status = copy_item(item, writer); !status) return status;
  }
  const TraceTail& tail = reader.tail();
  if (tail.condition == TraceCondition::damaged && !tail.end)
    if (const Status status = salvage(input, reader.setup(), tail.offset, writer); !status) return status;
  if (const Status same = reader.check_unchanged(); !same) return same;
  if (nothing_saved(writer, reader.first_tick(), tail)) return {};
  return finish_copy(tail, writer);
}

}  // namespace

Status copy_item(const TraceReader::Item& item, TraceWriter& writer) {
  if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item)) return copy_checkpoint(*checkpoint, writer);
  const auto& tick = std::get<TickRecord>(item);
  if (const Status status = writer.begin_tick({tick.dt, tick.inputs}); !status) return status;
  if (const Status status = copy_bound(tick, writer); !status) return status;
  Bytes image;
  if (tick.image) image = tick.image->joined();
  if (const Status status = writer.end_tick_encoded(
          tick.root_hash, tick.stage_hashes, tick.image ? std::optional<ByteView>(image) : std::nullopt, tick.cells);
      !status)
    return status;
  return tick.shown ? writer.shown(*tick.shown) : Status();
}

Status finish_copy(const TraceTail& tail, TraceWriter& writer) {
  if (tail.has_pending_inputs)
    if (const Status status = writer.begin_tick({tail.pending_dt, tail.pending_inputs}); !status) return status;
  if (const Status status = copy_pending_notes(tail, writer); !status) return status;
  for (const PeerRecord& peer : tail.peers)
    if (const Status status = writer.peer(peer); !status) return status;
  // An intact end record: only index or footer were lost, and no tick.
  if (tail.end) return writer.finish(tail.end->reason, tail.end->note);
  return writer.finish(EndReason::recovered, tail.message);
}

Result<RecoverResult> recover_trace(const std::string& input, const std::string& output, bool overwrite) {
  std::error_code ignored;
  if (std::filesystem::equivalent(input, output, ignored))
    return Error{ErrorCode::usage, output + ": is the trace to recover: it is never changed", "name another output"};
  Result<TraceReader> reader = TraceReader::open(input);
  if (!reader) return reader.error();
  WriterOptions options;
  options.overwrite = overwrite;
  options.compress = reader->is_compressed();
  options.allow_third = true;  // the input may have version 3
  Result<TraceWriter> writer = TraceWriter::create(output, reader->setup(), reader->facts(), options);
  if (!writer) return writer.error();
  if (const Status status = copy(*reader, input, *writer); !status) {
    writer->discard();
    return status.error();
  }
  if (nothing_saved(*writer, reader->first_tick(), reader->tail())) writer->discard();
  const std::uint64_t first_tick = writer->has_checkpoint() ? reader->first_tick() : 0;
  return RecoverResult{reader->tail(), writer->tick_count() - first_tick};
}

}  // namespace ticktrue::replay
