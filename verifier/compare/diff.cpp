// Compares two traces: setup, inputs, states.
// SPDX-License-Identifier: MIT
#include "verifier/compare/diff.h"

#include <algorithm>
#include <array>

#include "base/count_text.h"
#include "base/hash.h"
#include "replay/format/shown_image.h"
#include "verifier/compare/trace_side.h"
#include "verifier/locate/compare_marks.h"
#include "verifier/locate/compare_tick.h"
#include "verifier/locate/locate.h"
#include "verifier/locate/locate_cells.h"
#include "verifier/peers/bundle.h"

namespace ticktrue::verifier {
namespace {

using replay::TickRecord;
using replay::TraceCondition;
using replay::TraceSetup;

/// ", at units row 2: a glow 0.5, b glow 1"; empty: the images show no difference.
std::string shown_difference(const StateSchema& whole, ByteView a, ByteView b) {
  const auto tables_a = replay::decode_shown(whole, a), tables_b = replay::decode_shown(whole, b);
  if (!tables_a || !tables_b) return "";
  for (std::size_t t = 0; t < std::min(tables_a->size(), tables_b->size()); ++t) {
    const ShownRows& rows_a = (*tables_a)[t];
    const ShownRows& rows_b = (*tables_b)[t];
    if (rows_a.table != rows_b.table) return "";
    const TableSchema& table = whole.tables[rows_a.table];
    for (std::size_t row = 0; row < std::min(rows_a.rows.row_count, rows_b.rows.row_count); ++row) {
      const std::string text_a = replay::shown_row_text(table, rows_a, row);
      const std::string text_b = replay::shown_row_text(table, rows_b, row);
      if (text_a != text_b)
        return ", at " + table.name + " row " + std::to_string(row) + " (a " + text_a + "; b " + text_b + ")";
    }
  }
  return "";
}

constexpr std::uint64_t spread_ticks = 64;
constexpr std::size_t differing_ranges_max = 1'000;  // after this number, the last range is extended

/// Commands that show the values of a difference of two traces, one for each recording build.
std::string more_detail_commands(const std::string& a, const std::string& b, std::uint64_t tick,
                                 const std::string& tool) {
  const std::string number = std::to_string(tick);
  if (tool.empty())
    return "record both again with detail full:" + number + ".." + number +
           ", each with the program that recorded it; then ticktrue diff a.ttr b.ttr";
  const auto record = [&](const std::string& file, const char* out) {
    return tool + " record " + shell_word(file) + " --ticks " + std::to_string(tick + 1) + " --detail full:" + number +
           ".." + number + " -o " + out;
  };
  return record(a, "a.ttr") + " and " + record(b, "b.ttr") +
         ", each with the build that recorded it; then ticktrue diff a.ttr b.ttr";
}

class Differ {
 public:
  Differ(replay::TraceReader& a, replay::TraceReader& b, const DiffOptions& options)
      : setup_a_(a.setup()), setup_b_(b.setup()), a_(a), b_(b), options_(options), comparer_(setup_a_.schema) {
    report_.simulation = setup_a_.simulation;
    report_.a.file = a.name();
    report_.b.file = b.name();
    report_.a.build = a.facts();
    report_.b.build = b.facts();
    if (options.simulation != nullptr && options.simulation->name == setup_a_.simulation)
      if (Result<std::unique_ptr<Simulation>> made = options.simulation->make(setup_a_.setup))
        simulation_ = std::move(*made);
  }

  DiffReport run() {
    comparable_ = compare_setups(setup_a_, setup_b_, report_.setup) == 0;
    if (options_.setup_keys && setup_a_.setup != setup_b_.setup) add_setup_keys();
    walk();
    finish();
    return std::move(report_);
  }

 private:
  std::string inputs_text(std::uint64_t tick, ByteView inputs) const {
    return simulation_ ? simulation_->inputs_text(tick, inputs) : "";
  }

