// Returns the inputs of a session tick by tick, as a trace would.
// SPDX-License-Identifier: MIT
#include "tool/session/scene_source.h"

#include "tool/session/session.h"

namespace ticktrue::tool {

SceneSource::SceneSource(const engine::Engine& engine, replay::InputSource& inputs,
                         std::optional<std::uint64_t> tick_count)
    : setup_(make_trace_setup(engine, {})), inputs_(inputs), tick_count_(tick_count) {}

const replay::TraceReader::Item& SceneSource::next() {
  item_ = std::monostate{};
  if (at_end_ || (tick_count_ && tail_.ticks_intact >= *tick_count_)) return item_;
  const auto input = inputs_.next(tail_.ticks_intact);
  at_end_ = !input || !*input;
  if (!input) error_ = input.error();
  if (at_end_) return item_;
  replay::TickRecord record;
  record.tick = tail_.ticks_intact++;
  record.dt = (*input)->dt;
  record.inputs = (*input)->inputs;
  item_ = std::move(record);
  return item_;
}

}  // namespace ticktrue::tool
