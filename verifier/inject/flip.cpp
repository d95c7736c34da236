// Draws the bits of a flip, and flips them in the state of a simulation.
// SPDX-License-Identifier: MIT
#include "verifier/inject/flip.h"

#include <algorithm>
#include <span>
#include <utility>

#include "base/random.h"

namespace ticktrue::verifier {
namespace {

/// Draws a table, row, column, lane and bit of `state` that the options allow. False: there is none.
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

/// Draws all bits of a flip, in different rows. False: there are too few rows.
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
    // A flipped reference concerns its old and its new target row. A flipped key belongs to the row as reported.
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

  /// Draws places until one of them has a value inside the solver.
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

  /// Requires: rows do not move between the solver and the end of the tick.
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

}  // namespace

std::unique_ptr<Simulation> flipping_simulation(std::unique_ptr<Simulation> real, std::uint64_t ticks_done,
                                                Flip& flip) {
  return std::make_unique<FlippingSimulation>(std::move(real), ticks_done, flip);
}

Bytes row_bytes(const StateView& state, const StatePlace& place) {
  const std::size_t size = state.schema->tables[place.table].row_size;
  if (place.row >= state.tables[place.table].row_count) return {};
  const std::uint8_t* row = state.tables[place.table].data + place.row * size;
  return Bytes(row, row + size);
}

std::size_t table_of_bodies(const StateSchema& schema) {
  std::vector<std::size_t> references(schema.tables.size());
  for (const TableSchema& table : schema.tables)
    for (const Column& column : table.columns)
      if (column.target >= 0) ++references[static_cast<std::size_t>(column.target)];
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    references[t] = 2 * references[t] + (schema.tables[t].key_column_count > 0);
  return static_cast<std::size_t>(std::max_element(references.begin(), references.end()) - references.begin());
}

}  // namespace ticktrue::verifier
