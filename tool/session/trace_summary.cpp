// Reads a trace once and counts its content.
// SPDX-License-Identifier: MIT
#include "tool/session/trace_summary.h"

#include <variant>

#include "engine/scene/scene_json.h"
#include "tool/session/playback.h"
#include "verifier/report/report.h"
#include "verifier/verify/trace_source.h"

namespace ticktrue::tool {

InputListing::InputListing(const replay::TraceSetup& setup) {
  Result<engine::Scene> scene = scene_of(setup);
  if (scene) scene_ = std::move(*scene);
}

std::string InputListing::text(std::uint64_t tick, ByteView inputs) {
  if (inputs.empty()) return "";
  if (scene_ && engine::decode_inputs(*scene_, inputs, inputs_)) {
    std::string lines;
    for (engine::Input& input : inputs_) {
      input.tick = tick;
      lines += engine::print_input(*scene_, input) + "\n";
    }
    return lines;
  }
  std::string line = "{\"tick\":" + std::to_string(tick) + ",\"bytes\":\"";
  for (const std::uint8_t byte : inputs) {
    line += "0123456789abcdef"[byte >> 4];
    line += "0123456789abcdef"[byte & 15];
  }
  return line + "\"}\n";
}

std::string InputListing::end_text(std::uint64_t tick) const {
  return "{\"tick\":" + std::to_string(tick) + ",\"kind\":\"end\"}\n";
}

bool InputListing::count(ByteView inputs, std::vector<std::uint64_t>& count_of_kind) {
  if (inputs.empty()) return true;
  if (!scene_ || !engine::decode_inputs(*scene_, inputs, inputs_)) return false;
  for (const engine::Input& input : inputs_) ++count_of_kind[static_cast<std::size_t>(input.kind)];
  return true;
}

TraceSummary summarize(replay::TraceReader& trace, const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  TraceSummary summary;
  verifier::ReaderSource reader(trace);
  InputListing listing(reader.setup());
  std::vector<std::uint64_t> count_of_kind(engine::input_kinds.size());
  bool inputs_are_readable = listing.is_readable();
  reader.rewind();
  summary.setup_size = reader.offset();
  std::uint64_t offset = reader.offset();
  while (true) {
    const replay::TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const std::uint64_t item_size = reader.offset() > offset ? reader.offset() - offset : 0;
    offset = reader.offset();
    if (progress) progress(offset, trace.size());
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) {
      summary.tick_size += item_size;
      summary.time_s += tick->dt;
      summary.last_root_hash = tick->root_hash;
      ++summary.tick_count;
      if (!tick->inputs.empty()) ++summary.input_tick_count;
      summary.input_size += tick->inputs.size();
      inputs_are_readable = inputs_are_readable && listing.count(tick->inputs, count_of_kind);
    } else if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
      summary.checkpoint_size += item_size;
      if (summary.tick_count == 0) summary.last_root_hash = checkpoint->root_hash;
      summary.checkpoints.push_back({checkpoint->tick, checkpoint->root_hash, checkpoint->image.size(), item_size});
      if (checkpoint->save) summary.checkpoints.back().save_size = checkpoint->save->size();
    }
  }
  summary.rest_size = trace.size() > offset ? trace.size() - offset : 0;
  if (inputs_are_readable) summary.inputs = std::move(count_of_kind);
  summary.tail = reader.tail();
  verifier::TraceEnd end{summary.tail, ""};
  set_salvaged(end, reader.salvaged_from());
  summary.salvaged_from = end.salvaged_from;
  return summary;
}

}  // namespace ticktrue::tool
