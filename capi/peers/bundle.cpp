// Writes a bundle. It begins where a program can begin: at a save before the differing tick, or at tick 0.
// SPDX-License-Identifier: MIT
#include "capi/peers/bundle.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>
#include <variant>

#include "base/hash.h"
#include "replay/box/recover_box.h"
#include "replay/file/file_calls.h"
#include "replay/trace_copy.h"
#include "replay/trace_reader.h"
#include "replay/trace_writer.h"
#include "verifier/report/report.h"

namespace ticktrue::capi {
namespace {

constexpr std::uint32_t bundle_features =
    static_cast<std::uint32_t>(replay::Feature::tail) | static_cast<std::uint32_t>(replay::Feature::peers);

/// The parts of a bundle except its ticks. They do not depend on the source of the ticks.
struct BundleParts {
  const DesyncFinding& finding;
  const KeptState* own = nullptr;  // state after the differing tick; null: unknown
  std::uint64_t own_root = 0;
  std::vector<replay::PeerRecord> records;

  /// The bundle must begin at or before this tick, so that it contains the last tick that all players agree on.
  std::uint64_t begin_max() const { return finding.agreed.value_or(finding.tick); }
};

Result<replay::TraceWriter> create(const std::string& path, bool overwrite, replay::TraceSetup setup,
                                   const replay::BuildFacts& facts) {
  setup.features |= bundle_features;
  replay::WriterOptions options;
  options.overwrite = overwrite;
  options.allow_third = true;
  return replay::TraceWriter::create(path, setup, facts, options);
}

Status finish(replay::TraceWriter& writer, const BundleParts& parts) {
  for (const replay::PeerRecord& record : parts.records)
    if (const Status status = writer.peer(record); !status) return status;
  return writer.finish(replay::EndReason::complete, "");
}

/// The ticks of a trace from a checkpoint on.
class TraceTicks {
 public:
  explicit TraceTicks(replay::TraceReader reader) : reader_(std::move(reader)) {}

  /// Finds the checkpoint at which to begin. False: the trace has none.
  bool find_begin(const BundleParts& parts) {
    const bool wants_save = reader_.setup().has(replay::Feature::saves);
    std::optional<std::uint64_t> first, saved;
    reader_.rewind();
    for (;;) {
      const replay::TraceReader::Item& item = reader_.next();
      if (std::holds_alternative<std::monostate>(item)) break;
      const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item);
      if (checkpoint == nullptr) continue;
      if (checkpoint->tick > parts.begin_max()) break;
      if (!first) first = checkpoint->tick;
      if (checkpoint->save) saved = checkpoint->tick;
    }
    if (!first) return false;
    begin_ = wants_save && saved ? *saved : *first;
    written.has_save = wants_save && saved.has_value();
    return true;
  }

  const replay::TraceSetup& setup() const { return reader_.setup(); }
  const replay::BuildFacts& facts() const { return reader_.facts(); }

  Status copy(const BundleParts& parts, replay::TraceWriter& writer) {
    if (!reader_.seek(begin_)) return Error{ErrorCode::io, reader_.name() + ": the file changed", ""};
    bool is_state_due = false;
    for (;;) {
      const replay::TraceReader::Item& item = reader_.next();
      const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item);
      if (std::exchange(is_state_due, false) && checkpoint == nullptr)
        if (const Status status = writer.checkpoint(parts.own->view(), parts.own_root); !status) return status;
      if (std::holds_alternative<std::monostate>(item)) break;
      if (const Status status = replay::copy_item(item, writer); !status) return status;
      const auto* tick = std::get_if<replay::TickRecord>(&item);
      is_state_due = tick != nullptr && tick->tick == parts.finding.tick && !tick->image && parts.own != nullptr;
    }
    written.first_tick = begin_;
    written.end = writer.tick_count();
    written.is_of_recording = true;
    return finish(writer, parts);
  }

  WrittenBundle written;

 private:
  replay::TraceReader reader_;
  std::uint64_t begin_ = 0;
};

/// Opens the recording as a trace. `bytes`: storage for the recording of a box.
Result<TraceTicks> open_recording(const BundleSource& source, Bytes& bytes) {
  if (!source.is_box) {
    Result<replay::TraceReader> reader = replay::TraceReader::open(source.recording);
    if (!reader) return reader.error();
    return TraceTicks(std::move(*reader));
  }
  Result<Bytes> saved = replay::save_box(source.recording);
  if (!saved) return saved.error();
  bytes = std::move(*saved);
  Result<replay::TraceReader> reader = replay::TraceReader::open_bytes(bytes, source.recording);
  if (!reader) return reader.error();
  return TraceTicks(std::move(*reader));
}

