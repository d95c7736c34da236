// The first tick whose inputs differ between traces, and the differences of each trace.
// SPDX-License-Identifier: MIT
//
// An input is one event of the simulation, if the simulation can print its inputs as lines. Otherwise it is all bytes
// of the tick.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/state/simulation.h"
#include "replay/format/trace.h"
#include "verifier/compare/many/trace_groups.h"

namespace ticktrue::verifier {

/// How the inputs of one trace differ from those of the majority.
enum class InputChange : std::uint8_t { missing, extra, other, order, dt };
struct InputChangeInfo {
  InputChange change;
  std::string_view name;  // in JSON
  std::string_view text;  // for people
};
inline constexpr std::array<InputChangeInfo, 5> input_changes{{
    {InputChange::missing, "missing", "an input is missing"},
    {InputChange::extra, "extra", "there is an extra input"},
    {InputChange::other, "other", "an input has another payload"},
    {InputChange::order, "order", "the inputs stand in another order"},
    {InputChange::dt, "dt", "the tick has another length"},
}};
const InputChangeInfo& input_change_info(InputChange change);

/// Traces with the same inputs in the tick.
struct InputGroup {
  TraceGroup traces;
  double dt = 0;  // s
  Bytes bytes;
  std::string lines;  // JSON Lines; empty: the simulation cannot print the bytes
};

/// One trace compared with the majority.
struct OddInputs {
  std::size_t trace = 0;
  InputChange change = InputChange::other;
  std::vector<std::string> missing;     // inputs of the majority that the trace lacks
  std::vector<std::string> extra;       // inputs of the trace that the majority lacks
  std::optional<std::uint64_t> later;   // tick in which the trace has the missing input, and the majority lacks it
  std::optional<std::uint64_t> before;  // tick in which the majority has the extra input, after the trace
};

struct InputsFinding {
  std::uint64_t tick = 0;
  std::vector<InputGroup> groups;  // in the order of `who`
  TraceGroups who;
  std::vector<OddInputs> odd;  // empty: no majority
};

/// A trace with the present tick.
struct PresentTick {
  std::size_t trace = 0;
  const replay::TickRecord* record = nullptr;
};

/// Receives each tick of all traces with this tick. Stores the inputs of one tick.
class InputComparer {
 public:
  /// `simulation` prints inputs and outlives this object; may be null.
  InputComparer(const Simulation* simulation, std::size_t trace_count) : simulation_(simulation), from_(trace_count) {}

  /// Whether all traces have the same inputs and dt. Requires: ascending ticks, at least one trace.
  bool compare(std::uint64_t tick, std::span<const PresentTick> present);
  const std::optional<InputsFinding>& found() const { return found_; }
  /// The first tick in which a majority has other inputs than this trace.
  const std::optional<std::uint64_t>& from(std::size_t trace) const { return from_[trace]; }

  /// JSON Lines; empty: the simulation cannot print the bytes.
  std::string lines(std::uint64_t tick, ByteView bytes) const;

 private:
  std::vector<std::string> items(ByteView bytes) const;
  void describe(std::uint64_t tick, std::span<const PresentTick> present, const TraceGroups& who);
  void follow(std::uint64_t tick, std::span<const PresentTick> present, ByteView most);

  const Simulation* simulation_;
  std::optional<InputsFinding> found_;
  std::vector<std::optional<std::uint64_t>> from_;  // [trace]
};

/// Bytes in hexadecimal.
std::string input_hex(ByteView bytes);
/// At most 32 bytes in hexadecimal, and the number of bytes. "none": no bytes.
std::string input_bytes_text(ByteView bytes);

}  // namespace ticktrue::verifier
