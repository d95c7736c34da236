// Walks a segment of a trace: step, hash, compare. Describes a difference from the records of one tick.
// SPDX-License-Identifier: MIT
#include "verifier/verify/walk.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <variant>

#include "base/state/stage_hashes.h"
#include "verifier/locate/locate.h"
#include "verifier/locate/locate_cells.h"
#include "verifier/verify/sync_test.h"

namespace ticktrue::verifier {
namespace {

using replay::CheckpointRecord;
using replay::TickRecord;

bool is_watched(const StateSchema& schema, std::size_t table) {
  return schema.tables.size() == 1 || schema.tables[table].name != "world";
}

std::size_t table_size(const StateView& state, std::size_t table) {
  return static_cast<std::size_t>(state.tables[table].row_count) * state.schema->tables[table].row_size;
}

class SegmentWalk {
 public:
  SegmentWalk(const WalkContext& context, TraceSource& source, const Segment& segment)
      : context_(context),
        source_(source),
        segment_(segment),
        comparer_(context.setup.schema),
        last_dt_(context.setup.dt) {
    result_.tick = result_.last_checkpoint = segment.start.tick;
    result_.time_s = result_.last_checkpoint_s = segment.start.time_s;
  }

  WalkResult run() {
    simulation_ = begin_at(context_, segment_.start, result_.findings);
    if (simulation_ == nullptr || !check_loaded()) return std::move(result_);
    watch_.begin(simulation_->state());
    result_.end = begins_sync_test() ? walk_on() : WalkEnd::stopped;
    end_sync_test();
    if (result_.end == WalkEnd::end_of_trace) read_end();
    result_.changed = watch_.changed();
    return std::move(result_);
  }

 private:
  WalkEnd walk_on() {
    for (;;) {
      if (context_.options.to && result_.tick > *context_.options.to) return WalkEnd::reached_stop;
      if (segment_.is_abandoned && segment_.is_abandoned()) return WalkEnd::abandoned;
      const replay::TraceReader::Item& item = source_.next();
      if (std::holds_alternative<std::monostate>(item)) return WalkEnd::end_of_trace;
      if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item)) {
        if (checkpoint->tick != result_.tick || (segment_.start.loaded && result_.tick == segment_.start.tick))
          continue;
        if (!check_checkpoint(*checkpoint)) return WalkEnd::stopped;
        if (is_start(context_, *checkpoint)) {
          result_.last_checkpoint = result_.tick;
          result_.last_checkpoint_s = result_.time_s;
        }
        if (result_.tick < segment_.stop) continue;
        result_.boundary = start_at(*checkpoint, result_.time_s);
        return WalkEnd::reached_stop;
      }
      const TickRecord& record = std::get<TickRecord>(item);
      const TickInput input{record.dt, record.inputs};
      stages_.clear();
      if (!accepts(input) || !steps(input, record.stage_hashes.empty() ? nullptr : &stages_)) return WalkEnd::stopped;
      if (!compare_tick(record)) return WalkEnd::mismatch;
      if (sync_ && !sync_->add(input)) return WalkEnd::stopped;
    }
  }

  /// False: the simulation cannot be saved; the finding is set behind the walk.
  bool begins_sync_test() {
    if (segment_.sync_ticks == 0) return true;
    const bool by_save = context_.options.simulation->has_saves;
    sync_.emplace(*simulation_, by_save ? BroughtBackBy::save : BroughtBackBy::image, segment_.sync_ticks,
                  context_.options.row_count_max);
    return sync_->begin(result_.tick, result_.time_s);
  }

