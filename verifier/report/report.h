// Report: the findings of verify in one trace, and its printing as text and as JSON.
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

/// The verdict on a trace that could not be opened. Only an error of the operating system gives Verdict::error. A file
/// that opens never does.
Verdict verdict_of_open_error(ErrorCode code);

/// The exit code for `git bisect run`: 125 (skip this commit) if the trace could not be judged.
int git_bisect_exit_code(int exit_code);

/// A differing lane.
struct LaneReport {
  std::string table;
  std::string column;
  std::uint64_t row = 0;            // index in the recorded state; if this state has no such row, in the state here
  std::optional<std::uint64_t> id;  // of the row, if its table has ids
  std::string name;                 // of the row, if it has one
  std::uint32_t lane = 0;
  std::uint32_t lane_count = 1;
  ScalarType type = ScalarType::u32;
  std::optional<std::uint64_t> expected;  // bits; absent: the recorded state has no such row
  std::optional<std::uint64_t> got;       // bits; absent: the state here has no such row
  std::string place = {};  // place of a list element: "units[3].inventory[2]", in the state with the row; else empty
};

/// A differing text or byte string, assembled from its pieces.
struct ContentReport {
  std::string place;                // "units[3].inventory[2].label"
  std::string table;                // of the pieces
  std::uint64_t row = 0;            // of the table at the top level of `place`
  std::optional<std::uint64_t> id;  // of this row, if its table has ids
  std::string name;                 // of this row, if it has one
  bool is_text = false;
  std::optional<std::string> expected;  // the bytes around the first differing byte; absent: no such row
  std::optional<std::string> got;
  std::uint64_t first = 0;          // offset of these bytes in the whole text
  std::uint64_t expected_size = 0;  // bytes of the whole text
  std::uint64_t got_size = 0;
  std::uint64_t offset = 0;                // of the first differing byte
  std::optional<std::uint64_t> character;  // offset in characters; absent: not valid UTF-8
};

struct TableDifference {
  std::string table;
  std::vector<std::string> columns;  // the differing columns, in schema order
  bool is_content = false;           // pieces of texts or byte strings: columns do not help people
};

/// A row that can have diverged, according to the cells.
struct Candidate {
  std::string table;
  std::uint64_t row = 0;
  std::optional<std::uint64_t> id;
  std::string name;
  std::string place = {};  // of a row of a child table: "units[3].name"
};

/// A table with different numbers of rows.
struct RowCountDifference {
  std::string table;
  std::uint64_t expected = 0;
  std::uint64_t got = 0;
};

/// How far a divergence has spread by the end of a later tick.
struct Spread {
  std::uint64_t tick = 0;
  std::uint64_t row_count = 0;  // differing owners (bodies): counted in stored states, else estimated from cells
  std::uint64_t of = 0;         // number of owners
  bool estimated = false;
};

/// Stages of a divergence in addition to the stages of the simulation.
inline constexpr std::string_view stage_setup = "setup";  // the state made from the setup, before tick 0
inline constexpr std::string_view stage_load = "load";    // the state after loading a checkpoint, before the tick

/// The first difference between recorded and re-simulated state.
struct Divergence {
  std::uint64_t tick = 0;               // the states differ after this tick; for `setup` and `load`: before this tick
  double time_s = 0;                    // simulated time when that tick began
  std::optional<std::string> stage;     // first stage with another output; absent: unknown, or after the last stage
  std::string stage_note;               // a remark on the stage, for people
  std::vector<TableDifference> tables;  // empty: the trace stores only a hash of this tick
  std::vector<LaneReport> rows;         // the first differing lanes, in table, row, column, lane order
  std::uint64_t lane_count = 0;         // all differing lanes outside contents; `rows` may list fewer
  std::vector<ContentReport> contents;  // the first differing texts and byte strings
  std::uint64_t content_count = 0;      // number of all of them
  bool from_cells = false;              // the trace has cells of this tick: columns are exact, rows are candidates
  std::vector<RowCountDifference> row_counts;
  std::vector<Candidate> candidates;    // the first candidates
  std::uint64_t candidate_count = 0;    // number of all rows that can have differed
  std::uint64_t owner_count = 0;        // number of owners
  bool healed = false;                  // some candidates were named by three of their four cells
  std::uint32_t unexplained_cells = 0;  // differing cells of no known row: the row is only in the other state
  std::vector<Spread> spread;           // over later ticks
  std::uint64_t expected_root = 0;
  std::uint64_t got_root = 0;
  std::string inputs;  // of the tick, JSON Lines

  /// Whether it lists values, and not only places.
  bool has_values() const { return !rows.empty() || !contents.empty(); }
};

/// For each stored part, the number of ticks in which it was compared.
struct ComparedParts {
  std::uint64_t ticks = 0;  // ticks with compared root hashes
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

/// The marks of one name that differ in number or values.
struct NameDifference {
  std::string name;
  std::uint64_t expected = 0;  // number in the tick; 0: none
  std::uint64_t got = 0;
};

/// The first tick whose marks differ from the recorded marks.
struct MarksDifference {
  std::uint64_t tick = 0;
  std::vector<NameDifference> names;  // the first names; empty: only the order differs
  std::uint64_t name_count = 0;       // number of all differing names
};

/// The end of the trace itself.
struct TraceEnd {
  replay::TraceTail tail;
  std::string pending_inputs;  // JSON Lines
  /// From this tick on, the intact ticks lie in a damaged chunk: the checks of their records prove them. Absent: none
  /// do.
  std::optional<std::uint64_t> salvaged_from = std::nullopt;
};
/// Sets `salvaged_from`, if the intact ticks go on behind this tick.
void set_salvaged(TraceEnd& end, std::optional<std::uint64_t> salvaged_from);

/// Another build that verified the same trace, and its result.
struct OtherBuild {
  std::string binary;
  std::string verdict;  // name of its verdict; empty: none
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
  std::string reason;  // one line: why it is not a match; empty: the divergence gives the reason
  std::string hint;    // the next step; may be empty
  std::optional<std::uint64_t> ticks_recorded;  // absent: the setup could not be read
  std::uint64_t ticks_compared = 0;
  std::uint64_t first_tick = 0;  // first tick compared
  double time_s = 0;             // simulated time at the end of the last tick compared
  std::uint64_t root_hash = 0;   // of the last state compared
  std::uint64_t checkpoints_compared = 0;
  ComparedParts compared;      // of these ticks
  bool state_changed = false;  // some state outside the table `world` changed
  std::uint64_t segments = 1;  // number of independent runs between checkpoints
  double wall_s = 0;           // wall time; 0: not measured
  std::optional<Divergence> divergence;
  std::optional<MarksDifference> marks;     // no effect on the verdict
  std::optional<std::uint64_t> checkpoint;  // state_incomplete: the run from this checkpoint differs
  std::optional<NonFinite> non_finite;      // the place of a non-finite value here, as recorded or not
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

/// One report: the object in the docs. Several reports: one object with counts and `rows`.
std::string report_json(std::span<const Report> reports, bool allow_truncated);

/// The indented lines of a divergence, with the given names of both sides.
std::string divergence_text(const Divergence& divergence, const char* expected_name = "expected",
                            const char* got_name = "got");
/// "rand 12 times, recorded 5; sin 3 times with other values": the first few names.
std::string marks_text(const MarksDifference& difference, const char* expected_name = "recorded");
/// Splits JSON Lines into lines.
std::vector<std::string> split_lines(const std::string& text);

/// One line for the build facts of a trace, without facts about the program.
std::string facts_line(const replay::BuildFacts& facts);

}  // namespace ticktrue::verifier