  void add_setup_keys() {
    SetupKeys keys = options_.setup_keys(setup_a_, setup_b_);
    const std::uint64_t more = keys.count - keys.first.size();
    for (SetupDifference& key : keys.first) report_.setup.push_back(std::move(key));
    if (more > 0) report_.notes.push_back("the setups differ in " + count_text(more, "more key"));
  }

  void walk() {
    const TickRecord* a = a_.advance();
    const TickRecord* b = b_.advance();
    // One trace may begin later than the other: earlier ticks are in one trace only.
    const std::uint64_t first = std::max(a_.first_tick(), b_.first_tick());
    double time_s = a_.time_s();
    while (a != nullptr && a->tick < first) {
      time_s += a->dt;
      a = a_.advance();
    }
    while (b != nullptr && b->tick < first) b = b_.advance();
    std::uint64_t tick = first_ = first;
    note_begins();
    if (comparable_) compare_checkpoints(first, time_s);
    while (a != nullptr && b != nullptr) {
      compare_inputs(tick, *a, *b);
      compare_marks(tick, *a, *b);
      if (a->shown && b->shown) compare_shown("after tick " + std::to_string(tick), *a->shown, *b->shown);
      // Hashes of different schemas cannot be compared.
      const bool found = comparable_ && !report_.divergence && differ(*a, *b);
      if (found) {
        Divergence divergence;
        divergence.tick = tick;
        divergence.time_s = time_s;
        divergence.inputs = inputs_text(tick, a->inputs);
        report_.divergence = std::move(divergence);
      } else if (report_.divergence && comparable_) {
        follow_spread(*a, *b);
      }
      if (found || (comparable_ && a->root_hash != b->root_hash)) add_differing(tick);
      time_s += a->dt;
      ++tick;
      if (comparable_) ++report_.ticks_compared;
      if (options_.progress) options_.progress(tick);
      a = a_.advance();
      b = b_.advance();
      if (found)
        locate(tick);
      else if (comparable_ && !report_.divergence)
        compare_checkpoints(tick, time_s);
    }
    while (a != nullptr) a = a_.advance();
    while (b != nullptr) b = b_.advance();
  }

  void note_begins() {
    if (a_.first_tick() == b_.first_tick()) return;
    report_.notes.push_back("a begins at tick " + std::to_string(a_.first_tick()) + ", b at tick " +
                            std::to_string(b_.first_tick()) + ": compared from tick " + std::to_string(first_) + " on");
  }

  /// Reports the first difference of shown values. It does not affect the result.
  void compare_shown(const std::string& when, ByteView a, ByteView b) {
    if (told_shown_ || std::equal(a.begin(), a.end(), b.begin(), b.end())) return;
    told_shown_ = true;
    std::string text = "shown values differ first " + when;
    if (setup_a_.whole_schema && setup_a_.whole_schema == setup_b_.whole_schema)
      text += shown_difference(*setup_a_.whole_schema, a, b);
    report_.notes.push_back(text + ": no verdict depends on them");
  }

  /// Reports the first difference of marks. It does not affect the result.
  void compare_marks(std::uint64_t tick, const TickRecord& a, const TickRecord& b) {
    const bool have_marks = setup_a_.has(replay::Feature::marks) && setup_b_.has(replay::Feature::marks);
    if (told_marks_ || !have_marks || !a.has_bound || !b.has_bound) return;
    const auto difference = verifier::compare_marks(tick, a.marks ? &*a.marks : nullptr, b.marks ? &*b.marks : nullptr);
    if (!difference) return;
    told_marks_ = true;
    report_.notes.push_back("marks differ first in tick " + std::to_string(tick) + " (b " +
                            marks_text(*difference, "a") + "): no verdict depends on them");
  }

  void add_differing(std::uint64_t tick) {
    std::vector<TickRange>& ranges = report_.differing;
    if (!ranges.empty() && (ranges.back().last + 1 >= tick || ranges.size() == differing_ranges_max))
      ranges.back().last = tick;
    else
      ranges.push_back({tick, tick});
  }