  void end_sync_test() {
    if (!sync_) return;
    const bool is_whole = result_.end == WalkEnd::end_of_trace || result_.end == WalkEnd::reached_stop;
    if (is_whole && !sync_->finish()) result_.end = WalkEnd::stopped;
    result_.sync_tick_count = sync_->tick_count();
    result_.sync_missing_saves = sync_->missing_save_count();
    result_.sync_last_load = sync_->last_load();
    if (!sync_->finding()) return;
    const SyncFinding& finding = *sync_->finding();
    result_.sync_begin = finding.begin;
    result_.findings.decide(Verdict::state_incomplete, finding.reason, finding.hint);
    result_.findings.divergence = finding.divergence;
  }

  /// Compares the state after loading with the image that was loaded.
  bool check_loaded() {
    if (!segment_.start.loaded) return true;
    if (segment_.counts_load) ++result_.checkpoints_compared;
    return compare_image(segment_.start.root_hash, segment_.start.image, stage_load,
                         loads_saves(context_) ? "the state behind load of the save is not the checkpoint's"
                                               : "the state after loading the checkpoint is not the checkpoint's");
  }

  bool check_checkpoint(const CheckpointRecord& checkpoint) {
    const bool at_start = result_.tick == 0;
    ++result_.checkpoints_compared;
    return compare_image(checkpoint.root_hash, checkpoint.image,
                         at_start ? stage_setup : std::string_view("checkpoint"),
                         at_start ? "the state made from the setup is not the recorded one"
                                  : "the hash of the tick before agrees, the checkpoint does not");
  }

  /// Compares the present state with a checkpoint. False: they differ, and the finding is set.
  bool compare_image(std::uint64_t expected_root, ByteView expected, std::string_view stage, const char* note) {
    const std::uint64_t got_root = root_hash(simulation_->state());
    encode_image(simulation_->state(), image_);
    if (got_root == expected_root && std::equal(expected.begin(), expected.end(), image_.begin(), image_.end()))
      return true;
    Divergence divergence;
    divergence.tick = result_.tick;
    divergence.time_s = result_.time_s;
    divergence.stage = std::string(stage);
    divergence.stage_note = note;
    divergence.expected_root = expected_root;
    divergence.got_root = got_root;
    describe_lanes(context_, *simulation_, expected, image_, divergence, result_.findings);
    result_.findings.divergence = std::move(divergence);
    result_.findings.decide(Verdict::diverged, "");
    // Two simulations with different initial states are not reproducible. Otherwise the builds differ.
    if (result_.tick == segment_.start.tick)
      if (const auto again = begin_at(context_, segment_.start, result_.findings)) {
        Bytes second;
        encode_image(again->state(), second);
        if (second != image_)
          result_.findings.not_reproducible("two simulations made here begin with different states");
      }
    return false;
  }

  bool accepts(const TickInput& input) {
    const Status accepted = simulation_->accept(input);
    if (accepted) return true;
    result_.findings.decide(
        Verdict::not_comparable,
        "tick " + std::to_string(result_.tick) + ": recorded inputs are refused here: " + accepted.error().message,
        "the bytes are intact: this build takes other inputs than the one that recorded them");
    return false;
  }

  /// False: the simulation refused the step; the finding is set.
  bool steps(const TickInput& input, StageObserver* observer) {
    const Status did = simulation_->step(input, observer);
    last_dt_ = input.dt;
    if (did) return true;
    result_.findings.undone(did.error());
    return false;
  }

  /// False: the result differs from the recorded one.
  bool compare_tick(const TickRecord& record) {
    const TickSide sides[] = {side_of(record), side_here()};
    const std::optional<TickDifference> difference = comparer_.compare(sides);
    count_tick();
    if (difference) {
      store_mismatch(record, difference->part);
      return false;
    }
    result_.root_hash = record.root_hash;
    watch_.update(simulation_->state());
    result_.time_s += record.dt;
    if (context_.options.on_compared && segment_.counts && result_.tick >= segment_.count_from)
      context_.options.on_compared(result_.time_s);
    ++result_.tick;
    result_.last_tick_s = result_.time_s;
    if (segment_.progress) segment_.progress(result_.tick);
    return true;
  }

