// Sessions of format version 3 with states of many tables, and what a reader gives of them.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/random.h"
#include "base/state/cells.h"
#include "base/state/state_view.h"
#include "replay/format/chunk.h"
#include "replay/format/trace.h"
#include "replay/trace_reader.h"
#include "replay/trace_writer.h"
#include "tests/replay/toy_traces.h"

namespace ticktrue::test {

/// A state of tables without keys, whose rows a seed changes.
class RandomTables {
 public:
  RandomTables(std::size_t table_count, std::uint64_t seed);
  /// Other rows, more, or fewer of them in about `table_count` tables.
  void change(std::size_t table_count);
  const StateView& view() const { return view_; }
  const StateSchema& schema() const { return schema_; }

 private:
  void refresh();

  Random random_;
  StateSchema schema_;
  std::vector<Bytes> rows_;
  StateView view_;
};

/// What a session holds, and how it changes.
struct SessionPlan {
  std::size_t table_count = 6;
  std::size_t changed_tables = 2;  // of a tick, about
  std::uint64_t seed = 1;
  std::uint64_t bound_seed = 1;  // of shown images, saves and notes
  std::uint64_t tick_count = 20;
  std::uint64_t first_tick = 0;
  replay::Detail detail = replay::Detail::root;
  std::uint64_t full_first = 0;
  std::uint64_t full_last = 0;
  std::uint32_t checkpoint_interval = 0;
  std::uint32_t features = 0;
  std::uint32_t stage_interval = 0;
  bool has_shown = false;
  bool compress = false;
};
replay::TraceSetup setup_of(const SessionPlan& plan);
Bytes write_session(const SessionPlan& plan);

struct ThirdTick {
  ReadTick tick;
  std::optional<StateCells> cells;
  std::optional<Bytes> shown;
  std::vector<std::pair<std::uint8_t, Bytes>> bound;
};
struct ThirdCheckpoint {
  ReadCheckpoint checkpoint;
  std::optional<double> time_s;
  std::optional<Bytes> shown;
  std::optional<Bytes> save;
};
struct ThirdTrace {
  std::vector<ThirdTick> ticks;
  std::vector<ThirdCheckpoint> checkpoints;
  replay::TraceTail tail;
};
ThirdTrace read_third(replay::TraceReader& reader);
ThirdTrace read_third(ByteView bytes);

/// Whether all that is in `part` is in `whole` at its place. Content outside of the chain may be missing.
void require_true_part(const ThirdTrace& part, const ThirdTrace& whole);
/// The same, and nothing is missing.
void require_same(const ThirdTrace& part, const ThirdTrace& whole);

/// The trace that recovery makes of these bytes.
Bytes recovered(ByteView bytes);

/// The chain value behind the end chunk of a complete trace.
std::uint64_t content_id(ByteView trace);

}  // namespace ticktrue::test
