// The verify run: walk through the trace, compare, and on a mismatch locate it and run again to judge it.
// SPDX-License-Identifier: MIT
#include "verifier/verify.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "base/float_behaviour.h"
#include "base/hash.h"
#include "verifier/locate.h"
#include "verifier/schema_difference.h"

namespace ticktrue::verifier {
namespace {

using replay::CheckpointRecord;
using replay::TickRecord;
using replay::TraceCondition;

/// Where a run begins: the state made from the setup (tick 0, not loaded), or a checkpoint that was loaded.
struct Start {
  std::uint64_t tick = 0;
  double time_s = 0;
  bool loaded = false;
  Bytes image;  // where loaded
  std::uint64_t root_hash = 0;
};

/// A tick as recorded, kept beyond the reader's next step.
struct KeptTick {
  std::uint64_t tick = 0;
  double dt = 0;
  Bytes inputs;
  std::uint64_t root_hash = 0;
  std::vector<std::uint64_t> stage_hashes;
  std::optional<Bytes> image;
};

KeptTick keep(const TickRecord& record) {
  KeptTick kept{record.tick,      record.dt,           Bytes(record.inputs.begin(), record.inputs.end()),
                record.root_hash, record.stage_hashes, std::nullopt};
  if (record.image) kept.image = Bytes(record.image->begin(), record.image->end());
  return kept;
}

/// Whether any state but that of the table `world` (its tick and time always change) was ever seen to change.
class ChangeWatch {
 public:
  void begin(const StateView& state) {
    first_ = copy(state);
    changed_ = false;
  }
  void look(const StateView& state) {
    if (changed_) return;
    for (std::size_t t = 0; t < state.tables.size() && !changed_; ++t) {
      if (!watched(*state.schema, t)) continue;
      const std::size_t size = static_cast<std::size_t>(state.tables[t].row_count) * state.schema->tables[t].row_size;
      changed_ =
          size != first_[t].size() || (size > 0 && std::memcmp(first_[t].data(), state.tables[t].data, size) != 0);
    }
  }
  bool changed() const { return changed_; }

