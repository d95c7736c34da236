// Reads sessions.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/session_file.h"

#include <algorithm>

#include "engine/scene/scene_json.h"
#include "replay/trace_reader.h"
#include "tool/session/input_source.h"
#include "tool/session/playback.h"

namespace ticktrue::reduce {

using soak::SoakCase;

Result<SoakCase> read_session(const engine::Scene& scene, const std::string& inputs_path,
                              std::optional<std::uint64_t> tick_count) {
  SoakCase session{scene, {}, 0};
  std::optional<std::uint64_t> end;
  if (!inputs_path.empty()) {
    Result<tool::LineReader> lines = tool::LineReader::open(inputs_path);
    if (!lines) return lines.error();
    std::uint32_t sequence = 0;
    for (;;) {
      const auto line = lines->next({});
      if (!line) return line.error();
      if (!*line) break;
      if ((*line)->find_first_not_of(" \t\r") == std::string_view::npos) continue;
      Result<engine::Input> input = engine::parse_input(scene, **line, lines->place());
      if (!input) return input.error();
      input->sequence = sequence++;
      if (input->kind == engine::InputKind::end)
        end = input->tick;
      else
        session.inputs.push_back(*input);
    }
  }
  if (!tick_count && !end)
    return Error{ErrorCode::usage,
                 "--ticks: found neither --ticks nor an `end` input, expected one that ends the session", ""};
  session.tick_count = std::min(tick_count.value_or(UINT64_MAX), end.value_or(UINT64_MAX));
  return session;
}

Result<SoakCase> read_trace_session(const std::string& path, std::optional<std::uint64_t> tick_count) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(path);
  if (!reader) return reader.error();
  if (const Status whole = reader->check_from_start(); !whole) return whole.error();
  Result<engine::Scene> scene = tool::scene_of(reader->setup());
  if (!scene) return Error{scene.error().code, path + ": " + scene.error().message, scene.error().hint};
  SoakCase session{*std::move(scene), {}, 0};
  std::vector<engine::Input> of_tick;
  while (session.tick_count < tick_count.value_or(UINT64_MAX)) {
    const auto& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr) continue;
    if (session.tick_count == 0) session.scene.settings.dt = record->dt;
    if (record->dt != session.scene.settings.dt)
      return Error{ErrorCode::unsupported,
                   path + ": tick " + std::to_string(record->tick) + ": found another length than before, expected " +
                       "ticks of one length",
                   "--ticks ends the session before it"};
    const Status decoded = engine::decode_inputs(session.scene, record->inputs, of_tick);
    if (!decoded) return decoded.error();
    for (engine::Input& input : of_tick) {
      input.tick = record->tick;
      session.inputs.push_back(input);
    }
    session.tick_count = record->tick + 1;
  }
  return session;
}

}  // namespace ticktrue::reduce