  void compare_inputs(std::uint64_t tick, const TickRecord& a, const TickRecord& b) {
    if (report_.inputs) return;
    if (bits_of(a.dt) == bits_of(b.dt) &&
        std::equal(a.inputs.begin(), a.inputs.end(), b.inputs.begin(), b.inputs.end()))
      return;
    report_.inputs = InputDifference{tick, a.dt, b.dt, inputs_text(tick, a.inputs), inputs_text(tick, b.inputs)};
  }

  /// Hashes after the stages are compared if both traces have the same stages.
  TickSide stored_side(const TickRecord& record) const {
    TickSide side = side_of(record);
    if (setup_a_.stages != setup_b_.stages) side.stage_hashes = {};
    return side;
  }

  bool differ(const TickRecord& a, const TickRecord& b) {
    count_parts(a, stored_[0]);
    count_parts(b, stored_[1]);
    const TickSide sides[] = {stored_side(a), stored_side(b)};
    const auto difference = comparer_.compare(sides);
    root_ = a.root_hash;
    if (!difference) return false;
    part_ = difference->part;
    differing_[0] = copy_of(a);
    differing_[1] = copy_of(b);
    a_.freeze_last();
    b_.freeze_last();
    return true;
  }

  /// Compares the checkpoints after this number of ticks, with each other and with the tick before.
  void compare_checkpoints(std::uint64_t ticks_done, double time_s) {
    const StoredCheckpoint* a = a_.checkpoint_at(ticks_done);
    const StoredCheckpoint* b = b_.checkpoint_at(ticks_done);
    if (a == nullptr && b == nullptr) return;
    if (a != nullptr && b != nullptr) ++report_.checkpoints_compared;
    if (a != nullptr && b != nullptr && a->shown && b->shown)
      compare_shown("before tick " + std::to_string(ticks_done), *a->shown, *b->shown);
    const bool is_start = ticks_done == first_;
    std::vector<TickSide> sides;
    for (const StoredCheckpoint* checkpoint : {a, b})
      if (checkpoint != nullptr) sides.push_back(side_of(*checkpoint));
    const bool same = !TickComparer(setup_a_.schema).compare(sides);
    const bool of_its_tick = is_start || ((a == nullptr || holds(*a, root_)) && (b == nullptr || holds(*b, root_)));
    if (same && of_its_tick) return;
    Divergence divergence;
    divergence.tick = ticks_done;
    divergence.time_s = time_s;
    const TickSide tick_before{root_};
    describe(a != nullptr ? side_of(*a) : tick_before, b != nullptr ? side_of(*b) : tick_before, plain_context(),
             divergence);
    divergence.stage = std::string(is_start ? stage_setup : std::string_view("checkpoint"));
    divergence.stage_note = is_start ? "they begin with different states"
                            : same   ? "the hash of the tick before is not that of the checkpoint"
                                     : "the hashes of the tick before agree, the checkpoints do not";
    report_.divergence = std::move(divergence);
    if (!is_start) add_differing(ticks_done - 1);
  }

  /// Whether the checkpoint stores a state with this hash.
  bool holds(const StoredCheckpoint& checkpoint, std::uint64_t root) const {
    const Result<ImageState> state = ImageState::of(setup_a_.schema, checkpoint.image);
    return checkpoint.root_hash == root && state && root_hash(state->view()) == root;
  }

  void describe(const TickSide& a, const TickSide& b, const DescribeContext& context, Divergence& divergence) {
    if (const Status described = describe_tick(context, a, b, divergence); !described)
      report_.notes.push_back("a stored state cannot be read: " + described.error().message);
  }