 private:
  static bool watched(const StateSchema& schema, std::size_t table) {
    return schema.tables.size() == 1 || schema.tables[table].name != "world";
  }
  static std::vector<Bytes> copy(const StateView& state) {
    std::vector<Bytes> tables;
    for (std::size_t t = 0; t < state.tables.size(); ++t) {
      const std::size_t size = static_cast<std::size_t>(state.tables[t].row_count) * state.schema->tables[t].row_size;
      tables.emplace_back(state.tables[t].data, state.tables[t].data + size);
    }
    return tables;
  }
  std::vector<Bytes> first_;
  bool changed_ = false;
};

/// A place in the words of the recorder's note on a value that is not finite.
std::string place_text(const Simulation& simulation, const StatePlace& place) {
  const TableSchema& table = simulation.state().schema->tables[place.table];
  const std::string name = simulation.row_name(place.table, place.row);
  return table.name + " row " + std::to_string(place.row) + (name.empty() ? "" : " (" + name + ")") + ", column " +
         table.columns[place.column].name + ", lane " + std::to_string(place.lane);
}

std::string count_text(std::uint64_t count, const char* noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// What differs between two schemas, in words; empty if nothing does.
std::string schema_difference(const StateSchema& recorded, const StateSchema& here) {
  const auto difference = first_schema_difference(recorded, here);
  if (!difference) return "";
  return "schema: " + difference->place + ": recorded " + difference->a + ", here " + difference->b;
}

std::string stage_difference(std::span<const std::string> recorded, std::span<const std::string> here) {
  if (std::equal(recorded.begin(), recorded.end(), here.begin(), here.end())) return "";
  const auto list = [](std::span<const std::string> names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
  };
  return "stages: recorded " + list(recorded) + "; here " + list(here);
}

class Verifier {
 public:
  Verifier(TraceSource& source, const VerifyOptions& options)
      : source_(source), setup_(source.setup()), options_(options), last_dt_(setup_.dt) {}

  Report run() {
    report_.title = setup_.title;
    report_.simulation = setup_.simulation;
    for (const VerifyModeInfo& info : verify_modes)
      if (info.mode == options_.mode) report_.mode = info.name;
    report_.ticks_recorded = source_.tick_count_hint();
    report_.first_tick = options_.from;
    if (is_available()) {
      switch (options_.mode) {
        case VerifyMode::replay:
          run_replay();
          break;
        case VerifyMode::restore:
          run_restore();
          break;
        case VerifyMode::twice:
          run_twice();
          break;
      }
    }
    judge();
    return std::move(report_);
  }

 private:
  enum class Walk { end_of_trace, reached_last, at_checkpoint, stopped };

  void not_comparable(const std::string& reason, const std::string& hint = "") {
    report_.verdict = Verdict::not_comparable;
    report_.reason = reason;
    report_.hint = hint;
    decided_ = true;
  }

  bool is_available() {
    if (const Status floats = check_float_behaviour(); !floats) {
      not_comparable(floats.error().message, floats.error().hint);
      return false;
    }
    const SimulationInfo* info = options_.simulation;
    if (info == nullptr || info->name != setup_.simulation) {
      not_comparable("simulation " + setup_.simulation + " is not available in this build");
      return false;
    }
    if (info->physics_version != setup_.physics_version) {
      const std::string text = "physics version: recorded with " + std::to_string(setup_.physics_version) + ", here " +
                               std::to_string(info->physics_version);
      if (options_.mode != VerifyMode::twice) {
        not_comparable(text, "build the version that recorded it, or record again");
        return false;
      }
      report_.warnings.push_back(text);
    }
    const auto simulation = make();
    if (!simulation) return false;
    for (const std::string& text : {schema_difference(setup_.schema, *simulation->state().schema),
                                    stage_difference(setup_.stages, simulation->stage_names())}) {
      if (text.empty()) continue;
      if (options_.mode != VerifyMode::twice) {
        not_comparable(text, "build the version that recorded it, or record again");
        return false;
      }
      report_.warnings.push_back(text);
    }
    return true;
  }

  /// A fresh simulation from the setup; null where the setup is refused (then the report says so).
  std::unique_ptr<Simulation> make() {
    Result<std::unique_ptr<Simulation>> made = options_.simulation->make(setup_.setup);
    if (made) return std::move(*made);
    not_comparable("setup refused here: " + made.error().message, made.error().hint);
    return nullptr;
  }

  /// A simulation in the state of `start`; null where that is refused (then the report says so).
  std::unique_ptr<Simulation> begin(const Start& start) {
    std::unique_ptr<Simulation> simulation = make();
    if (simulation == nullptr) return nullptr;
    if (start.loaded) {
      if (const Status loaded = simulation->load(start.image); !loaded) {
        if (loaded.error().code == ErrorCode::unsupported) {
          not_comparable("the state of " + setup_.simulation + " can only be observed, not loaded",
                         "use --mode replay without --from");
          return nullptr;
        }
        report_.verdict = Verdict::diverged;
        report_.reason = "checkpoint at tick " + std::to_string(start.tick) + " is refused: " + loaded.error().message;
        Divergence divergence;
        divergence.tick = start.tick;
        divergence.time_s = start.time_s;
        divergence.stage = stage_load;
        divergence.stage_note = "the checkpoint is intact, but this build does not load it";
        divergence.expected_root = start.root_hash;
        report_.divergence = std::move(divergence);
        decided_ = true;
        return nullptr;
      }
    }
    if (options_.wrap) simulation = options_.wrap(std::move(simulation), start.tick);
    return simulation;
  }

  bool can_load() {
    // A simulation that cannot load says so for any image; others refuse the empty one without effect.
    const std::unique_ptr<Simulation> simulation = make();
    if (simulation == nullptr) return false;
    const Status loaded = simulation->load({});
    return loaded || loaded.error().code != ErrorCode::unsupported;
  }

  /// The last checkpoint at or before `tick`, with the source standing just behind it; else the setup's state, with the
  /// source at its start.
  Start find_start(std::uint64_t tick) {
    Start start;
    if (tick > 0 && can_load() && source_.seek(tick)) {
      if (const auto* checkpoint = std::get_if<CheckpointRecord>(&source_.next());
          checkpoint != nullptr && checkpoint->tick > 0) {
        const std::uint64_t found = checkpoint->tick;
        // Ticks may have different dt: the time of the checkpoint is known only by adding them up.
        source_.rewind();
        for (;;) {
          const auto& item = source_.next();
          if (const auto* record = std::get_if<TickRecord>(&item)) start.time_s += record->dt;
          const auto* again = std::get_if<CheckpointRecord>(&item);
          if (again != nullptr && again->tick == found) {
            start = from_checkpoint(*again, start.time_s);
            return start;
          }
          if (std::holds_alternative<std::monostate>(item)) break;
        }
      }
    }
    source_.rewind();
    return Start{};
  }

  static Start from_checkpoint(const CheckpointRecord& checkpoint, double time_s) {
    return {checkpoint.tick, time_s, true, Bytes(checkpoint.image.begin(), checkpoint.image.end()),
            checkpoint.root_hash};
  }

  /// Puts the source just behind the start's checkpoint, or to its beginning.
  void return_to(const Start& start) {
    if (!start.loaded) {
      source_.rewind();
      return;
    }
    if (source_.seek(start.tick)) source_.next();
  }

  void set_position(const Start& start) {
    start_ = start;
    tick_ = start.tick;
    time_s_ = start.time_s;
  }

  /// Whether the loaded state shows itself as it was loaded.
  bool check_loaded(Simulation& simulation) {
    if (!start_.loaded) return true;
    return check_image_against(simulation, start_.root_hash, start_.image, stage_load,
                               "the state after loading the checkpoint is not the checkpoint's");
  }

  /// Compares the present state with a checkpoint. False: reported.
  bool check_image_against(Simulation& simulation, std::uint64_t expected_root, ByteView expected,
                           std::string_view stage, const char* note) {
    const std::uint64_t got_root = root_hash(simulation.state());
    encode_image(simulation.state(), image_);
    ++report_.checkpoints_compared;
    if (got_root == expected_root && std::equal(expected.begin(), expected.end(), image_.begin(), image_.end()))
      return true;
    Divergence divergence;
    divergence.tick = tick_;
    divergence.time_s = time_s_;
    divergence.stage = std::string(stage);
    divergence.stage_note = note;
    divergence.expected_root = expected_root;
    divergence.got_root = got_root;
    const Bytes expected_copy(expected.begin(), expected.end());
    const Bytes got = image_;
    fill_lanes(simulation, expected_copy, got, divergence);
    report_.divergence = std::move(divergence);
    report_.verdict = Verdict::diverged;
    decided_ = true;
    // The same twice? Then it is the build; else chance.
    if (tick_ == start_.tick)
      if (const std::unique_ptr<Simulation> again = begin(start_)) {
        encode_image(again->state(), image_);
        if (image_ != got) not_reproducible("two simulations made here begin with different states");
      }
    return false;
  }

  void not_reproducible(const std::string& reason) {
    report_.verdict = Verdict::not_reproducible;
    report_.reason = reason;
    report_.hint = "look for uninitialised memory, addresses, clocks, threads or random numbers in the simulation";
  }

  void fill_lanes(Simulation& simulation, ByteView expected, ByteView got, Divergence& divergence) {
    const Status located = locate_lanes(
        setup_.schema, expected, got,
        [&](std::size_t table, std::size_t row) { return simulation.row_name(table, row); }, options_.row_count_max,
        divergence);
    if (!located)
      report_.warnings.push_back("stored state of tick " + std::to_string(divergence.tick) +
                                 " cannot be read: " + located.error().message);
  }

  /// Steps through the source and compares, from start_ on.
  Walk walk(Simulation& simulation, bool stop_at_checkpoint) {
    for (;;) {
      if (options_.to && tick_ > *options_.to) return Walk::reached_last;
      const replay::TraceReader::Item& item = source_.next();
      if (std::holds_alternative<std::monostate>(item)) return Walk::end_of_trace;
      if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item)) {
        if (checkpoint->tick != tick_ || (start_.loaded && tick_ == start_.tick)) continue;
        const bool at_start = tick_ == 0;
        if (!check_image_against(simulation, checkpoint->root_hash, checkpoint->image,
                                 at_start ? stage_setup : std::string_view("checkpoint"),
                                 at_start ? "the state made from the setup is not the recorded one"
                                          : "the hash of the tick before agrees, the checkpoint does not"))
          return Walk::stopped;
        if (stop_at_checkpoint) {
          next_start_ = from_checkpoint(*checkpoint, time_s_);
          return Walk::at_checkpoint;
        }
        continue;
      }
      const TickRecord& record = std::get<TickRecord>(item);
      const TickInput input{record.dt, record.inputs};
      last_dt_ = record.dt;
      if (!accepts(simulation, input)) return Walk::stopped;
      simulation.step(input, nullptr);
      const std::uint64_t got = root_hash(simulation.state());
      bool equal = got == record.root_hash;
      if (equal && record.image) {
        encode_image(simulation.state(), image_);
        equal = std::equal(record.image->begin(), record.image->end(), image_.begin(), image_.end());
      }
      if (!equal) {
        count_tick();
        diverge(simulation, record, got);
        return Walk::stopped;
      }
      report_.root_hash = got;
      watch_.look(simulation.state());
      time_s_ += record.dt;
      count_tick();
      ++tick_;
      if (options_.progress) options_.progress(tick_);
    }
  }