  TickSide side_here() const {
    TickSide side{root_hash(simulation_->state()), stages_.hashes()};
    side.state = &simulation_->state();
    return side;
  }

  void count_tick() {
    const ComparedParts compared = comparer_.take_compared();
    result_.last_tick_s = result_.time_s;
    if (!segment_.counts || result_.tick < segment_.count_from) return;
    ++result_.ticks_compared;
    result_.compared += compared;
  }

  void store_mismatch(const TickRecord& record, TickPart part) {
    Mismatch found;
    found.expected = copy_of(record);
    found.part = part;
    found.got_stages = stages_.hashes();
    encode_image(simulation_->state(), found.got);
    const replay::TraceReader::Item& item = source_.next();
    if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item);
        checkpoint != nullptr && checkpoint->tick == result_.tick + 1 && !found.expected.image)
      found.expected.image = Bytes(checkpoint->image.begin(), checkpoint->image.end());
    found.divergence =
        describe_mismatch(context_, *simulation_, found.expected, result_.time_s, side_here(), result_.findings);
    if (part != TickPart::root_hash) result_.findings.notes.push_back(contradiction_text(record.tick, part));
    if (part == TickPart::image || part == TickPart::cells)
      found.divergence.stage_note = "not known: the root hash of the tick agrees, its " + std::string(name_of(part)) +
                                    (part == TickPart::image ? " does not" : " do not");
    if (const auto place = find_non_finite(simulation_->state())) {
      result_.findings.notes.push_back("the state here is not finite: " +
                                       place_text(context_.setup.schema, *place, names_of(*simulation_)));
      result_.findings.non_finite = find_non_finite_of(*simulation_, result_.tick);
    }
    // A state that load would refuse is not stepped: the behaviour of the simulation would be undefined.
    const bool goes_on =
        context_.options.spread_ticks > 0 && ticktrue::check_image(*simulation_->state().schema, found.got);
    if (!follow_spread(item, goes_on ? context_.options.spread_ticks : 0, found.divergence))
      result_.trace_end = TraceEnd{source_.tail(), ""};
    result_.mismatch = std::move(found);
  }

  /// Continues after the divergence and counts the differing rows 1, 2, 4, 8, ... ticks later. `item`: the last item
  /// read from the source. False: the source has ended.
  bool follow_spread(const replay::TraceReader::Item& item, std::uint64_t tick_count, Divergence& divergence) {
    CellHasher hasher(context_.setup.schema);
    const replay::TraceReader::Item* next = &item;
    for (std::uint64_t behind = 1; behind <= tick_count; next = &source_.next()) {
      if (std::holds_alternative<std::monostate>(*next)) return false;
      const auto* record = std::get_if<TickRecord>(next);
      if (record == nullptr) continue;
      const TickInput input{record->dt, record->inputs};
      const bool is_stored = record->cells != nullptr || record->image;
      const std::optional<std::uint64_t>& to = context_.options.to;
      if (!is_stored || (to && record->tick > *to) || find_non_finite(simulation_->state()) ||
          !simulation_->accept(input))
        return true;
      if (!simulation_->step(input, nullptr)) return true;
      if ((behind & (behind - 1)) == 0)
        if (const auto spread = measure_spread(context_.setup.schema, *record, simulation_->state(), hasher))
          divergence.spread.push_back(*spread);
      ++behind;
    }
    return !std::holds_alternative<std::monostate>(*next);
  }

  void read_end() {
    TraceEnd end{source_.tail(), ""};
    if (end.tail.has_pending_inputs)
      end.pending_inputs = simulation_->inputs_text(end.tail.ticks_intact, end.tail.pending_inputs);
    if (end.tail.condition == replay::TraceCondition::complete && end.tail.end &&
        end.tail.end->reason == replay::EndReason::non_finite)
      check_non_finite_end(end.tail);
    result_.trace_end = std::move(end);
  }

  /// The recording ended because the next tick produced a NaN or an infinity. This must happen here too, in the same
  /// column and row.
  void check_non_finite_end(const replay::TraceTail& tail) {
    // A tick without inputs and with an unchanged dt leaves no pending record.
    const TickInput input =
        tail.has_pending_inputs ? TickInput{tail.pending_dt, tail.pending_inputs} : TickInput{last_dt_, {}};
    if (!accepts(input) || !steps(input, nullptr)) return;
    const StateView& state = simulation_->state();
    result_.findings.non_finite = find_non_finite_of(*simulation_, result_.tick);
    NonFiniteTick found = compare_non_finite(result_.tick, state, tail.end->note, names_of(*simulation_));
    if (found.is_as_recorded) {
      result_.findings.notes.push_back(found.text);
      return;
    }
    result_.findings.decide(Verdict::diverged, found.text);
    Divergence& divergence = found.divergence;
    divergence.time_s = result_.time_s;
    divergence.inputs = simulation_->inputs_text(result_.tick, tail.pending_inputs);
    if (found.place) {
      const TableSchema& table = context_.setup.schema.tables[found.place->table];
      divergence.tables.push_back({table.name, {table.columns[found.place->column].name}});
    }
    result_.findings.divergence = std::move(divergence);
  }

  const WalkContext& context_;
  TraceSource& source_;
  const Segment& segment_;
  TickComparer comparer_;
  StageHashes stages_;  // of the last tick, if the trace stores them
  WalkResult result_;
  std::unique_ptr<Simulation> simulation_;
  std::optional<SyncTest> sync_;
  double last_dt_;  // s, of the tick that ran last
  ChangeWatch watch_;
  Bytes image_;  // reused
};

}  // namespace

