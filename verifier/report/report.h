// Report: what verify found in one trace, and how it is printed as text and as JSON.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/state/non_finite.h"
#include "base/state/state_view.h"
#include "replay/format/trace.h"
#include "verifier/report/exit_codes.h"

namespace ticktrue::verifier {

enum class Verdict : std::uint8_t {
  match,
  diverged,
  state_incomplete,
  not_reproducible,
  damaged,
  incomplete,
  not_comparable,
  error
};

struct VerdictInfo {
  Verdict verdict;
  std::string_view name;  // spelling in reports and JSON
  int exit_code;
  std::string_view summary;
};
inline constexpr std::array<VerdictInfo, 8> verdicts{{
    {Verdict::match, "match", exit_ok, "every tick compared is the same, bit for bit"},
    {Verdict::diverged, "diverged", exit_finding, "this build gives other bits than were recorded"},
    {Verdict::state_incomplete, "state_incomplete", exit_finding,
     "the run from the start matches, a run from a checkpoint does not"},
    {Verdict::not_reproducible, "not_reproducible", exit_not_reproducible, "two runs of this build differ"},
    {Verdict::damaged, "damaged", exit_damaged, "bytes are not what was written; what is proven is said"},
    {Verdict::incomplete, "incomplete", exit_incomplete, "the trace ends early, or nothing could be compared"},
    {Verdict::not_comparable, "not_comparable", exit_not_comparable, "recorded with something this build is not"},
    {Verdict::error, "error", exit_usage, "the file could not be read at all"},
}};

const VerdictInfo& verdict_info(Verdict verdict);

/// What it means for the verdict that a trace could not be opened. Only the operating system's refusal is an error of
/// the call: a file that opens never gives Verdict::error.
Verdict verdict_of_open_error(ErrorCode code);

/// The exit code for `git bisect run`: 125 (skip this commit) where the trace could not be judged.
int git_bisect_exit_code(int exit_code);

/// One lane that differs.
struct LaneReport {
  std::string table;
  std::string column;
  std::uint64_t row = 0;            // index in the recorded state, or in the one here where that has no such row
  std::optional<std::uint64_t> id;  // of the row, where its table has ids
  std::string name;                 // of the row, where it has one
  std::uint32_t lane = 0;
  std::uint32_t lane_count = 1;
  ScalarType type = ScalarType::u32;
  std::optional<std::uint64_t> expected;  // bits; absent: the recorded state has no such row
  std::optional<std::uint64_t> got;       // bits; absent: the state here has no such row
  std::string place =
      {};  // of an element of a list: "units[3].inventory[2]", in the state that has the row; else empty
};

/// A text or a string of bytes that differs: its pieces put together.
struct ContentReport {
  std::string place;                // "units[3].inventory[2].label"
  std::string table;                // of the pieces
  std::uint64_t row = 0;            // of the table at the begin of `place`
  std::optional<std::uint64_t> id;  // of that row, where its table has ids
  std::string name;                 // of that row, where it has one
  bool is_text = false;
  std::optional<std::string> expected;  // the bytes around the first that differs; absent: no such row
  std::optional<std::string> got;
  std::uint64_t first = 0;          // place of the first of these bytes in the whole
  std::uint64_t expected_size = 0;  // bytes of the whole
  std::uint64_t got_size = 0;
  std::uint64_t offset = 0;                // of the first byte that differs
  std::optional<std::uint64_t> character;  // the same in characters; absent: the text is no UTF-8
};

struct TableDifference {
  std::string table;
  std::vector<std::string> columns;  // that differ, in schema order
  bool is_content = false;           // pieces of texts or of strings of bytes: the columns say nothing to people
};

/// A row that can have diverged, according to the cells.
struct Candidate {
  std::string table;
  std::uint64_t row = 0;
  std::optional<std::uint64_t> id;
  std::string name;
  std::string place = {};  // of a row of a child table: "units[3].name"
};

/// A table of which the two states have another number of rows.
struct RowCountDifference {
  std::string table;
  std::uint64_t expected = 0;
  std::uint64_t got = 0;
};

/// How far a divergence has spread by the end of a later tick.
struct Spread {
  std::uint64_t tick = 0;
  std::uint64_t row_count = 0;  // owners (bodies) that differ: counted in stored states, else estimated from cells
  std::uint64_t of = 0;         // owners there are
  bool estimated = false;
};

/// Stages that a divergence can name in addition to those of the simulation.
inline constexpr std::string_view stage_setup = "setup";  // the state made from the setup, before tick 0
inline constexpr std::string_view stage_load = "load";    // the state after loading a checkpoint, before the tick

/// The first difference between recorded and re-simulated state.
struct Divergence {
  std::uint64_t tick = 0;  // the tick at whose end the states differ; for `setup` and `load`: the tick before which
  double time_s = 0;       // simulated time when that tick began
  std::optional<std::string> stage;     // first stage whose output differs; absent: not known, or after the last stage
  std::string stage_note;               // what is known of the stage, for people
  std::vector<TableDifference> tables;  // empty: the trace stores only the hash of this tick
  std::vector<LaneReport> rows;         // the first lanes that differ, in table, row, column, lane order
  std::uint64_t lane_count = 0;         // all lanes that differ, but those of contents; rows may list fewer
  std::vector<ContentReport> contents;  // the first texts and strings of bytes that differ
  std::uint64_t content_count = 0;      // all of them
  bool from_cells = false;              // the trace has cells of this tick: columns are exact, rows are candidates
  std::vector<RowCountDifference> row_counts;
  std::vector<Candidate> candidates;    // the first of them
  std::uint64_t candidate_count = 0;    // all rows that can have differed
  std::uint64_t owner_count = 0;        // among so many
  bool healed = false;                  // some stand there by three of their four cells
  std::uint32_t unexplained_cells = 0;  // differing cells of no row known here: of one only the other state has
  std::vector<Spread> spread;           // over the ticks behind
  std::uint64_t expected_root = 0;
  std::uint64_t got_root = 0;
  std::string inputs;  // of the tick, JSON Lines