  void count_tick() {
    if (counting_ && tick_ >= options_.from) ++report_.ticks_compared;
    report_.time_s = time_s_;
  }

  bool accepts(Simulation& simulation, const TickInput& input) {
    const Status accepted = simulation.accept(input);
    if (accepted) return true;
    not_comparable("tick " + std::to_string(tick_) + ": recorded inputs are refused here: " + accepted.error().message,
                   "the bytes are intact: this build takes other inputs than the one that recorded them");
    return false;
  }

  /// A mismatch at tick_: locate it, then run again to tell a difference between builds from chance.
  void diverge(Simulation& simulation, const TickRecord& record, std::uint64_t got_root) {
    decided_ = true;
    report_.verdict = Verdict::diverged;
    KeptTick expected = keep(record);
    Bytes got;
    encode_image(simulation.state(), got);
    const replay::TraceReader::Item& item = source_.next();
    if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item);
        checkpoint != nullptr && checkpoint->tick == tick_ + 1 && !expected.image)
      expected.image = Bytes(checkpoint->image.begin(), checkpoint->image.end());
    if (std::holds_alternative<std::monostate>(item)) {
      take_tail();
    } else if (!options_.to) {
      drain();
    }

    Divergence divergence = describe(simulation, expected, got, got_root);
    if (const auto place = find_non_finite(simulation.state()))
      report_.notes.push_back("the state here is not finite: " + place_text(simulation, *place));