  /// Requires: both sides have passed the checkpoints with the states after `ticks_done` ticks, if there are any.
  /// Rows of cells are searched among the rows of the last earlier state that both store.
  void locate(std::uint64_t ticks_done) {
    Divergence& divergence = *report_.divergence;
    for (const auto& [side, stored] : {std::pair(&a_, &differing_[0]), std::pair(&b_, &differing_[1])})
      if (const StoredCheckpoint* checkpoint = side->checkpoint_at(ticks_done); checkpoint != nullptr && !stored->image)
        stored->image = checkpoint->image;
    DescribeContext context = plain_context();
    std::optional<ImageState> rows;
    const bool has_images = differing_[0].image && differing_[1].image;
    const bool has_cells = differing_[0].cells && differing_[1].cells;
    if (!has_images && has_cells && a_.last()) {
      if (Result<ImageState> state = ImageState::of(context.schema, a_.last()->image)) rows.emplace(std::move(*state));
      if (rows) context.rows = &rows->view();
      if (simulation_ && simulation_->load(a_.last()->image))
        context.row_name = [this](std::size_t table, std::size_t row) { return simulation_->row_name(table, row); };
      report_.notes.push_back("rows are those of the state stored before tick " + std::to_string(a_.last()->tick) +
                              ": later ones cannot be named");
    }
    TickSide a = side_of(differing_[0]);
    TickSide b = side_of(differing_[1]);
    if (setup_a_.stages != setup_b_.stages) a.stage_hashes = b.stage_hashes = {};
    describe(a, b, context, divergence);
    if (const std::string contradiction = contradiction_text(divergence.tick, part_); !contradiction.empty())
      report_.notes.push_back(contradiction);
    if (!has_images && has_cells && differing_[0].cells->partition_cells != differing_[1].cells->partition_cells)
      report_.notes.push_back("rows cannot be named: the traces have another number of cells for this tick");
    differing_[0] = differing_[1] = {};
  }

  DescribeContext plain_context() const {
    DescribeContext context{setup_a_.schema, setup_a_.stages, {}, options_.row_count_max};
    context.no_stages = "not known: not both store a hash after each stage of this tick";
    return context;
  }

  /// Counts differing rows 1, 2, 4, 8, ... ticks after the divergence.
  void follow_spread(const TickRecord& a, const TickRecord& b) {
    Divergence& divergence = *report_.divergence;
    const std::uint64_t behind = a.tick - divergence.tick;
    if (behind == 0 || (behind & (behind - 1)) != 0 || behind > spread_ticks) return;
    if (a.cells != nullptr && b.cells != nullptr) {
      if (a.cells->partition_cells == b.cells->partition_cells)
        divergence.spread.push_back(spread_of_cells(setup_a_.schema, *a.cells, *b.cells, a.tick));
    } else if (a.image && b.image) {
      divergence.spread.push_back(spread_of_tables(setup_a_.schema, a.image->tables, b.image->tables, a.tick));
    }
  }

  /// Notes data that only one of the two traces stores: it is not compared.
  void note_not_compared() {
    const ComparedParts& done = report_.compared;
    const auto note = [&](TickPart part, std::uint64_t a, std::uint64_t b, std::uint64_t compared) {
      if (std::max(a, b) <= compared) return;
      report_.notes.push_back(std::string(name_of(part)) + ": a stores them for " + std::to_string(a) +
                              " ticks, b for " + std::to_string(b) + "; compared for " + std::to_string(compared));
    };
    note(TickPart::stage_hashes, stored_[0].stage_hashes, stored_[1].stage_hashes, done.stage_hashes);
    note(TickPart::image, stored_[0].images, stored_[1].images, done.images);
    note(TickPart::cells, stored_[0].cells, stored_[1].cells, done.cells);
  }