Start start_at(const CheckpointRecord& checkpoint, double time_s) {
  Start start;
  start.tick = checkpoint.tick;
  start.time_s = time_s;
  start.loaded = true;
  start.image.assign(checkpoint.image.begin(), checkpoint.image.end());
  if (checkpoint.save) start.save.assign(checkpoint.save->begin(), checkpoint.save->end());
  start.root_hash = checkpoint.root_hash;
  return start;
}

void Findings::decide(Verdict found, std::string why, std::string next) {
  decided = true;
  verdict = found;
  reason = std::move(why);
  hint = std::move(next);
}

void Findings::undone(const Error& error) {
  if (error.code == ErrorCode::inconsistent) return decide(Verdict::not_reproducible, error.message, error.hint);
  decide(Verdict::not_comparable, "cannot be done here: " + error.message,
         "the bytes are intact: the build that recorded them allows more");
}

void Findings::warn_unreadable(std::uint64_t tick, const Error& error) {
  warnings.push_back("stored state of tick " + std::to_string(tick) + " cannot be read: " + error.message);
}

void Findings::not_reproducible(const std::string& why) {
  decide(Verdict::not_reproducible, why,
         "look for uninitialised memory, addresses, clocks, threads or random numbers in the simulation");
}

RowNamer names_of(const Simulation& simulation) {
  return [&simulation](std::size_t table, std::size_t row) { return simulation.row_name(table, row); };
}

std::unique_ptr<Simulation> make_simulation(const WalkContext& context, Findings& findings) {
  Result<std::unique_ptr<Simulation>> made = context.options.simulation->make(context.setup.setup);
  if (made) return std::move(*made);
  findings.decide(Verdict::not_comparable, "setup refused here: " + made.error().message, made.error().hint);
  return nullptr;
}