    const Rerun rerun = run_again(expected, got);
    if (rerun.done && !rerun.stage_hashes.empty() && !expected.stage_hashes.empty())
      locate_stage(setup_.stages, expected.stage_hashes, rerun.stage_hashes, divergence);
    if (rerun.differs_at) {
      if (*rerun.differs_at < tick_) {
        divergence = *rerun.divergence;
      } else if (divergence.tables.empty() && rerun.done) {
        fill_lanes(simulation, got, rerun.image, divergence);
        report_.notes.push_back("columns and values are those of two runs here");
      }
      divergence.stage.reset();
      divergence.stage_note = "not looked for: two runs here differ";
      not_reproducible("two runs here differ from tick " + std::to_string(*rerun.differs_at) + " on");
    }
    report_.divergence = std::move(divergence);
  }

  Divergence describe(Simulation& simulation, const KeptTick& expected, ByteView got, std::uint64_t got_root) {
    Divergence divergence;
    divergence.tick = tick_;
    divergence.time_s = time_s_;
    divergence.expected_root = expected.root_hash;
    divergence.got_root = got_root;
    divergence.inputs = simulation.inputs_text(expected.tick, expected.inputs);
    divergence.stage_note = "not known: the trace stores no hash after each stage of this tick";
    if (expected.image) fill_lanes(simulation, *expected.image, got, divergence);
    return divergence;
  }

  struct Rerun {
    bool done = false;
    std::optional<std::uint64_t> differs_at;
    std::optional<Divergence> divergence;  // where the second run left the recorded one before the first did
    std::vector<std::uint64_t> stage_hashes;
    Bytes image;  // at the tick of the divergence
  };

  /// Runs from start_ to the end of the tick of `expected` once more. The first run agreed with the recorded hashes of
  /// every tick before it and ended in the state `got`.
  Rerun run_again(const KeptTick& expected, const Bytes& got) {
    Rerun rerun;
    return_to(start_);
    const std::uint64_t first_run_tick = tick_;
    const double first_run_time_s = time_s_;
    const std::unique_ptr<Simulation> simulation = begin(start_);
    if (simulation == nullptr) return rerun;
    tick_ = start_.tick;
    time_s_ = start_.time_s;
    while (tick_ < expected.tick) {
      const replay::TraceReader::Item& item = source_.next();
      if (std::holds_alternative<std::monostate>(item)) break;
      const auto* record = std::get_if<TickRecord>(&item);
      if (record == nullptr) continue;
      const TickInput input{record->dt, record->inputs};
      if (!simulation->accept(input)) {
        rerun.differs_at = tick_;
        break;
      }
      simulation->step(input, nullptr);
      const std::uint64_t root = root_hash(simulation->state());
      if (root != record->root_hash) {
        rerun.differs_at = tick_;
        const KeptTick kept = keep(*record);
        encode_image(simulation->state(), rerun.image);
        rerun.divergence = describe(*simulation, kept, rerun.image, root);
        break;
      }
      time_s_ += record->dt;
      ++tick_;
      if (options_.progress) options_.progress(tick_);
    }
    if (!rerun.differs_at && tick_ == expected.tick) {
      const TickInput input{expected.dt, expected.inputs};
      if (!simulation->accept(input)) {
        rerun.differs_at = tick_;
      } else {
        StageHashes stages;
        simulation->step(input, expected.stage_hashes.empty() ? nullptr : &stages);
        rerun.stage_hashes = stages.hashes();
        encode_image(simulation->state(), rerun.image);
        if (rerun.image != got) rerun.differs_at = tick_;
        rerun.done = true;
      }
    }
    if (rerun.differs_at && !rerun.divergence && *rerun.differs_at != first_run_tick) {
      Divergence divergence;
      divergence.tick = *rerun.differs_at;
      divergence.time_s = time_s_;
      rerun.divergence = std::move(divergence);
    }
    tick_ = first_run_tick;
    time_s_ = first_run_time_s;
    return rerun;
  }

  void drain() {
    while (!std::holds_alternative<std::monostate>(source_.next())) {
    }
    take_tail();
  }

  void take_tail() {
    if (report_.end) return;
    report_.end = TraceEnd{source_.tail(), ""};
  }

  void run_replay() {
    set_position(find_start(options_.from));
    const std::unique_ptr<Simulation> simulation = begin(start_);
    if (simulation == nullptr || !check_loaded(*simulation)) return;
    watch_.begin(simulation->state());
    finish_walk(walk(*simulation, false), *simulation);
  }

  void run_restore() {
    // The start of the whole is a checkpoint too: the one at tick 0 is loaded, not made.
    Start start = find_start(options_.from);
    if (!start.loaded) {
      const auto* checkpoint = std::get_if<CheckpointRecord>(&source_.next());
      if (checkpoint == nullptr) {
        report_.reason = "no checkpoint could be read";
        drain();
        return;
      }
      start = from_checkpoint(*checkpoint, 0);
    }
    std::vector<Start> later;  // to_end: checkpoints behind the first, without their images
    bool first = true;
    for (;;) {
      set_position(start);
      const std::unique_ptr<Simulation> simulation = begin(start_);
      if (simulation == nullptr || !check_loaded(*simulation)) return;
      if (first) watch_.begin(simulation->state());
      first = false;
      const Walk ended = walk(*simulation, true);
      if (ended != Walk::at_checkpoint) {
        finish_walk(ended, *simulation);
        break;
      }
      start = std::move(next_start_);
      if (options_.to_end) later.push_back({start.tick, start.time_s, true, {}, start.root_hash});
    }
    counting_ = false;  // each tick counts once
    for (std::size_t i = 0; i < later.size() && !decided_; ++i) {
      if (!source_.seek(later[i].tick)) break;
      const auto* checkpoint = std::get_if<CheckpointRecord>(&source_.next());
      if (checkpoint == nullptr || checkpoint->tick != later[i].tick) break;
      set_position(from_checkpoint(*checkpoint, later[i].time_s));
      const std::unique_ptr<Simulation> simulation = begin(start_);
      if (simulation == nullptr || !check_loaded(*simulation)) return;
      walk(*simulation, false);
    }
  }

  void run_twice() {
    set_position(find_start(0));
    const std::unique_ptr<Simulation> first = begin(start_);
    if (first == nullptr) return;
    const std::unique_ptr<Simulation> second = begin(start_);
    if (second == nullptr) return;
    watch_.begin(first->state());
    report_.notes.push_back("two runs here were compared with each other, not with the recorded hashes");
    if (!same_states(*first, *second, stage_setup, "two simulations made here begin with different states", {})) return;
    for (;;) {
      if (options_.to && tick_ > *options_.to) return;
      const replay::TraceReader::Item& item = source_.next();
      if (std::holds_alternative<std::monostate>(item)) break;
      const auto* record = std::get_if<TickRecord>(&item);
      if (record == nullptr) continue;
      const TickInput input{record->dt, record->inputs};
      if (!accepts(*first, input)) return;
      if (!second->accept(input)) {
        not_reproducible("tick " + std::to_string(tick_) + ": inputs one run takes are refused by the other");
        decided_ = true;
        return;
      }
      first->step(input, nullptr);
      second->step(input, nullptr);
      const Bytes inputs(record->inputs.begin(), record->inputs.end());
      const double dt = record->dt;
      count_tick();
      if (!same_states(*first, *second, "", "not looked for: two runs here differ", inputs)) return;
      watch_.look(first->state());
      time_s_ += dt;
      report_.time_s = time_s_;
      ++tick_;
      if (options_.progress) options_.progress(tick_);
    }
    take_tail();
  }

  bool same_states(Simulation& first, Simulation& second, std::string_view stage, const char* note,
                   const Bytes& inputs) {
    const std::uint64_t a = root_hash(first.state());
    const std::uint64_t b = root_hash(second.state());
    report_.root_hash = a;
    if (a == b) return true;
    Divergence divergence;
    divergence.tick = tick_;
    divergence.time_s = time_s_;
    if (!stage.empty()) divergence.stage = std::string(stage);
    divergence.stage_note = note;
    divergence.expected_root = a;
    divergence.got_root = b;
    divergence.inputs = first.inputs_text(tick_, inputs);
    Bytes image_a, image_b;
    encode_image(first.state(), image_a);
    encode_image(second.state(), image_b);
    if (setup_.schema == *first.state().schema) fill_lanes(second, image_a, image_b, divergence);
    not_reproducible("two runs here differ from tick " + std::to_string(tick_) + " on");
    report_.divergence = std::move(divergence);
    decided_ = true;
    if (!options_.to) drain();
    return false;
  }

  void finish_walk(Walk ended, Simulation& simulation) {
    if (ended == Walk::end_of_trace) {
      take_tail();
      TraceEnd& end = *report_.end;
      if (end.tail.has_pending_inputs)
        end.pending_inputs = simulation.inputs_text(end.tail.ticks_intact, end.tail.pending_inputs);
      if (end.tail.condition == TraceCondition::complete && end.tail.end &&
          end.tail.end->reason == replay::EndReason::non_finite)
        check_non_finite_end(simulation, end.tail);
    } else if (ended == Walk::stopped && !options_.to && !report_.end) {
      drain();
    }
  }

  /// A recording closed because the next tick gave a NaN or an infinity: the same must happen here, at the same place.
  void check_non_finite_end(Simulation& simulation, const replay::TraceTail& tail) {
    // A tick without inputs and with the dt of the tick before leaves nothing behind.
    const TickInput input =
        tail.has_pending_inputs ? TickInput{tail.pending_dt, tail.pending_inputs} : TickInput{last_dt_, {}};
    if (!accepts(simulation, input)) return;
    simulation.step(input, nullptr);
    const auto place = find_non_finite(simulation.state());
    const std::string here = place ? place_text(simulation, *place) : "";
    // The recorder's note ends with the place it found.
    if (place && (tail.end->note.empty() || tail.end->note.find(here) != std::string::npos)) {
      report_.notes.push_back("tick " + std::to_string(tick_) + " is not finite, as recorded: " + here);
      return;
    }
    decided_ = true;
    report_.verdict = Verdict::diverged;
    report_.reason = "tick " + std::to_string(tick_) + ": recorded as not finite (" + tail.end->note + "), here " +
                     (place ? "it is not finite at " + here : std::string("it is finite"));
    Divergence divergence;
    divergence.tick = tick_;
    divergence.time_s = time_s_;
    divergence.stage_note = "not known: a tick that is not finite is not stored";
    divergence.got_root = root_hash(simulation.state());
    divergence.inputs = simulation.inputs_text(tick_, tail.pending_inputs);
    if (place)
      divergence.tables.push_back(
          {setup_.schema.tables[place->table].name, {setup_.schema.tables[place->table].columns[place->column].name}});
    report_.divergence = std::move(divergence);
  }

  void judge() {
    if (!report_.end && !options_.to) drain();
    if (!report_.ticks_recorded && report_.end) report_.ticks_recorded = report_.end->tail.ticks_intact;
    if (decided_) return;
    const replay::TraceTail* tail = report_.end ? &report_.end->tail : nullptr;
    if (tail != nullptr && tail->condition == TraceCondition::damaged) {
      report_.verdict = Verdict::damaged;
      report_.reason = tail->message;
      if (report_.ticks_compared > 0)
        report_.hint = "ticks " + std::to_string(options_.from) + ".." + std::to_string(tick_ - 1) +
                       " are intact and match: verify them alone with --to " + std::to_string(tick_ - 1);
    } else if (tail != nullptr && tail->condition == TraceCondition::truncated) {
      report_.verdict = Verdict::incomplete;
      report_.reason = tail->message;
      if (report_.ticks_compared > 0)
        report_.hint =
            "every tick up to the cut matches: --allow-truncated accepts that; `ticktrue recover` makes a "
            "complete trace of it";
    } else if (report_.ticks_compared == 0) {
      report_.verdict = Verdict::incomplete;
      if (report_.reason.empty()) report_.reason = "no tick was compared";
    } else {
      report_.verdict = Verdict::match;
    }
    if (report_.ticks_compared > 0 && !watch_.changed())
      report_.warnings.push_back("no state outside table world changed in " +
                                 count_text(report_.ticks_compared, "tick") +
                                 ": does the simulation show all of its state?");
  }

  TraceSource& source_;
  const replay::TraceSetup& setup_;
  const VerifyOptions& options_;
  Report report_;
  bool decided_ = false;
  bool counting_ = true;
  Start start_;
  Start next_start_;
  std::uint64_t tick_ = 0;  // ticks done
  double time_s_ = 0;       // simulated, at tick_
  double last_dt_ = 0;      // s, of the tick that ran last
  ChangeWatch watch_;
  Bytes image_;  // reused
};