  /// Whether it lists what differs, and not only where.
  bool has_values() const { return !rows.empty() || !contents.empty(); }
};

/// Ticks of which each stored part was compared.
struct ComparedParts {
  std::uint64_t ticks = 0;  // their root hash
  std::uint64_t stage_hashes = 0;
  std::uint64_t images = 0;
  std::uint64_t cells = 0;
  std::uint64_t marks = 0;

  ComparedParts& operator+=(const ComparedParts& more) {
    ticks += more.ticks;
    stage_hashes += more.stage_hashes;
    images += more.images;
    cells += more.cells;
    marks += more.marks;
    return *this;
  }
};

/// Marks of one name, of which there are more or fewer, or which have other values.
struct NameDifference {
  std::string name;
  std::uint64_t expected = 0;  // times in the tick; 0: never
  std::uint64_t got = 0;
};

/// The first tick whose marks are not as recorded.
struct MarksDifference {
  std::uint64_t tick = 0;
  std::vector<NameDifference> names;  // the first of them; none: only the order differs
  std::uint64_t name_count = 0;       // all names that differ
};

/// How the trace itself ends.
struct TraceEnd {
  replay::TraceTail tail;
  std::string pending_inputs;  // JSON Lines
};

/// Another build that was asked about the same trace, and what it said.
struct OtherBuild {
  std::string binary;
  std::string verdict;  // its name; empty: none came
  std::string reason;
  std::uint64_t ticks_compared = 0;
  std::optional<std::uint64_t> diverged_at;  // tick
  replay::BuildFacts facts;
  bool is_expected = false;  // the divergence of the report is between it ("expected") and this build ("got")
};

struct Report {
  std::string file;
  std::string title;  // of the scene
  std::string simulation;
  std::string mode;
  Verdict verdict = Verdict::incomplete;
  std::string reason;  // one line: why it is not a match; empty where the divergence says it all
  std::string hint;    // the next step; may be empty
  std::optional<std::uint64_t> ticks_recorded;  // absent: not even the setup could be read
  std::uint64_t ticks_compared = 0;
  std::uint64_t first_tick = 0;  // compared
  double time_s = 0;             // simulated time at the end of the last tick compared
  std::uint64_t root_hash = 0;   // of the last state compared
  std::uint64_t checkpoints_compared = 0;
  ComparedParts compared;      // of these ticks
  bool state_changed = false;  // some state outside the table `world`
  std::uint64_t segments = 1;  // walked independently, between checkpoints
  double wall_s = 0;           // how long it took; 0: not measured
  std::optional<Divergence> divergence;
  std::optional<MarksDifference> marks;     // the verdict does not depend on it
  std::optional<std::uint64_t> checkpoint;  // state_incomplete: tick of the one from which the run differs
  std::optional<NonFinite> non_finite;      // where a value here is not finite, as recorded or not
  std::optional<TraceEnd> end;              // absent: the trace was not read to its end
  std::vector<std::string> warnings;
  std::vector<std::string> notes;
  replay::BuildFacts recorded_build;
  replay::BuildFacts here_build;  // of the program that verifies itself; empty: this tool
  std::optional<OtherBuild> against;
  std::vector<std::string> again;  // commands for further examination

  int exit_code(bool allow_truncated = false) const;
};

std::string report_text(const Report& report);
/// A file name as a word of a shell command.
std::string shell_word(const std::string& text);

/// One report: the object of docs; several: one object with counts and `rows`.
std::string report_json(std::span<const Report> reports, bool allow_truncated);

/// The indented lines of a divergence. The two sides are called as given.
std::string divergence_text(const Divergence& divergence, const char* expected_name = "expected",
                            const char* got_name = "got");
/// "rand 12 times, recorded 5; sin 3 times with other values": the first few names.
std::string marks_text(const MarksDifference& difference, const char* expected_name = "recorded");
/// JSON Lines as lines.
std::vector<std::string> split_lines(const std::string& text);

/// One line for the build facts of a trace, without those of the program.
std::string facts_line(const replay::BuildFacts& facts);

}  // namespace ticktrue::verifier
