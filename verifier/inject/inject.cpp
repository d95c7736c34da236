// Fault injection: plans flips, verifies the trace with each of them, and judges the reports.
// SPDX-License-Identifier: MIT
#include "verifier/inject/inject.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "base/parallel/jobs.h"
#include "base/random.h"
#include "base/state/cells.h"
#include "verifier/inject/flip.h"
#include "verifier/inject/simulation_pool.h"
#include "verifier/verify/verify.h"

namespace ticktrue::verifier {
namespace {

using replay::CheckpointRecord;
using replay::TickRecord;
using replay::TraceReader;

/// One tick of a trace, with the state before it as a checkpoint. This suffices for a flip in this tick.
class Excerpt : public TraceSource {
 public:
  Excerpt(const replay::TraceSetup& setup, const Bytes& state_before, const TickRecord& record)
      : setup_(setup), checkpoint_(CheckpointRecord{record.tick, 0, state_before}), tick_(record) {
    tail_.ticks_intact = record.tick + 1;
  }
  /// The recorded root hash of the state before the tick.
  void set_root(std::uint64_t root_hash) { std::get<CheckpointRecord>(checkpoint_).root_hash = root_hash; }

  const replay::TraceSetup& setup() const override { return setup_; }
  const TraceReader::Item& next() override {
    const TraceReader::Item* items[] = {&checkpoint_, &tick_, &end_};
    const TraceReader::Item& item = *items[position_];
    position_ = std::min<std::size_t>(position_ + 1, 2);
    return item;
  }
  bool seek(std::uint64_t tick) override {
    if (tick < std::get<CheckpointRecord>(checkpoint_).tick) return false;
    position_ = 0;
    return true;
  }
  void rewind() override { position_ = 0; }
  const replay::TraceTail& tail() const override { return tail_; }
  std::optional<std::uint64_t> tick_count_hint() const override { return tail_.ticks_intact; }

 private:
  const replay::TraceSetup& setup_;
  TraceReader::Item checkpoint_;
  TraceReader::Item tick_;
  TraceReader::Item end_;
  replay::TraceTail tail_;
  std::size_t position_ = 0;
};

constexpr std::size_t every_candidate = 1'000'000;

class Injector {
 public:
  Injector(TraceReader& reader, const InjectOptions& options)
      : reader_(reader), setup_(reader.setup()), options_(options) {}

  Result<InjectReport> run() {
    report_.file = reader_.name();
    report_.seed = options_.seed;
    report_.is_inside = options_.after_substep.has_value();
    for (const replay::DetailInfo& info : replay::details)
      if (info.detail == setup_.detail) report_.detail = info.name;
    if (const Status named = check_names(); !named) return named.error();
    if (const Status known = check_lanes(); !known) return known.error();
    VerifyOptions plain;
    plain.simulation = options_.simulation;
    report_.baseline = verify(reader_, plain);
    if (report_.baseline.verdict != Verdict::match) return std::move(report_);
    tick_count_ = report_.baseline.ticks_recorded.value_or(report_.baseline.ticks_compared);
    if (const Status planned = plan(); !planned) return planned.error();
    if (const Status run = run_flips(); !run) return run.error();
    for (const InjectRow& row : report_.rows) {
      if (row.outcome == InjectRow::Outcome::found) ++report_.passed;
      if (row.outcome == InjectRow::Outcome::found && row.waived) ++report_.waived;
      if (row.outcome == InjectRow::Outcome::missed) ++report_.failed;
      if (row.outcome == InjectRow::Outcome::not_applicable) ++report_.not_applicable;
    }
    measure_lists();
    if (const Status found = check_row(); !found) return found.error();
    return std::move(report_);
  }

 private:
  /// Checks the row. The number of rows is known only from the states in which the flips were tried.
  Status check_row() const {
    std::uint64_t rows_seen = 0;
    for (const Flip& flip : flips_) rows_seen = std::max(rows_seen, flip.rows_seen);
    if (options_.body_count > rows_seen && rows_seen > 0)
      return Error{ErrorCode::usage,
                   "--bodies: more than table " + setup_.schema.tables[table_of_bodies(setup_.schema)].name +
                       " has rows: found " + std::to_string(options_.body_count) + ", expected 1.." +
                       std::to_string(rows_seen),
                   ""};
    if (!options_.row || *options_.row < rows_seen || rows_seen == 0) return {};
    return Error{ErrorCode::usage,
                 "--row: no such row" + (options_.table.empty() ? "" : " in table " + options_.table) + ": found " +
                     std::to_string(*options_.row) + ", expected 0.." + std::to_string(rows_seen - 1),
                 ""};
  }

