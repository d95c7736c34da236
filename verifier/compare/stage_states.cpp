// Runs one tick with an observer. Writes and reads its states as lines that another build can read.
// SPDX-License-Identifier: MIT
#include "verifier/compare/stage_states.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "base/hash.h"
#include "base/limits.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {
namespace {

constexpr const char* stages_schema = "ticktrue.stages/1";

class StateCollector : public StageObserver {
 public:
  StateCollector(std::span<const std::string> names, std::vector<StageState>& states)
      : names_(names), states_(states) {}
  void after_stage(std::size_t stage, const StateView& state) override {
    StageState kept{stage < names_.size() ? names_[stage] : "?", root_hash(state), {}};
    encode_image(state, kept.image);
    states_.push_back(std::move(kept));
  }

 private:
  std::span<const std::string> names_;
  std::vector<StageState>& states_;
};

std::string hex_of(ByteView bytes) {
  constexpr char digits[] = "0123456789abcdef";
  std::string text(2 * bytes.size(), '0');
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    text[2 * i] = digits[bytes[i] >> 4];
    text[2 * i + 1] = digits[bytes[i] & 15];
  }
  return text;
}

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

bool bytes_of(const std::string& text, Bytes& bytes) {
  if (text.size() % 2 != 0 || text.size() / 2 > limits::state_image_size_max) return false;
  bytes.resize(text.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const int high = digit_of(text[2 * i]);
    const int low = digit_of(text[2 * i + 1]);
    if (high < 0 || low < 0) return false;
    bytes[i] = static_cast<std::uint8_t>(16 * high + low);
  }
  return true;
}

/// Loads the last checkpoint at or before the tick. Moves the source to the record after it.
Result<std::uint64_t> go_to_checkpoint(TraceSource& source, Simulation& simulation, std::uint64_t tick) {
  if (tick > 0 && source.seek(tick)) {
    const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&source.next());
    if (checkpoint != nullptr) {
      const Status loaded = simulation.load(checkpoint->image);
      if (loaded) return checkpoint->tick;
      if (loaded.error().code != ErrorCode::unsupported)
        return Error{
            ErrorCode::incompatible,
            "checkpoint at tick " + std::to_string(checkpoint->tick) + " is refused here: " + loaded.error().message,
            ""};
    }
  }
  source.rewind();
  return std::uint64_t{0};
}

}  // namespace

Result<StageStates> stage_states(TraceSource& source, const SimulationInfo& info, std::uint64_t tick) {
  auto made = info.make(source.setup().setup);
  if (!made) return made.error();
  Simulation& simulation = **made;
  const auto start = go_to_checkpoint(source, simulation, tick);
  if (!start) return start.error();
  StageStates found;
  found.tick = tick;
  found.start_tick = *start;
  for (;;) {
    const auto& item = source.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr) continue;
    const TickInput input{record->dt, record->inputs};
    if (const Status accepted = simulation.accept(input); !accepted)
      return Error{
          ErrorCode::incompatible,
          "tick " + std::to_string(record->tick) + ": recorded inputs are refused here: " + accepted.error().message,
          ""};
    if (record->tick < tick) {
      if (const Status did = simulation.step(input, nullptr); !did) return did.error();
      found.as_recorded = root_hash(simulation.state()) == record->root_hash;
      continue;
    }
    found.inputs = simulation.inputs_text(tick, record->inputs);
    StageState before{"", root_hash(simulation.state()), {}};
    encode_image(simulation.state(), before.image);
    found.states.push_back(std::move(before));
    StateCollector collector(simulation.stage_names(), found.states);
    if (const Status did = simulation.step(input, &collector); !did) return did.error();
    return found;
  }
  return Error{ErrorCode::usage, "tick " + std::to_string(tick) + ": not in the part of the trace that is intact", ""};
}

std::string stage_states_lines(const StageStates& states) {
  nlohmann::ordered_json head = {{"schema", stages_schema},
                                 {"tick", states.tick},
                                 {"start_tick", states.start_tick},
                                 {"as_recorded", states.as_recorded},
                                 {"inputs", split_lines(states.inputs)},
                                 {"states", states.states.size()}};
  std::string text = head.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  for (const StageState& state : states.states) {
    const nlohmann::ordered_json line = {
        {"stage", state.stage}, {"hash", hex64(state.root_hash)}, {"image", hex_of(state.image)}};
    text += line.dump() + "\n";
  }
  return text;
}

Result<StageStates> parse_stage_states(std::string_view lines) {
  const Error refused{ErrorCode::corrupt, std::string("found no report of schema ") + stages_schema, ""};
  const auto parse = [](std::string_view line) { return nlohmann::json::parse(line, nullptr, false); };
  StageStates states;
  bool has_head = false;
  std::uint64_t count = 0;
  try {
    while (!lines.empty()) {
      const std::size_t end = std::min(lines.find('\n'), lines.size());
      const auto json = parse(lines.substr(0, end));
      lines.remove_prefix(std::min(end + 1, lines.size()));
      if (!json.is_object()) return refused;
      if (!has_head) {
        if (json.at("schema") != stages_schema) return refused;
        states.tick = json.at("tick").get<std::uint64_t>();
        states.start_tick = json.at("start_tick").get<std::uint64_t>();
        states.as_recorded = json.at("as_recorded").get<bool>();
        count = json.at("states").get<std::uint64_t>();
        has_head = true;
        continue;
      }
      StageState state;
      state.stage = json.at("stage").get<std::string>();
      if (!bytes_of(json.at("image").get<std::string>(), state.image)) return refused;
      state.root_hash = std::stoull(json.at("hash").get<std::string>(), nullptr, 16);
      states.states.push_back(std::move(state));
    }
  } catch (const std::exception&) {
    return refused;
  }
  if (!has_head || states.states.empty() || states.states.size() != count) return refused;
  return states;
}

}  // namespace ticktrue::verifier