Status write_kept(const KeptTicks& kept, const BundleParts& parts, replay::TraceWriter& writer,
                  WrittenBundle& written) {
  const KeptState* initial = kept.initial();
  auto next = kept.ticks().begin();
  if (initial == nullptr) {
    writer.begin_at(next->tick + 1, next->time_s + next->inputs.dt);
    initial = &next->state;
    ++next;
  }
  written.first_tick = writer.tick_count();
  if (const Status status = writer.checkpoint(initial->view(), root_hash(initial->view())); !status) return status;
  for (; next != kept.ticks().end(); ++next) {
    const std::uint64_t root = root_hash(next->state.view());
    if (const Status status = writer.begin_tick({next->inputs.dt, next->input_bytes}); !status) return status;
    if (const Status status = writer.end_tick(root, {}, &next->state.view()); !status) return status;
    if (next->tick == parts.finding.tick)
      if (const Status status = writer.checkpoint(next->state.view(), root); !status) return status;
  }
  written.end = writer.tick_count();
  return finish(writer, parts);
}

/// Whether the ticks in memory begin with a state before the differing tick.
bool reaches_back(const KeptTicks& kept, const BundleParts& parts) {
  if (kept.ticks().empty() || kept.ticks().back().tick < parts.finding.tick) return false;
  return kept.initial() != nullptr || kept.ticks().front().tick < parts.finding.tick;
}

}  // namespace

Result<WrittenBundle> write_bundle(const std::string& path, bool overwrite, const BundleSource& source, Peers& peers,
                                   const RowNamer& row_name) {
  std::error_code ignored;
  if (!source.recording.empty() &&
      std::filesystem::equivalent(replay::system_path(path), replay::system_path(source.recording), ignored))
    return Error{ErrorCode::usage, path + ": is the file that this session records", "name another output"};
  const DesyncFinding finding = peers.finding(row_name);
  BundleParts parts{finding, peers.state_at_desync(), peers.roots().at(finding.tick).value_or(0),
                    peers.records(finding)};
  Bytes bytes;
  std::optional<TraceTicks> ticks;
  std::string missing;
  if (!source.recording.empty()) {
    Result<TraceTicks> opened = open_recording(source, bytes);
    if (!opened)
      missing = opened.error().message;
    else if (!opened->find_begin(parts))
      missing = source.recording + ": begins behind the tick that differs";
    else
      ticks.emplace(std::move(*opened));
  }
  const auto done = [&](Result<replay::TraceWriter>& writer, const Status& status,
                        const WrittenBundle& written) -> Result<WrittenBundle> {
    if (status) return written;
    writer->discard();
    return status.error();
  };
  if (ticks) {
    Result<replay::TraceWriter> writer = create(path, overwrite, ticks->setup(), ticks->facts());
    if (!writer) return writer.error();
    const Status status = ticks->copy(parts, *writer);
    return done(writer, status, ticks->written);
  }
  if (!reaches_back(peers.kept(), parts))
    return Error{ErrorCode::usage,
                 "bundle: found no tick before tick " + std::to_string(finding.tick) + ", which differs" +
                     (missing.empty() ? "" : "; " + missing),
                 "record the game, into a file or a larger black box, or raise peer_bytes in the options"};
  WrittenBundle written;
  written.missing = missing.empty() ? "the session records nothing" : missing;
  Result<replay::TraceWriter> writer = create(path, overwrite, source.game, source.facts);
  if (!writer) return writer.error();
  const Status status = write_kept(peers.kept(), parts, *writer, written);
  return done(writer, status, written);
}

std::string bundle_text(const std::string& path, const WrittenBundle& written) {
  std::string text = "bundle " + path + ": ticks " + std::to_string(written.first_tick) + ".." +
                     std::to_string(std::max(written.end, written.first_tick + 1) - 1) +
                     (written.is_of_recording ? " of the recording" : " of those in memory");
  if (!written.missing.empty()) text += "; " + written.missing;
  if (written.first_tick > 0 && !written.has_save)
    text += "; it holds no save: it names the place and cannot be run again";
  return text + "; `ticktrue show " + verifier::shell_word(path) + "` says who differs";
}

}  // namespace ticktrue::capi
