// The contents of a trace (a replay file): setup, build facts, ticks, checkpoints, end. Format: docs/trace_format.md.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/state/cells.h"
#include "base/state/state_view.h"
#include "replay/format/marks.h"

namespace ticktrue::replay {

inline constexpr std::uint16_t format_version_first = 1;
inline constexpr std::uint16_t format_version_third = 3;  // adds bound content, lists of tables, traces that begin late
inline constexpr std::uint16_t format_version = format_version_third;  // the newest version that is read

/// How much a trace stores of each tick.
enum class Detail : std::uint8_t { root = 1, cells = 2, full = 3 };
struct DetailInfo {
  Detail detail;
  std::string_view name;
  std::uint16_t format_version;  // states the oldest possible version, so that older readers can read the other traces
  std::string_view summary;
};
inline constexpr std::array<DetailInfo, 3> details{{
    {Detail::root, "root", 1, "one 64-bit hash per tick"},
    {Detail::cells, "cells", 2, "also a hash per column, and cells that name the bodies which differ"},
    {Detail::full, "full", 1, "the whole state per tick and a hash after each stage"},
}};
const DetailInfo& detail_info(Detail detail);

/// Content that a trace of version 3 may have. A chunk or record of a feature that is off is refused.
enum class Feature : std::uint32_t { shown = 1, saves = 2, marks = 4, notes = 8, tail = 16, peers = 32 };
inline constexpr std::uint32_t feature_mask = 63;
inline constexpr std::uint32_t feature_count = 6;

/// Everything that is needed to create the simulation and to read its state images. The setup of a recording is equal
/// on every platform.
struct TraceSetup {
  std::string simulation;             // SimulationInfo::name
  std::uint32_t physics_version = 0;  // SimulationInfo::physics_version
  std::string title;                  // of the scene, for people
  double dt = 0;                      // s; a tick can change it
  Detail detail = Detail::root;
  std::uint64_t full_first = 0;  // with Detail::full: ticks full_first..full_last (inclusive) are stored in full
  std::uint64_t full_last = 0;
  std::uint32_t checkpoint_interval = 0;  // ticks between checkpoints; 0: only a checkpoint at tick 0
  std::uint32_t features = 0;             // bits of Feature
  std::uint32_t stage_interval = 0;       // > 0: ticks divisible by it also store the hash after each stage
  StateSchema schema;                     // the judged columns; states, hashes and cells have these columns
  /// The schema including shown columns, if there are any. `schema` is its judged part.
  std::optional<StateSchema> whole_schema = std::nullopt;
  std::vector<std::string> stages;  // Simulation::stage_names()
  Bytes setup;                      // the setup bytes of the simulation

  bool has(Feature feature) const { return (features & static_cast<std::uint32_t>(feature)) != 0; }
  bool is_full(std::uint64_t tick) const { return detail == Detail::full && full_first <= tick && tick <= full_last; }
  bool has_stages(std::uint64_t tick) const {
    return is_full(tick) || (stage_interval != 0 && tick % stage_interval == 0);
  }
};
/// The version of a trace with this setup: the oldest version that supports it.
std::uint16_t version_of(const TraceSetup& setup);

/// Whether a tick can have this length, s.
inline bool is_dt(double dt) {
  return std::isfinite(dt) && dt >= 0;
}

/// Facts about the recording build: name, value. They are outside the chain of checksums.
using BuildFacts = std::vector<std::pair<std::string, std::string>>;

/// A stored state: its tables, and which tables have stored rows. The other tables are equal to those of the state one
/// tick before. Views are valid until the reader advances.
struct StoredState {
  std::span<const ImageTable> tables;          // [table]
  std::span<const std::uint32_t> stored = {};  // ascending

  /// The state as one image.
  Bytes joined() const;
};

/// A record outside the chain: a name, marks, a note.
struct BoundRecord {
  std::uint8_t tag = 0;
  ByteView body;
};

/// One tick as recorded. Views are valid until the reader advances.
struct TickRecord {
  std::uint64_t tick = 0;  // 0-based: it takes the state after `tick` ticks to the next one
  double dt = 0;           // s
  ByteView inputs;
  std::uint64_t root_hash = 0;              // of the state after the tick
  std::vector<std::uint64_t> stage_hashes;  // root hash after each stage; empty unless stored
  std::optional<StoredState> image;         // state after the tick; absent unless stored in full
  const StateCells* cells = nullptr;        // of the state after the tick; null unless stored
  std::optional<ByteView> shown;            // shown image after the tick; absent unless stored
  std::vector<BoundRecord> bound;           // in file order
  bool has_bound = true;                    // false: the records outside the chain are damaged
  std::optional<TickMarks> marks;           // from these records; absent: the tick has none
  std::optional<MarkList> mark_list;        // from these records
  std::vector<Note> notes;                  // from these records
};

/// Full state with `tick` ticks done. The one at tick 0 is the initial state.
struct CheckpointRecord {
  std::uint64_t tick = 0;
  std::uint64_t root_hash = 0;
  ByteView image;                                // decompressed
  std::optional<double> time_s = std::nullopt;   // simulated time; traces of versions 1 and 2 lack it
  std::optional<ByteView> shown = std::nullopt;  // shown image; absent unless stored and intact
  std::optional<ByteView> save = std::nullopt;   // the save of the program; absent unless stored and intact
};

/// The inputs of a tick, as players compare them.
struct TickInputs {
  double dt = 0;  // s
  std::uint64_t size = 0;
  std::uint64_t hash = 0;
  Bytes begin;  // the first bytes, at most input_begin_max