  void finish() {
    report_.compared = comparer_.take_compared();
    if (comparable_ && !report_.divergence) note_not_compared();
    for (const auto& [side, out] : {std::pair<TraceSide*, DiffSide*>{&a_, &report_.a}, {&b_, &report_.b}}) {
      out->ticks = side->ticks();
      out->end.tail = side->tail();
      const replay::TraceTail& tail = out->end.tail;
      if (tail.has_pending_inputs) out->end.pending_inputs = inputs_text(tail.ticks_intact, tail.pending_inputs);
      if (!tail.peers.empty())
        report_.notes.push_back((side == &a_ ? "a" : "b") +
                                (" is a bundle of several players: " + players_text(tail.peers)));
    }
    const auto either = [&](TraceCondition condition) {
      return a_.tail().condition == condition || b_.tail().condition == condition;
    };
    const bool whole = !either(TraceCondition::damaged) && !either(TraceCondition::truncated);
    if (!comparable_) {
      report_.verdict = DiffVerdict::not_comparable;
      report_.reason = report_.setup.front().what + ": " + report_.setup.front().a + " and " + report_.setup.front().b;
    } else if (report_.divergence || report_.inputs || !report_.setup.empty()) {
      report_.verdict = DiffVerdict::different;
      if (!report_.divergence && report_.ticks_compared > 0) report_.reason = "states equal; " + what_differs();
    } else if (whole && ended_early(shorter())) {
      report_.verdict = DiffVerdict::incomplete;
      report_.reason = "equal as far as both go; " + (&shorter() == &a_ ? report_.a.file : report_.b.file) +
                       " ended early, after " + std::to_string(shorter().ticks()) + " ticks";
    } else if (whole && a_.end_tick() != b_.end_tick()) {
      report_.verdict = DiffVerdict::different;
      report_.reason = "lengths: " + std::to_string(a_.ticks()) + " and " + std::to_string(b_.ticks()) +
                       " ticks; equal as far as both go";
    } else if (either(TraceCondition::damaged)) {
      report_.verdict = DiffVerdict::damaged;
      report_.reason = "equal as far as both are intact";
    } else if (either(TraceCondition::truncated)) {
      report_.verdict = DiffVerdict::incomplete;
      report_.reason = "equal as far as both go";
    } else if (report_.ticks_compared == 0) {
      report_.verdict = DiffVerdict::incomplete;
      report_.reason = "no tick was compared";
    }
    if (report_.divergence && !report_.divergence->has_values() && comparable_)
      report_.again.push_back(
          more_detail_commands(report_.a.file, report_.b.file, report_.divergence->tick, options_.tool));
  }

  const TraceSide& shorter() const { return b_.end_tick() < a_.end_tick() ? b_ : a_; }

  /// Whether the recorder of this side was stopped, or died, before the other one ended.
  bool ended_early(const TraceSide& side) const { return a_.end_tick() != b_.end_tick() && side.was_stopped(); }

  /// What differs if the states do not.
  std::string what_differs() const {
    if (report_.setup.empty()) return "the inputs differ";
    return report_.inputs ? "the setups and the inputs differ" : "the setups differ";
  }

  const TraceSetup& setup_a_;
  const TraceSetup& setup_b_;
  TraceSide a_;
  TraceSide b_;
  const DiffOptions& options_;
  std::unique_ptr<Simulation> simulation_;  // formats inputs and row names as text
  DiffReport report_;
  bool comparable_ = true;
  TickComparer comparer_;
  bool told_shown_ = false;
  bool told_marks_ = false;
  std::uint64_t first_ = 0;                   // the first tick of both
  std::uint64_t root_ = 0;                    // of the previous tick, on both sides
  TickPart part_ = TickPart::root_hash;       // the part that differs
  std::array<StoredTick, 2> differing_;       // the first tick that differs
  std::array<ComparedParts, 2> stored_ = {};  // up to this tick
};

}  // namespace

const DiffVerdictInfo& diff_verdict_info(DiffVerdict verdict) {
  const auto found = std::find_if(diff_verdicts.begin(), diff_verdicts.end(),
                                  [&](const DiffVerdictInfo& info) { return info.verdict == verdict; });
  TICKTRUE_ASSERT(found != diff_verdicts.end());
  return *found;
}

int DiffReport::exit_code(bool allow_truncated) const {
  if (allow_truncated && verdict == DiffVerdict::incomplete && ticks_compared > 0) return exit_ok;
  return diff_verdict_info(verdict).exit_code;
}

DiffReport diff(replay::TraceReader& a, replay::TraceReader& b, const DiffOptions& options) {
  return Differ(a, b, options).run();
}

}  // namespace ticktrue::verifier