  void measure_lists() {
    std::vector<std::uint64_t> lengths, concerned;
    for (const InjectRow& row : report_.rows) {
      if (row.outcome == InjectRow::Outcome::not_applicable || !row.cells_required) continue;
      lengths.push_back(row.list_length);
      if (!row.waived) concerned.push_back(row.concerned);
    }
    if (lengths.empty()) return;
    std::sort(lengths.begin(), lengths.end());
    std::sort(concerned.begin(), concerned.end());
    report_.lists = {lengths.size(), lengths[lengths.size() / 2], lengths.back(),
                     concerned.empty() ? 0 : concerned[concerned.size() / 2]};
  }

  Status check_names() const {
    bool table_known = options_.table.empty(), column_known = options_.column.empty();
    std::string tables, columns;
    for (const TableSchema& table : setup_.schema.tables) {
      tables += (tables.empty() ? "" : ", ") + table.name;
      if (!options_.table.empty() && table.name != options_.table) continue;
      table_known = true;
      for (const Column& column : table.columns) {
        columns += (columns.empty() ? "" : ", ") + column.name;
        column_known = column_known || column.name == options_.column;
      }
    }
    if (!table_known)
      return Error{ErrorCode::usage, "--table: no such table: found " + options_.table + ", expected one of " + tables,
                   ""};
    if (!column_known)
      return Error{ErrorCode::usage,
                   "--column: no such column: found " + options_.column + ", expected one of " + columns, ""};
    return {};
  }

  /// Checks that lane and bit are in a column that may be drawn. Requires: table and column were checked.
  Status check_lanes() const {
    std::uint32_t lanes = 0, bits = 0;  // lanes of the column with most lanes; most bits of a column with this lane
    for (std::size_t t = 0; t < setup_.schema.tables.size(); ++t) {
      const TableSchema& table = setup_.schema.tables[t];
      const bool in_bodies = options_.body_count > 0 || options_.after_substep;
      if (!options_.table.empty() && table.name != options_.table) continue;
      if (in_bodies && t != table_of_bodies(setup_.schema)) continue;
      for (const Column& column : table.columns) {
        if (!options_.column.empty() && column.name != options_.column) continue;
        lanes = std::max<std::uint32_t>(lanes, column.lane_count);
        if (options_.lane.value_or(0) < column.lane_count)
          bits = std::max<std::uint32_t>(bits, static_cast<std::uint32_t>(8u * scalar_info(column.type)->size));
      }
    }
    if (lanes == 0)
      return Error{ErrorCode::usage,
                   "--table, --column: no such place for --bodies and --after-substep: expected table " +
                       setup_.schema.tables[table_of_bodies(setup_.schema)].name + " and a column of it",
                   ""};
    if (options_.lane && *options_.lane >= lanes)
      return Error{ErrorCode::usage, "--lane: no such lane: " + range_text(*options_.lane, lanes), ""};
    if (options_.bit && *options_.bit >= bits)
      return Error{ErrorCode::usage, "--bit: no such bit: " + range_text(*options_.bit, bits), ""};
    return {};
  }

  std::string range_text(std::uint32_t found, std::uint32_t count) const {
    const std::string place =
        options_.table + (options_.table.empty() || options_.column.empty() ? "" : ".") + options_.column;
    return "found " + std::to_string(found) + ", expected 0.." + std::to_string(count - 1) +
           (place.empty() ? "" : " in " + place);
  }

  bool stored_in_full(std::uint64_t tick) const {
    return setup_.detail == replay::Detail::full && tick >= setup_.full_first && tick <= setup_.full_last;
  }

  /// Draws the tick of each flip. Ticks that are stored in full are preferred.
  Status plan() {
    std::uint64_t first = 0, count = tick_count_;
    if (setup_.detail == replay::Detail::full && setup_.full_first < tick_count_) {
      first = setup_.full_first;
      count = std::min(setup_.full_last, tick_count_ - 1) - first + 1;
    }
    if (options_.tick && *options_.tick >= tick_count_)
      return Error{ErrorCode::usage,
                   "--tick: beyond the trace: found " + std::to_string(*options_.tick) + ", expected 0.." +
                       std::to_string(tick_count_ - 1),
                   ""};
    Random random(options_.seed);
    for (std::uint64_t i = 0; i < options_.count; ++i) {
      Flip flip;
      flip.options = &options_;
      flip.tick = first + random.bits() % count;
      if (options_.tick) flip.tick = *options_.tick;
      flip.seed = random.bits();
      flips_.push_back(std::move(flip));
      InjectRow row;
      row.index = i;
      report_.rows.push_back(std::move(row));
    }
    return {};
  }

