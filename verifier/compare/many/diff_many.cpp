// Reads all traces tick by tick, and locates the first difference between the majority and each other group.
// SPDX-License-Identifier: MIT
#include "verifier/compare/many/diff_many.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "base/assert.h"
#include "verifier/compare/many/diff_many_verdict.h"
#include "verifier/compare/many/trace_facts.h"
#include "verifier/compare/trace_side.h"
#include "verifier/locate/compare_marks.h"
#include "verifier/locate/compare_tick.h"
#include "verifier/locate/locate_cells.h"
#include "verifier/peers/bundle.h"

namespace ticktrue::verifier {
namespace {

using replay::TickRecord;
using replay::TraceSetup;

/// One of the compared traces.
struct Client {
  std::size_t trace = 0;
  const TraceSetup* setup = nullptr;
  TraceSide side;
  const TickRecord* record = nullptr;  // the next tick; null: the trace has ended
  StoredTick differing;                // the first differing tick, if the trace has it
  ComparedParts stored;                // up to this tick
};

/// The shown values of a trace.
using Shown = std::pair<std::size_t, ByteView>;

bool equal_bytes(ByteView a, ByteView b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

bool stores(const TickSide& side, TickPart part) {
  switch (part) {
    case TickPart::root_hash:
      return true;
    case TickPart::stage_hashes:
      return !side.stage_hashes.empty();
    case TickPart::image:
      return side.image || side.tables;
    case TickPart::cells:
      return side.cells != nullptr;
  }
  return false;
}

/// One of the largest groups. The choice depends on the content, not on the order of the traces.
template <typename Key>
const TraceGroup& reference_group(const TraceGroups& groups, Key key_of) {
  const TraceGroup* best = &groups.groups.front();
  for (const TraceGroup& group : groups.groups)
    if (group.size() == best->size() && key_of(group.front()) < key_of(best->front())) best = &group;
  return *best;
}

class ManyDiffer {
 public:
  ManyDiffer(std::span<const OpenedTrace> traces, const DiffOptions& options)
      : traces_(traces),
        options_(options),
        comparable_(comparable_traces(traces)),
        schema_(setup_of(comparable_.front()).schema),
        comparer_(schema_) {
    const TraceSetup& setup = setup_of(comparable_.front());
    report_.simulation = setup.simulation;
    if (options.simulation != nullptr && options.simulation->name == setup.simulation)
      if (Result<std::unique_ptr<Simulation>> made = options.simulation->make(setup.setup))
        simulation_ = std::move(*made);
    inputs_.emplace(simulation_.get(), traces.size());
    clients_.reserve(comparable_.size());
    for (const std::size_t trace : comparable_)
      clients_.push_back({trace, &setup_of(trace), TraceSide(*traces[trace].reader), nullptr, {}, {}});
  }

  DiffManyReport run() {
    describe_traces();
    walk();
    finish();
    return std::move(report_);
  }

 private:
  const TraceSetup& setup_of(std::size_t trace) const { return traces_[trace].reader->setup(); }
  Client& client_of(std::size_t trace) {
    return *std::find_if(clients_.begin(), clients_.end(), [&](const Client& one) { return one.trace == trace; });
  }

  void describe_traces() {
    for (const OpenedTrace& opened : traces_) {
      ManyTrace trace;
      trace.side.file = opened.file;
      trace.error = opened.error;
      if (opened.reader != nullptr) {
        trace.side.build = opened.reader->facts();
        trace.first_tick = opened.reader->first_tick();
      }
      report_.traces.push_back(std::move(trace));
    }
    for (const std::size_t trace : comparable_) report_.traces[trace].is_compared = true;
    report_.setup = setup_facts(traces_, comparable_.front());
    report_.build = build_facts(traces_);
  }

  // --- tick by tick --------------------------------------------------------------------------------------------------

  void walk() {
    for (Client& client : clients_) client.record = client.side.advance();
    std::optional<std::uint64_t> tick = next_tick();
    if (!tick) return;
    time_s_ = time_before(*tick);
    compare_checkpoints(*tick);
    for (; tick; tick = next_tick()) {
      take_present(*tick);
      if (present_.size() > 1)
        compare_tick(*tick);
      else
        agreed_root_ = present_.front().record->root_hash;
      time_s_ += dt_of_most();
      for (const PresentTick& one : present_) {
        Client& client = client_of(one.trace);
        client.record = client.side.advance();
      }
      if (is_located_next_) locate();
      compare_checkpoints(*tick + 1);
      if (options_.progress) options_.progress(*tick + 1);
    }
  }

  std::optional<std::uint64_t> next_tick() const {
    std::optional<std::uint64_t> first;
    for (const Client& client : clients_)
      if (client.record != nullptr && (!first || client.record->tick < *first)) first = client.record->tick;
    return first;
  }

  double time_before(std::uint64_t tick) const {
    for (const Client& client : clients_)
      if (client.side.first_tick() == tick) return client.side.time_s();
    return 0;
  }

  void take_present(std::uint64_t tick) {
    present_.clear();
    for (const Client& client : clients_)
      if (client.record != nullptr && client.record->tick == tick) present_.push_back({client.trace, client.record});
  }

  /// The dt of the majority in the present tick. It does not depend on the order of the traces.
  double dt_of_most() const {
    const auto count_of = [&](double dt) {
      return std::count_if(present_.begin(), present_.end(),
                           [&](const PresentTick& one) { return bits_of(one.record->dt) == bits_of(dt); });
    };
    double best = present_.front().record->dt;
    for (const PresentTick& one : present_) {
      const auto more = count_of(one.record->dt) - count_of(best);
      if (more > 0 || (more == 0 && one.record->dt < best)) best = one.record->dt;
    }
    return best;
  }

  void compare_tick(std::uint64_t tick) {
    same_inputs_ = inputs_->compare(tick, present_) && same_inputs_;
    compare_marks(tick);
    std::vector<Shown> shown;
    for (const PresentTick& one : present_)
      if (one.record->shown) shown.push_back({one.trace, *one.record->shown});
    compare_shown("after tick " + std::to_string(tick), shown);
    ++report_.ticks_compared;
    if (report_.state)
      note_odd_states(tick);
    else
      compare_states(tick);
  }

  /// Hashes after the stages are compared if all traces have the same stages.
  TickSide stored_side(const TickRecord& record) const {
    TickSide side = side_of(record);
    if (!same_stages()) side.stage_hashes = {};
    return side;
  }
  bool same_stages() const {
    return std::all_of(clients_.begin(), clients_.end(),
                       [&](const Client& one) { return one.setup->stages == clients_.front().setup->stages; });
  }

  void compare_states(std::uint64_t tick) {
    std::vector<TickSide> sides;
    for (const PresentTick& one : present_) {
      count_parts(*one.record, client_of(one.trace).stored);
      sides.push_back(stored_side(*one.record));
    }
    const auto difference = comparer_.compare(sides);
    if (difference && difference->part == TickPart::root_hash) {
      begin_finding(tick);
      return;
    }
    agreed_root_ = present_.front().record->root_hash;
    if (difference) note_contradiction(tick, difference->part, sides);
  }

  TraceGroups groups_by_root() const {
    TraceGroup traces;
    std::vector<std::uint64_t> roots(traces_.size());
    for (const PresentTick& one : present_) {
      traces.push_back(one.trace);
      roots[one.trace] = one.record->root_hash;
    }
    return group_traces(traces, [&](std::size_t i, std::size_t j) { return roots[i] == roots[j]; });
  }

  void note_odd_states(std::uint64_t tick) {
    for (const std::size_t trace : groups_by_root().odd()) note_odd_state(trace, tick);
  }
  void note_odd_state(std::size_t trace, std::uint64_t tick) {
    std::optional<std::uint64_t>& from = report_.traces[trace].state_from;
    if (!from) from = tick;
  }

  /// Notes that the root hashes agree and another part differs, once for each part. The comparison of roots continues.
  void note_contradiction(std::uint64_t tick, TickPart part, const std::vector<TickSide>& sides) {
    bool& told = told_parts_[static_cast<std::size_t>(part)];
    if (std::exchange(told, true)) return;
    TraceGroup storing;
    for (std::size_t i = 0; i < sides.size(); ++i)
      if (stores(sides[i], part)) storing.push_back(i);
    TickComparer comparer(schema_);
    TraceGroups groups = group_traces(storing, [&](std::size_t i, std::size_t j) {
      const TickSide pair[] = {sides[i], sides[j]};
      const auto difference = comparer.compare(pair);
      return !difference || difference->part != part;
    });
    for (TraceGroup& group : groups.groups)
      for (std::size_t& place : group) place = present_[place].trace;
    groups.put_in_order();
    report_.contradictions.push_back(contradiction_text(tick, part) + " (" + who_text(groups) + ")");
  }

  // --- no effect on the result --------------------------------------------------------------------------------------

  /// Reports the first difference of marks.
  void compare_marks(std::uint64_t tick) {
    if (told_marks_) return;
    std::vector<const TickRecord*> records(traces_.size());
    TraceGroup traces;
    for (const PresentTick& one : present_)
      if (setup_of(one.trace).has(replay::Feature::marks) && one.record->has_bound) {
        traces.push_back(one.trace);
        records[one.trace] = one.record;
      }
    const auto difference_of = [&](std::size_t i, std::size_t j) {
      const auto marks_of = [&](std::size_t trace) {
        return records[trace]->marks ? &*records[trace]->marks : nullptr;
      };
      return verifier::compare_marks(tick, marks_of(i), marks_of(j));
    };
    const TraceGroups groups = group_traces(traces, [&](std::size_t i, std::size_t j) { return !difference_of(i, j); });
    for (std::size_t g = 1; g < groups.groups.size(); ++g) {
      told_marks_ = true;
      const auto difference = difference_of(groups.groups[0].front(), groups.groups[g].front());
      if (!difference) continue;
      report_.notes.push_back(
          "marks differ first in tick " + std::to_string(tick) + " (" + labels_text(groups.groups[g]) + " " +
          marks_text(*difference, labels_text(groups.groups[0]).c_str()) + "): no verdict depends on them");
    }
  }

  /// Reports the first difference of shown values.
  void compare_shown(const std::string& when, const std::vector<Shown>& shown) {
    if (told_shown_ || shown.size() < 2) return;
    TraceGroup places;
    for (std::size_t i = 0; i < shown.size(); ++i) places.push_back(i);
    TraceGroups groups = group_traces(
        places, [&](std::size_t i, std::size_t j) { return equal_bytes(shown[i].second, shown[j].second); });
    if (groups.groups.size() < 2) return;
    for (TraceGroup& group : groups.groups)
      for (std::size_t& place : group) place = shown[place].first;
    told_shown_ = true;
    report_.notes.push_back("shown values differ first " + when + " (" + who_text(groups) +
                            "): no verdict depends on them");
  }

  // --- checkpoints --------------------------------------------------------------------------------------------------

  /// Whether the checkpoint stores a state with this hash.
  bool holds(const StoredCheckpoint& checkpoint, std::uint64_t root) const {
    return checkpoint.root_hash == root && holds(checkpoint.image, root);
  }
  bool holds(ByteView image, std::uint64_t root) const {
    const Result<ImageState> state = ImageState::of(schema_, image);
    return state && root_hash(state->view()) == root;
  }

  /// Compares the checkpoints after this number of ticks: before the first tick with each other, later with the hash of
  /// the tick before.
  void compare_checkpoints(std::uint64_t ticks_done) {
    if (report_.state) return;
    TraceGroup with;
    for (const Client& client : clients_)
      if (client.side.checkpoint_at(ticks_done) != nullptr) with.push_back(client.trace);
    if (with.size() > 1) ++report_.checkpoints_compared;
    std::vector<Shown> shown;
    for (const std::size_t trace : with)
      if (const auto& stored = client_of(trace).side.checkpoint_at(ticks_done)->shown)
        shown.push_back({trace, *stored});
    compare_shown("before tick " + std::to_string(ticks_done), shown);
    if (!agreed_root_) {
      compare_starts(ticks_done, with);
      return;
    }
    TraceGroup contradicting;
    for (const std::size_t trace : with) {
      const TraceSide& side = client_of(trace).side;
      // If a trace begins late, the tick after its first checkpoint shows a difference.
      if (side.first_tick() == ticks_done || holds(*side.checkpoint_at(ticks_done), *agreed_root_)) continue;
      contradicting.push_back(trace);
    }
    if (contradicting.empty() || std::exchange(told_checkpoint_, true)) return;
    report_.contradictions.push_back("the checkpoint before tick " + std::to_string(ticks_done) + " of " +
                                     labels_text(contradicting) +
                                     " is not the state of the tick before: the record contradicts itself");
  }

  void compare_starts(std::uint64_t ticks_done, const TraceGroup& with) {
    if (with.size() < 2) return;
    TickComparer comparer(schema_);
    const auto side = [&](std::size_t trace) { return side_of(*client_of(trace).side.checkpoint_at(ticks_done)); };
    const TraceGroups who = group_traces(with, [&](std::size_t i, std::size_t j) {
      const TickSide pair[] = {side(i), side(j)};
      return !comparer.compare(pair);
    });
    if (who.groups.size() < 2) return;
    report_.state = StateFinding{ticks_done, true, who, {}, {}};
    report_.state->reference = reference_group(who, [&](std::size_t trace) { return side(trace).root_hash; });
    for (const std::size_t trace : who.odd()) note_odd_state(trace, ticks_done);
    for (const TraceGroup& group : who.groups) {
      if (group == report_.state->reference) continue;
      OddState odd{group, {}, {}};
      odd.divergence.tick = ticks_done;
      odd.divergence.time_s = time_s_;
      describe(side(report_.state->reference.front()), side(group.front()), context(), odd.divergence);
      odd.divergence.stage = std::string(stage_setup);
      odd.divergence.stage_note = "they begin with different states";
      report_.state->odd.push_back(std::move(odd));
    }
  }

  // --- the first tick that differs ----------------------------------------------------------------------------------

  void begin_finding(std::uint64_t tick) {
    report_.state = StateFinding{tick, false, groups_by_root(), {}, {}};
    for (const std::size_t trace : report_.state->who.odd()) note_odd_state(trace, tick);
    for (const PresentTick& one : present_) {
      Client& client = client_of(one.trace);
      client.differing = copy_of(*one.record);
      client.side.freeze_last();
    }
    inputs_text_ = same_inputs_ ? inputs_->lines(tick, present_.front().record->inputs) : "";
    divergence_time_s_ = time_s_;
    is_located_next_ = true;
  }

  DescribeContext context() const {
    DescribeContext context{schema_, clients_.front().setup->stages, {}, options_.row_count_max};
    context.no_stages = "not known: not both store a hash after each stage of this tick";
    return context;
  }

  void describe(const TickSide& reference, const TickSide& odd, const DescribeContext& context,
                Divergence& divergence) {
    if (const Status described = describe_tick(context, reference, odd, divergence); !described)
      report_.notes.push_back("a stored state cannot be read: " + described.error().message);
  }

  /// Uses the checkpoint after the tick as its state. An image without the right hash is ignored.
  void complete_image(Client& client, std::uint64_t tick) {
    StoredTick& stored = client.differing;
    if (const auto* checkpoint = client.side.checkpoint_at(tick + 1); checkpoint != nullptr && !stored.image)
      stored.image = checkpoint->image;
    if (!stored.image || holds(*stored.image, stored.root_hash)) return;
    report_.contradictions.push_back("tick " + std::to_string(tick) + ": " + trace_label(client.trace) +
                                     " stores a state that is not that of its hash: the record contradicts itself");
    stored.image.reset();
  }

  /// The data that the members of a group store of the tick. Cells with as many cells per partition as `like` are
  /// preferred.
  TickSide side_of_group(const TraceGroup& group, const StateCells* like) {
    TickSide side{client_of(group.front()).differing.root_hash};
    for (const std::size_t trace : group) {
      const StoredTick& stored = client_of(trace).differing;
      if (side.stage_hashes.empty() && same_stages()) side.stage_hashes = stored.stage_hashes;
      if (!side.image && stored.image) side.image = ByteView(*stored.image);
      if (!stored.cells) continue;
      const bool fits = like != nullptr && stored.cells->partition_cells == like->partition_cells;
      if (side.cells == nullptr || fits) side.cells = &*stored.cells;
    }
    return side;
  }

  /// Requires: the clients have passed the checkpoints with the states after the tick, if there are any.
  void locate() {
    is_located_next_ = false;
    StateFinding& finding = *report_.state;
    for (const TraceGroup& group : finding.who.groups)
      for (const std::size_t trace : group) complete_image(client_of(trace), finding.tick);
    finding.reference =
        reference_group(finding.who, [&](std::size_t trace) { return client_of(trace).differing.root_hash; });
    std::optional<ImageState> rows;
    const StoredCheckpoint* last = last_checkpoint();
    if (last != nullptr)
      if (Result<ImageState> state = ImageState::of(schema_, last->image)) rows.emplace(std::move(*state));
    for (const TraceGroup& group : finding.who.groups)
      if (group != finding.reference) locate_group(group, last, rows ? &rows->view() : nullptr);
    for (Client& client : clients_) client.differing = {};
  }

  void locate_group(const TraceGroup& group, const StoredCheckpoint* last, const StateView* rows) {
    StateFinding& finding = *report_.state;
    OddState odd{group, {}, {}};
    odd.divergence.tick = finding.tick;
    odd.divergence.time_s = divergence_time_s_;
    odd.divergence.inputs = inputs_text_;
    const TickSide got = side_of_group(group, nullptr);
    const TickSide expected = side_of_group(finding.reference, got.cells);
    DescribeContext with_rows = context();
    const bool by_cells = (!expected.image || !got.image) && expected.cells != nullptr && got.cells != nullptr;
    if (by_cells && rows != nullptr) {
      with_rows.rows = rows;
      if (simulation_ && simulation_->load(last->image))
        with_rows.row_name = [this](std::size_t table, std::size_t row) { return simulation_->row_name(table, row); };
      add_note("rows are those of the state stored before tick " + std::to_string(last->tick) +
               ": later ones cannot be named");
    }
    if (by_cells && expected.cells->partition_cells != got.cells->partition_cells)
      add_note("rows cannot be named: the traces have another number of cells for this tick");
    describe(expected, got, with_rows, odd.divergence);
    finding.odd.push_back(std::move(odd));
  }

  void add_note(const std::string& note) {
    if (std::find(report_.notes.begin(), report_.notes.end(), note) == report_.notes.end())
      report_.notes.push_back(note);
  }

  /// The last checkpoint before the difference: all traces have its state.
  const StoredCheckpoint* last_checkpoint() const {
    const StoredCheckpoint* last = nullptr;
    for (const Client& client : clients_)
      if (const auto& own = client.side.last(); own && own->tick <= report_.state->tick)
        if (last == nullptr || own->tick > last->tick) last = &*own;
    return last;
  }

  // --- the end ------------------------------------------------------------------------------------------------------

  void finish() {
    report_.compared = comparer_.take_compared();
    report_.inputs = inputs_->found();
    for (const Client& client : clients_) report_.traces[client.trace].inputs_from = inputs_->from(client.trace);
    for (std::size_t trace = 0; trace < traces_.size(); ++trace)
      if (traces_[trace].reader != nullptr) finish_trace(trace);
    if (!report_.state) note_not_compared();
    conclude_diff(traces_, comparable_, options_, report_);
  }

  void finish_trace(std::size_t trace) {
    DiffSide& out = report_.traces[trace].side;
    std::optional<TraceSide> unread;  // a trace that is not compared is read to its end here
    if (!report_.traces[trace].is_compared) {
      unread.emplace(*traces_[trace].reader);
      while (unread->advance() != nullptr) {
      }
    }
    const TraceSide& side = unread ? *unread : client_of(trace).side;
    out.ticks = side.ticks();
    out.end.tail = side.tail();
    if (!out.end.tail.peers.empty())
      add_note(out.file + " is a bundle of several players: " + players_text(out.end.tail.peers));
    if (out.end.tail.has_pending_inputs)
      out.end.pending_inputs = inputs_->lines(out.end.tail.ticks_intact, out.end.tail.pending_inputs);
  }

  /// Notes data that is stored for more ticks than it was compared in.
  void note_not_compared() {
    const ComparedParts& done = report_.compared;
    const auto note = [&](TickPart part, std::uint64_t ComparedParts::*count) {
      std::vector<std::string> values(traces_.size());
      bool is_more = false;
      for (const Client& client : clients_) {
        values[client.trace] = std::to_string(client.stored.*count);
        is_more = is_more || client.stored.*count > done.*count;
      }
      if (!is_more) return;
      std::string text;
      for (const FactValue& value : fact_of("", comparable_, values).values)
        text += (text.empty() ? "" : ".  ") + labels_text(value.traces) + " stored in " + value.value + " ticks";
      report_.notes.push_back(std::string(name_of(part)) + ": " + text + ".  compared in " +
                              std::to_string(done.*count));
    };
    note(TickPart::stage_hashes, &ComparedParts::stage_hashes);
    note(TickPart::image, &ComparedParts::images);
    note(TickPart::cells, &ComparedParts::cells);
  }

  std::span<const OpenedTrace> traces_;
  const DiffOptions& options_;
  TraceGroup comparable_;
  const StateSchema& schema_;
  TickComparer comparer_;
  std::unique_ptr<Simulation> simulation_;  // formats inputs and row names as text
  std::optional<InputComparer> inputs_;
  std::vector<Client> clients_;       // the compared traces
  std::vector<PresentTick> present_;  // the traces with the present tick
  DiffManyReport report_;
  double time_s_ = 0;                         // simulated time before the present tick
  std::optional<std::uint64_t> agreed_root_;  // of the previous tick; absent before the first tick
  bool same_inputs_ = true;                   // up to the present tick
  bool is_located_next_ = false;              // locate when the traces have passed the checkpoints after the tick
  std::string inputs_text_;                   // of the differing tick
  double divergence_time_s_ = 0;
  std::array<bool, tick_parts.size()> told_parts_ = {};
  bool told_marks_ = false;
  bool told_shown_ = false;
  bool told_checkpoint_ = false;
};

}  // namespace

int DiffManyReport::exit_code(bool allow_truncated) const {
  if (allow_truncated && verdict == DiffVerdict::incomplete && ticks_compared > 0) return exit_ok;
  return diff_verdict_info(verdict).exit_code;
}

DiffManyReport diff_many(std::span<const OpenedTrace> traces, const DiffOptions& options) {
  const auto is_open = [](const OpenedTrace& one) { return one.reader != nullptr; };
  TICKTRUE_ASSERT(std::count_if(traces.begin(), traces.end(), is_open) >= 2);
  return ManyDiffer(traces, options).run();
}

}  // namespace ticktrue::verifier