/// The commands that would tell more.
void suggest(const replay::TraceSetup& setup, const VerifyOptions& options, Report& report) {
  const std::string file = shell_word(report.file);
  if (report.verdict == Verdict::not_reproducible && options.mode != VerifyMode::twice)
    report.again.push_back("ticktrue verify " + file + " --mode twice");
  if (report.verdict == Verdict::incomplete && report.end &&
      report.end->tail.condition == replay::TraceCondition::truncated)
    report.again.push_back("ticktrue recover " + file + " -o WHOLE.ttr");
  if (report.verdict != Verdict::diverged || !report.divergence) return;
  const std::uint64_t tick = report.divergence->tick;
  const std::uint64_t interval = setup.checkpoint_interval;
  const std::uint64_t from = interval == 0 ? 0 : tick / interval * interval;
  report.again.push_back("ticktrue verify " + file + " --mode " + report.mode + " --from " + std::to_string(from) +
                         " --to " + std::to_string(tick));
  if (report.divergence->tables.empty())
    report.again.push_back("ticktrue record SCENE --detail full:" + std::to_string(tick) + ".." + std::to_string(tick) +
                           " -o OUT.ttr, with both builds; then ticktrue diff of the two names columns and values");
}

}  // namespace

Report verify_source(TraceSource& source, const VerifyOptions& options) {
  return Verifier(source, options).run();
}

Report verify(replay::TraceReader& reader, const VerifyOptions& options) {
  ReaderSource source(reader);
  reader.rewind();
  Report report = verify_source(source, options);
  report.file = reader.name();
  report.recorded_build = reader.facts();
  suggest(reader.setup(), options, report);
  return report;
}

Report open_error_report(const std::string& file, const Error& error) {
  Report report;
  report.file = file;
  report.verdict = verdict_of_open_error(error.code);
  report.reason = error.message;
  report.hint = error.hint;
  return report;
}

}  // namespace ticktrue::verifier
