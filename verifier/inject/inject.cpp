// Fault injection: verifies a trace with a simulation whose state has one flipped bit.
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
#include "verifier/inject/simulation_pool.h"
#include "verifier/verify/verify.h"

namespace ticktrue::verifier {
namespace {

using replay::CheckpointRecord;
using replay::TickRecord;
using replay::TraceReader;

/// One flipped bit.
struct FlippedBit {
  StatePlace place;
  std::uint32_t bit = 0;
  std::optional<std::uint64_t> true_bits;  // not known inside the solver
  std::string row_name;
};

/// The requested flip and, after it was made, its place.
struct Flip {
  std::uint64_t tick = 0;
  std::uint64_t seed = 0;  // of the draws below the tick
  const InjectOptions* options = nullptr;

  bool done = false;
  std::vector<FlippedBit> bits;
  std::vector<CellOwner> concerned;  // rows whose values it changes
  Bytes row_after;                   // inside the solver: the row at the end of the tick
  bool waived = false;               // it became what it would have been without
  std::uint64_t rows_seen = 0;       // of the largest table the flip could be in
};

Bytes row_bytes(const StateView& state, const StatePlace& place) {
  const std::size_t size = state.schema->tables[place.table].row_size;
  if (place.row >= state.tables[place.table].row_count) return {};
  const std::uint8_t* row = state.tables[place.table].data + place.row * size;
  return Bytes(row, row + size);
}

/// The table whose rows are the bodies: the one most columns refer to; without references the first with a key.
std::size_t table_of_bodies(const StateSchema& schema) {
  std::vector<std::size_t> references(schema.tables.size());
  for (const TableSchema& table : schema.tables)
    for (const Column& column : table.columns)
      if (column.target >= 0) ++references[static_cast<std::size_t>(column.target)];
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    references[t] = 2 * references[t] + (schema.tables[t].key_column_count > 0);
  return static_cast<std::size_t>(std::max_element(references.begin(), references.end()) - references.begin());
}

/// Draws a table, row, column, lane and bit among those of `state` the options allow. False if there is none.
bool draw_place(const StateView& state, const InjectOptions& options, Random& random, Flip& flip, FlippedBit& drawn) {
  const bool in_bodies = options.body_count > 0 || options.after_substep;
  const auto fits = [&](const Column& column) {
    return (options.column.empty() || column.name == options.column) &&
           (!options.lane || *options.lane < column.lane_count) &&
           (!options.bit || *options.bit < 8u * scalar_info(column.type)->size);
  };
  std::vector<std::size_t> tables;
  for (std::size_t t = 0; t < state.tables.size(); ++t) {
    const TableSchema& table = state.schema->tables[t];
    if (!options.table.empty() && table.name != options.table) continue;
    if (in_bodies && t != table_of_bodies(*state.schema)) continue;
    if (std::any_of(table.columns.begin(), table.columns.end(), fits))
      flip.rows_seen = std::max<std::uint64_t>(flip.rows_seen, state.tables[t].row_count);
    if (state.tables[t].row_count == 0 || (options.row && *options.row >= state.tables[t].row_count)) continue;
    if (std::any_of(table.columns.begin(), table.columns.end(), fits)) tables.push_back(t);
  }
  if (tables.empty()) return false;
  StatePlace& place = drawn.place;
  place.table = tables[static_cast<std::size_t>(random.below(tables.size()))];
  const TableSchema& table = state.schema->tables[place.table];
  const std::uint64_t row = random.below(state.tables[place.table].row_count);
  place.row = static_cast<std::size_t>(options.row.value_or(row));
  std::vector<std::size_t> columns;
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    if (fits(table.columns[c])) columns.push_back(c);
  place.column = columns[static_cast<std::size_t>(random.below(columns.size()))];
  const Column& column = table.columns[place.column];
  const std::uint64_t lane = random.below(column.lane_count);
  place.lane = static_cast<std::size_t>(options.lane.value_or(static_cast<std::uint32_t>(lane)));
  const std::uint64_t bit = random.below(8u * scalar_info(column.type)->size);
  drawn.bit = options.bit.value_or(static_cast<std::uint32_t>(bit));
  return true;
}

/// Draws all bits of a flip, in different rows. False if there are too few.
bool draw_places(const StateView& state, Flip& flip) {
  Random random(flip.seed);
  flip.bits.clear();
  const std::size_t wanted = std::max(1u, flip.options->body_count);
  for (std::size_t tries = 0; flip.bits.size() < wanted && tries < 1'000 * wanted; ++tries) {
    FlippedBit drawn;
    if (!draw_place(state, *flip.options, random, flip, drawn)) return false;
    if (std::none_of(flip.bits.begin(), flip.bits.end(),
                     [&](const FlippedBit& other) { return other.place.row == drawn.place.row; }))
      flip.bits.push_back(std::move(drawn));
  }
  return flip.bits.size() == wanted;
}

void add_concerned(const StateView& state, const FlippedBit& flipped, std::vector<CellOwner>& concerned) {
  for (const CellOwner& owner : CellHasher(*state.schema).owners_of(state, flipped.place.table, flipped.place.row))
    if (std::none_of(concerned.begin(), concerned.end(),
                     [&](const CellOwner& other) { return other.table == owner.table && other.row == owner.row; }))
      concerned.push_back(owner);
}

/// Forwards to the real simulation, but flips one bit of its state at the end of one tick.
class FlippingSimulation : public Simulation {
 public:
  FlippingSimulation(std::unique_ptr<Simulation> real, std::uint64_t ticks_done, Flip& flip)
      : real_(std::move(real)), ticks_done_(ticks_done), flip_(flip) {}