  /// Runs the flips. Each of n threads reads the whole trace and makes each n-th flip in the order of ticks.
  Status run_flips() {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < flips_.size(); ++i) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return flips_[a].tick != flips_[b].tick ? flips_[a].tick < flips_[b].tick : a < b;
    });
    std::vector<std::unique_ptr<TraceSource>> sources;
    sources.push_back(std::make_unique<ReaderSource>(reader_));
    while (options_.reopen && sources.size() < std::min<std::size_t>(options_.thread_count, order.size())) {
      auto source = options_.reopen();
      if (source == nullptr) break;  // fewer threads, the same results
      sources.push_back(std::move(source));
    }
    std::vector<Status> shares(sources.size());
    const Status ran = run_jobs(sources.size(), static_cast<unsigned>(sources.size()), [&](std::size_t job) {
      std::vector<std::size_t> share;
      for (std::size_t i = job; i < order.size(); i += sources.size()) share.push_back(order[i]);
      shares[job] = run_share(*sources[job], share);
    });
    if (!ran) return ran;
    for (const Status& share : shares)
      if (!share) return share;
    return {};
  }

  Status run_share(TraceSource& source, const std::vector<std::size_t>& order) {
    std::vector<std::size_t> left = order;  // flips that must run on the file itself
    SimulationPool pool(*options_.simulation);
    if (setup_.detail == replay::Detail::cells && can_load()) {
      Result<std::vector<std::size_t>> others = run_beside(source, order, pool);
      if (!others) return others.error();
      left = *std::move(others);
    }
    if (setup_.detail == replay::Detail::full && can_load()) left = run_excerpts(source, order, pool);
    for (const std::size_t index : left) run_flip(index, source, *options_.simulation, flips_[index].tick);
    return {};
  }

  /// In the first tick the simulation comes from the setup, because nothing is loaded.
  const SimulationInfo& simulation_for(std::uint64_t tick, const SimulationPool& pool) const {
    return tick == 0 ? *options_.simulation : pool.info();
  }

  /// Reads the file once. A flip costs one tick, and one more to judge it, if the state before its tick is stored.
  /// Returns the flips in other ticks.
  std::vector<std::size_t> run_excerpts(TraceSource& source, const std::vector<std::size_t>& order,
                                        const SimulationPool& pool) {
    std::vector<std::size_t> left;
    Bytes before;
    std::uint64_t before_root = 0;
    bool before_known = false;
    std::uint64_t before_ticks = 0;  // number of ticks before the state in `before`
    std::size_t next = 0;
    source.rewind();
    while (next < order.size()) {
      const TraceReader::Item& item = source.next();
      if (std::holds_alternative<std::monostate>(item)) break;
      if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item)) {
        before.assign(checkpoint->image.begin(), checkpoint->image.end());
        before_root = checkpoint->root_hash;
        before_ticks = checkpoint->tick;
        before_known = true;
        continue;
      }
      const TickRecord& record = std::get<TickRecord>(item);
      for (; next < order.size() && flips_[order[next]].tick == record.tick; ++next) {
        if (!before_known || before_ticks != record.tick || !record.image) {
          left.push_back(order[next]);
          continue;
        }
        Excerpt excerpt(setup_, before, record);
        excerpt.set_root(before_root);
        run_flip(order[next], excerpt, simulation_for(record.tick, pool), {});
      }
      before_known = record.image.has_value();
      if (record.image) {
        before = record.image->joined();
        before_root = record.root_hash;
        before_ticks = record.tick + 1;
      }
    }
    return left;
  }

  /// Does the same if states are not stored: another simulation runs in parallel and provides the states before the
  /// ticks.
  /// Errors: those of Simulation::step.
  Result<std::vector<std::size_t>> run_beside(TraceSource& source, const std::vector<std::size_t>& order,
                                              const SimulationPool& pool) {
    Result<std::unique_ptr<Simulation>> made = options_.simulation->make(setup_.setup);
    if (!made) return order;
    Simulation& beside = **made;
    Bytes before;
    std::size_t next = 0;
    source.rewind();
    while (next < order.size()) {
      const TraceReader::Item& item = source.next();
      if (std::holds_alternative<std::monostate>(item)) break;
      const auto* record = std::get_if<TickRecord>(&item);
      if (record == nullptr) continue;
      const bool has_flips = flips_[order[next]].tick == record->tick;
      const std::uint64_t root = has_flips ? root_hash(beside.state()) : 0;
      if (has_flips) encode_image(beside.state(), before);
      if (const Status did = beside.step({record->dt, record->inputs}, nullptr); !did) return did.error();
      if (!has_flips) continue;
      Excerpt excerpt(setup_, before, *record);
      excerpt.set_root(root);
      for (; next < order.size() && flips_[order[next]].tick == record->tick; ++next)
        run_flip(order[next], excerpt, simulation_for(record->tick, pool), {}, &beside.state());
    }
    return std::vector<std::size_t>();
  }

  /// `truth`: the state after the tick without the flip, if it is known.
  void run_flip(std::size_t index, TraceSource& source, const SimulationInfo& simulation,
                std::optional<std::uint64_t> to, const StateView* truth = nullptr) {
    Flip& flip = flips_[index];
    VerifyOptions options;
    options.simulation = &simulation;
    options.from = flip.tick;
    options.spread_ticks = 0;
    options.confirm_from_start = false;
    if (setup_.detail == replay::Detail::cells) options.row_count_max = every_candidate;
    options.to = to;
    options.wrap = [&flip](std::unique_ptr<Simulation> real, std::uint64_t ticks_done) {
      return flipping_simulation(std::move(real), ticks_done, flip);
    };
    source.rewind();
    const Report found = verify_source(source, options);
    // A fault inside the solver can leave its own row unchanged and change only other rows.
    if (truth != nullptr && !flip.row_after.empty() && flip.row_after == row_bytes(*truth, flip.bits[0].place))
      flip.waived = true;
    judge(flip, found, report_.rows[index]);
    if (!options_.progress) return;
    const std::lock_guard<std::mutex> lock(progress_lock_);
    options_.progress(++flips_done_);
  }

  void judge(const Flip& flip, const Report& found, InjectRow& row) const {
    row.tick = flip.tick;
    row.verdict = found.verdict;
    row.divergence = found.divergence;
    if (!flip.done) {
      const bool ran = found.verdict == Verdict::match;  // a run without a flip matches the trace
      row.outcome = ran ? InjectRow::Outcome::not_applicable : InjectRow::Outcome::missed;
      row.reason = ran ? "the state has no such place at this tick" : "no flip was made: " + verdict_text(found);
      return;
    }
    row.place = place_of(flip.bits[0]);
    row.bit = flip.bits[0].bit;
    for (std::size_t i = 1; i < flip.bits.size(); ++i) row.more.push_back({place_of(flip.bits[i]), flip.bits[i].bit});
    const bool is_inside = options_.after_substep.has_value();
    if (is_inside && found.verdict == Verdict::match) {
      row.outcome = InjectRow::Outcome::not_applicable;
      row.reason = "rounding took the fault away: the state at the end of the tick is as recorded";
      return;
    }
    row.cells_required = found.divergence && found.divergence->from_cells;
    // A checkpoint directly after the tick also has the state with the place.
    row.place_required = !row.cells_required && !is_inside &&
                         (stored_in_full(flip.tick) || (found.divergence && !found.divergence->tables.empty()));
    row.concerned = flip.concerned.size();
    row.waived = flip.waived;
    if (row.cells_required) row.list_length = found.divergence->candidate_count;
    row.reason = why_missed(flip, found, row);
    row.outcome = row.reason.empty() ? InjectRow::Outcome::found : InjectRow::Outcome::missed;
    if (row.outcome == InjectRow::Outcome::found && row.divergence) row.divergence->candidates.clear();
  }

  LaneReport place_of(const FlippedBit& flipped) const {
    const TableSchema& table = setup_.schema.tables[flipped.place.table];
    const Column& column = table.columns[flipped.place.column];
    LaneReport place;
    place.table = table.name;
    place.column = column.name;
    place.row = flipped.place.row;
    place.name = flipped.row_name;
    place.lane = static_cast<std::uint32_t>(flipped.place.lane);
    place.lane_count = column.lane_count;
    place.type = column.type;
    place.expected = flipped.true_bits;
    if (flipped.true_bits) place.got = *flipped.true_bits ^ (std::uint64_t{1} << flipped.bit);
    return place;
  }

  /// Why cells did not find the flip; empty: they did. Required: the exact table and columns, and each concerned row in
  /// the list. A fault inside the solver reaches other columns and tables by the end of the tick.
  std::string why_missed_by_cells(const Flip& flip, const Divergence& divergence, const InjectRow& row) const {
    const auto table = std::find_if(divergence.tables.begin(), divergence.tables.end(),
                                    [&](const TableDifference& found) { return found.table == row.place.table; });
    if (flip.waived) return "";  // its own row is unchanged: other rows show the flip
    if (table == divergence.tables.end()) return "table " + row.place.table + " is not named";
    if (!options_.after_substep) {
      if (divergence.tables.size() != 1) return "other tables are named";
      std::vector<std::string> columns;
      for (const Column& column : setup_.schema.tables[flip.bits[0].place.table].columns)
        for (const FlippedBit& flipped : flip.bits)
          if (place_of(flipped).column == column.name && (columns.empty() || columns.back() != column.name))
            columns.push_back(column.name);
      if (table->columns != columns) return "other columns are named";
    }
    for (const CellOwner& owner : flip.concerned)
      if (std::none_of(divergence.candidates.begin(), divergence.candidates.end(), [&](const Candidate& candidate) {
            return candidate.table == setup_.schema.tables[owner.table].name && candidate.row == owner.row;
          }))
        return setup_.schema.tables[owner.table].name + " row " + std::to_string(owner.row) + " is not in the list";
    return "";
  }

  static std::string verdict_text(const Report& found) {
    return "verdict " + std::string(verdict_info(found.verdict).name) +
           (found.reason.empty() ? "" : " (" + found.reason + ")");
  }

  std::string why_missed(const Flip& flip, const Report& found, const InjectRow& row) const {
    if (found.verdict != Verdict::diverged || !found.divergence) return verdict_text(found) + ", expected diverged";
    const Divergence& divergence = *found.divergence;
    if (divergence.tick != row.tick) return "tick " + std::to_string(divergence.tick);
    if (divergence.stage == stage_setup || divergence.stage == stage_load) return "reported before the tick ran";
    if (row.cells_required) return why_missed_by_cells(flip, divergence, row);
    if (!row.place_required) return "";
    if (!row.more.empty()) {
      const bool same = divergence.lane_count == 1 + row.more.size() && divergence.tables.size() == 1 &&
                        divergence.tables[0].table == row.place.table;
      return same ? ""
                  : std::to_string(divergence.lane_count) + " lanes, expected " + std::to_string(1 + row.more.size());
    }
    if (divergence.lane_count != 1 || divergence.rows.size() != 1 || divergence.tables.size() != 1)
      return std::to_string(divergence.lane_count) + " lanes, expected 1";
    const LaneReport& lane = divergence.rows[0];
    if (divergence.tables[0].table != row.place.table || lane.table != row.place.table) return "table " + lane.table;
    if (divergence.tables[0].columns != std::vector<std::string>{row.place.column} || lane.column != row.place.column)
      return "column " + lane.column;
    if (lane.row != row.place.row) return "row " + std::to_string(lane.row);
    if (lane.lane != row.place.lane) return "lane " + std::to_string(lane.lane);
    if (lane.expected != row.place.expected || lane.got != row.place.got) return "other values";
    return "";
  }

  bool can_load() const {
    const Result<std::unique_ptr<Simulation>> made = options_.simulation->make(setup_.setup);
    if (!made) return false;
    const Status loaded = (*made)->load({});
    return loaded || loaded.error().code != ErrorCode::unsupported;
  }

  TraceReader& reader_;
  const replay::TraceSetup& setup_;
  const InjectOptions& options_;
  InjectReport report_;
  std::uint64_t tick_count_ = 0;
  std::mutex progress_lock_;
  std::uint64_t flips_done_ = 0;
  std::vector<Flip> flips_;  // each used by one thread
};

}  // namespace

int InjectReport::exit_code() const {
  if (baseline.verdict != Verdict::match) return baseline.exit_code();
  return failed == 0 && passed > 0 ? exit_ok : exit_finding;
}

Result<InjectReport> inject(TraceReader& reader, const InjectOptions& options) {
  return Injector(reader, options).run();
}

}  // namespace ticktrue::verifier