std::unique_ptr<Simulation> begin_at(const WalkContext& context, const Start& start, Findings& findings) {
  std::unique_ptr<Simulation> simulation = make_simulation(context, findings);
  if (simulation == nullptr) return nullptr;
  if (start.loaded) {
    const bool by_save = loads_saves(context);
    const Status loaded = by_save ? simulation->load_saved(start.tick, start.save) : simulation->load(start.image);
    if (!loaded) {
      if (loaded.error().code == ErrorCode::unsupported) {
        refuse_loading(context, findings);
        return nullptr;
      }
      findings.decide(Verdict::diverged, (by_save ? "save" : "checkpoint") + std::string(" at tick ") +
                                             std::to_string(start.tick) + " is refused: " + loaded.error().message);
      Divergence divergence;
      divergence.tick = start.tick;
      divergence.time_s = start.time_s;
      divergence.stage = stage_load;
      divergence.stage_note = by_save ? "the save is intact, but load of this build does not take it"
                                      : "the checkpoint is intact, but this build does not load it";
      divergence.expected_root = start.root_hash;
      findings.divergence = std::move(divergence);
      return nullptr;
    }
  }
  if (context.options.wrap) simulation = context.options.wrap(std::move(simulation), start.tick);
  return simulation;
}

void refuse_loading(const WalkContext& context, Findings& findings) {
  const bool lacks_saves = context.options.simulation->has_saves;
  findings.decide(
      Verdict::not_comparable,
      lacks_saves ? "the trace holds no saves, and " + context.setup.simulation + " loads nothing else"
                  : "the state of " + context.setup.simulation + " can only be observed, not loaded",
      lacks_saves ? "record it again, or use --mode replay without --from" : "use --mode replay without --from");
}

bool loads_saves(const WalkContext& context) {
  const SimulationInfo* info = context.options.simulation;
  return info != nullptr && info->has_saves && context.setup.has(replay::Feature::saves);
}

bool is_start(const WalkContext& context, const CheckpointRecord& checkpoint) {
  return checkpoint.save || !loads_saves(context);
}

bool can_load(const WalkContext& context, Findings& findings) {
  if (loads_saves(context)) return true;
  // A simulation that cannot load refuses any image as unsupported. Others refuse the empty image without effect.
  const std::unique_ptr<Simulation> simulation = make_simulation(context, findings);
  if (simulation == nullptr) return false;
  const Status loaded = simulation->load({});
  return loaded || loaded.error().code != ErrorCode::unsupported;
}

void describe_lanes(const WalkContext& context, Simulation& simulation, ByteView expected, ByteView got,
                    Divergence& divergence, Findings& findings) {
  const Status located = locate_lanes(context.setup.schema, expected, got, names_of(simulation),
                                      context.options.row_count_max, divergence);
  if (!located) findings.warn_unreadable(divergence.tick, located.error());
}

Divergence describe_mismatch(const WalkContext& context, Simulation& simulation, const StoredTick& expected,
                             double time_s, const TickSide& got, Findings& findings) {
  Divergence divergence;
  divergence.tick = expected.tick;
  divergence.time_s = time_s;
  divergence.inputs = simulation.inputs_text(expected.tick, expected.inputs);
  const DescribeContext describe{context.setup.schema, context.setup.stages, names_of(simulation),
                                 context.options.row_count_max};
  if (const Status described = describe_tick(describe, side_of(expected), got, divergence); !described)
    findings.warn_unreadable(divergence.tick, described.error());
  return divergence;
}

void ChangeWatch::begin(const StateView& state) {
  first_.clear();
  for (std::size_t t = 0; t < state.tables.size(); ++t)
    first_.emplace_back(state.tables[t].data, state.tables[t].data + table_size(state, t));
  changed_ = false;
}

void ChangeWatch::update(const StateView& state) {
  for (std::size_t t = 0; t < state.tables.size() && !changed_; ++t) {
    if (!is_watched(*state.schema, t)) continue;
    const std::size_t size = table_size(state, t);
    changed_ = size != first_[t].size() || (size > 0 && std::memcmp(first_[t].data(), state.tables[t].data, size) != 0);
  }
}

WalkResult walk(const WalkContext& context, TraceSource& source, const Segment& segment) {
  return SegmentWalk(context, source, segment).run();
}

}  // namespace ticktrue::verifier