  Status accept(const TickInput& input) const override { return real_->accept(input); }
  Status step(const TickInput& input, StageObserver* observer) override {
    const bool is_due = ticks_done_ == flip_.tick;
    const bool is_inside = flip_.options->after_substep.has_value();
    if (is_due && is_inside) inject_flip();
    shows_flip_ = false;
    if (Status did = real_->step(input, observer); !did) return did;
    ++ticks_done_;
    if (is_due && is_inside && flip_.done) describe_injected();
    shows_flip_ = is_due && !is_inside && make_flip();
    return {};
  }
  const StateView& state() const override { return shows_flip_ ? view_ : real_->state(); }
  Status load(ByteView image) override {
    const Status loaded = real_->load(image);
    if (loaded) shows_flip_ = false;
    return loaded;
  }
  std::span<const std::string> stage_names() const override { return real_->stage_names(); }
  std::string row_name(std::size_t table, std::size_t row) const override { return real_->row_name(table, row); }
  std::string inputs_text(std::uint64_t tick, ByteView inputs) const override {
    return real_->inputs_text(tick, inputs);
  }

 private:
  bool make_flip() {
    view_ = real_->state();
    if (!draw_places(view_, flip_)) return false;
    const std::size_t table_index = flip_.bits[0].place.table;
    const TableSchema& table = view_.schema->tables[table_index];
    TableRows& rows = view_.tables[table_index];
    rows_.assign(rows.data, rows.data + static_cast<std::size_t>(rows.row_count) * table.row_size);
    rows.data = rows_.data();
    for (FlippedBit& flipped : flip_.bits) flip_bit(table, flipped);
    // A flipped reference concerns the rows it led to and those it leads to. A flipped key belongs to the row as shown.
    flip_.concerned.clear();
    for (const FlippedBit& flipped : flip_.bits) {
      add_concerned(view_, flipped, flip_.concerned);
      if (!owns_rows(*view_.schema, table_index)) add_concerned(real_->state(), flipped, flip_.concerned);
    }
    flip_.done = true;
    return true;
  }

  void flip_bit(const TableSchema& table, FlippedBit& flipped) {
    const Column& column = table.columns[flipped.place.column];
    const std::size_t size = scalar_info(column.type)->size;
    std::uint8_t* lane = rows_.data() + flipped.place.row * table.row_size + column.offset + flipped.place.lane * size;
    const auto byte_of = [&](std::size_t index) { return machine_is_little_endian ? index : size - 1 - index; };
    std::uint64_t true_bits = 0;
    for (std::size_t i = 0; i < size; ++i) true_bits |= static_cast<std::uint64_t>(lane[byte_of(i)]) << (8 * i);
    flipped.true_bits = true_bits;
    std::uint8_t& byte = lane[byte_of(flipped.bit / 8)];
    byte = static_cast<std::uint8_t>(byte ^ (1u << (flipped.bit % 8)));
    flipped.row_name = real_->row_name(flipped.place.table, flipped.place.row);
  }