  bool operator==(const TickInputs&) const = default;
};
inline constexpr std::size_t input_begin_max = 64;

/// The differing rows in one table of a player, compared with the recorder.
struct PeerTable {
  std::uint32_t table = 0;
  std::vector<std::uint32_t> removed;  // rows of the recorder that the player lacks or has with other values; ascending
  std::vector<std::uint32_t> rows;     // row numbers in the table of the player; ascending
  Bytes bytes;                         // of these rows, little-endian

  bool operator==(const PeerTable&) const = default;
};

struct PeerRoot {
  std::uint64_t tick = 0;
  std::uint64_t root = 0;

  bool operator==(const PeerRoot&) const = default;
};

/// What the recorder knows about another player at the first tick with different states.
struct PeerRecord {
  std::uint32_t player = 0;
  std::uint32_t recorder = 0;          // the player who recorded this trace
  std::uint64_t session_identity = 0;  // of this player
  BuildFacts facts;                    // empty: unknown
  std::uint64_t tick = 0;              // the first differing tick
  std::vector<PeerRoot> roots;         // ascending
  std::optional<TickInputs> inputs;    // of that tick
  bool has_state = false;              // `tables` describe the state after this tick
  bool is_cut = false;                 // more rows may differ than `tables` contain
  bool lost_state = false;             // the player no longer has this state
  Bytes cells;                         // cells of this state, as a list with base 0; empty: unknown
  std::vector<PeerTable> tables;

  bool operator==(const PeerRecord&) const = default;
  std::optional<std::uint64_t> root_at(std::uint64_t at) const;
};
inline constexpr std::uint32_t player_max = 254;

enum class EndReason : std::uint8_t { complete = 1, interrupted = 2, non_finite = 3, recovered = 4 };
struct EndReasonInfo {
  EndReason reason;
  std::string_view name;
  std::string_view summary;
};
inline constexpr std::array<EndReasonInfo, 4> end_reasons{{
    {EndReason::complete, "complete", "the recording ended as planned"},
    {EndReason::interrupted, "interrupted",
     "the recorder was asked to stop, its inputs failed, or the next tick could not be done"},
    {EndReason::non_finite, "non_finite", "the next tick gave a NaN or an infinity"},
    {EndReason::recovered, "recovered", "closed by `ticktrue recover`; what followed is lost"},
}};

/// The end record of a recorder.
struct EndRecord {
  EndReason reason = EndReason::complete;
  std::uint64_t tick_count = 0;
  std::string note;  // such as the place of a non-finite value; may be empty
};

/// How the readable part of a trace ends.
enum class TraceCondition : std::uint8_t {
  complete,   // the end record and everything before it are intact
  truncated,  // the file stops early; the part before the cut is intact
  damaged,    // bytes differ from the written bytes
};

/// A range of intact ticks after damage.
struct IntactRange {
  std::uint64_t first_tick = 0;
  std::uint64_t last_tick = 0;
  bool has_checkpoint = false;  // the range can be verified from one of its checkpoints
};

/// The end of a trace, known after the last readable record.
struct TraceTail {
  TraceCondition condition = TraceCondition::complete;
  std::uint64_t ticks_intact = 0;  // number of ticks that are readable from the start without a gap
  std::uint64_t offset = 0;        // bytes from the start of the file to the cut or the first damage
  std::string message;             // "offset 4096: chunk 3 checksum: found .., expected .."; empty if complete
  std::optional<EndRecord> end;
  bool has_pending_inputs = false;  // the file ends after the inputs of tick `ticks_intact`
  double pending_dt = 0;
  Bytes pending_inputs;
  std::vector<Note> pending_notes;        // of that tick
  std::vector<PeerRecord> peers;          // of a bundle: the intact records, ascending by player
  std::vector<IntactRange> intact_after;  // damaged: the intact ranges after the damage
};

}  // namespace ticktrue::replay