  /// Draws until a place has a value inside the solver.
  void inject_flip() {
    Random random(flip_.seed);
    flip_.done = false;
    for (int tries = 0; tries < 1'000 && !flip_.done; ++tries) {
      FlippedBit drawn;
      if (!draw_place(real_->state(), *flip_.options, random, flip_, drawn)) return;
      flip_.done = static_cast<bool>(real_->inject({*flip_.options->after_substep, drawn.place, drawn.bit}));
      flip_.bits = {drawn};
    }
  }

  /// Rows do not move between the solver and the end of the tick.
  void describe_injected() {
    FlippedBit& injected = flip_.bits[0];
    injected.row_name = real_->row_name(injected.place.table, injected.place.row);
    flip_.concerned.clear();
    flip_.row_after = row_bytes(real_->state(), injected.place);
    if (!flip_.row_after.empty()) add_concerned(real_->state(), injected, flip_.concerned);
  }

  std::unique_ptr<Simulation> real_;
  std::uint64_t ticks_done_;
  Flip& flip_;
  bool shows_flip_ = false;
  StateView view_;
  Bytes rows_;  // of the table with the flip
};

/// One tick of a trace with the state before it as a checkpoint: enough for a flip in this tick.
class Excerpt : public TraceSource {
 public:
  Excerpt(const replay::TraceSetup& setup, const Bytes& state_before, const TickRecord& record)
      : setup_(setup), checkpoint_(CheckpointRecord{record.tick, 0, state_before}), tick_(record) {
    tail_.ticks_intact = record.tick + 1;
  }
  /// Of the state before the tick, as recorded.
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
  /// How many rows there are is known only from the states the flips were tried on.
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

  /// Lane and bit are in some column that may be drawn. Requires: table and column are known.
  Status check_lanes() const {
    std::uint32_t lanes = 0, bits = 0;  // of the widest column; bits of those that have the lane
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

  /// Draws the tick of each flip: among those stored in full where there are any.
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

  /// Every thread reads the whole trace and takes its share of the flips, every n-th of them in the order of ticks.
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
    std::vector<std::size_t> left = order;  // flips that have to run on the file itself
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

  /// The first tick begins with the setup and loads nothing.
  const SimulationInfo& simulation_for(std::uint64_t tick, const SimulationPool& pool) const {
    return tick == 0 ? *options_.simulation : pool.info();
  }

  /// One pass through the file: each flip in a tick whose state before is stored costs one tick (and one more to
  /// judge). Returns the flips in other ticks.
  std::vector<std::size_t> run_excerpts(TraceSource& source, const std::vector<std::size_t>& order,
                                        const SimulationPool& pool) {
    std::vector<std::size_t> left;
    Bytes before;
    std::uint64_t before_root = 0;
    bool before_known = false;
    std::uint64_t before_ticks = 0;  // ticks done in `before`
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

  /// The same where states are not stored: a simulation runs along, whose state before the tick is taken.
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

  /// `truth`: the state after the tick without the flip, where it is known.
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
      return std::make_unique<FlippingSimulation>(std::move(real), ticks_done, flip);
    };
    source.rewind();
    const Report found = verify_source(source, options);
    // A fault inside the solver may leave its own row as it is and show in those around it alone.
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
      const bool ran = found.verdict == Verdict::match;  // without a flip the trace matches
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
    // A checkpoint right after the tick also contains the place.
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

  /// With cells: the table and its columns exactly, and each row concerned in the list. A fault inside the solver
  /// reaches other columns and tables by the end of the tick.
  std::string why_missed_by_cells(const Flip& flip, const Divergence& divergence, const InjectRow& row) const {
    const auto table = std::find_if(divergence.tables.begin(), divergence.tables.end(),
                                    [&](const TableDifference& found) { return found.table == row.place.table; });
    if (flip.waived) return "";  // its row is as it should be: it shows elsewhere
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
