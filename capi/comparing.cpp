// Compares a session with its trace.
// SPDX-License-Identifier: MIT
#include "capi/comparing.h"

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "base/count_text.h"
#include "base/limits.h"
#include "capi/program_facts.h"
#include "replay/format/shown_image.h"
#include "verifier/locate/compare_marks.h"
#include "verifier/locate/locate.h"
#include "verifier/locate/schema_difference.h"
#include "verifier/peers/bundle.h"

namespace ticktrue::capi {
namespace {

using verifier::Divergence;
using verifier::Verdict;

constexpr std::size_t lane_report_count_max = 64;
constexpr std::size_t input_bytes_shown_max = 256;
constexpr std::size_t shown_rows_max = 8;  // in a report

std::string inputs_json(std::uint64_t tick, ByteView inputs) {
  if (inputs.empty()) return "";
  static constexpr char digits[] = "0123456789abcdef";
  std::string text = "{\"tick\": " + std::to_string(tick) + ", \"bytes\": \"";
  for (const std::uint8_t byte : inputs.first(std::min(inputs.size(), input_bytes_shown_max))) {
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  if (inputs.size() > input_bytes_shown_max) text += "...";
  return text + "\"}\n";
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

/// Whether bits look like an address in user space of a 64-bit system, which is far above small numbers.
bool looks_like_address(std::uint64_t bits) {
  const std::uint64_t top = bits >> 40;
  return top == 0x55 || top == 0x56 || top == 0x7f || top == 0x7e;
}

/// "units.glow, units.sprite"
std::string shown_columns(const StateSchema& whole) {
  std::vector<std::string> names;
  for (const TableSchema& table : whole.tables)
    for (const Column& column : table.columns)
      if (column.is_shown) names.push_back(table.name + "." + column.name);
  return list_of(names);
}

/// "glow 0.5, sprite 3"; empty: nothing is shown of the row.
std::string shown_row(const StateSchema& whole, const Bytes* shown, const std::string& table, std::uint64_t row) {
  const std::optional<std::size_t> number = whole.find_table(table);
  if (shown == nullptr || !number) return "";
  const auto tables = replay::decode_shown(whole, *shown);
  if (!tables) return "not readable: " + tables.error().message;
  for (const ShownRows& rows : *tables)
    if (rows.table == *number && row < rows.rows.row_count)
      return replay::shown_row_text(whole.tables[*number], rows, static_cast<std::size_t>(row));
  return "";
}

}  // namespace

Comparing::Comparing(replay::TraceReader reader, std::string file, CompareRange range)
    : source_(std::move(reader)),
      comparer_(source_.setup().schema),
      range_(range),
      next_(source_.first_tick()),
      last_dt_(source_.setup().dt) {
  report_.file = std::move(file);
  report_.title = setup().title;
  report_.simulation = setup().simulation;
  report_.mode = "replay";
  report_.ticks_recorded = source_.tick_count_hint();
  if (report_.ticks_recorded) *report_.ticks_recorded -= std::min(source_.first_tick(), *report_.ticks_recorded);
  report_.first_tick = std::max(source_.first_tick(), range_.from);
  report_.recorded_build = source_.facts();
  if (std::string about = verifier::bundle_note(setup(), report_.file); !about.empty()) note(about);
}

void Comparing::not_comparable(const std::string& reason, const std::string& hint) {
  report_.verdict = Verdict::not_comparable;
  report_.reason = reason;
  report_.hint = hint;
  decided_ = true;
}

bool Comparing::check_identity(const Identity& identity) {
  if (setup().simulation != identity.name) {
    not_comparable("simulation: recorded with " + setup().simulation + ", this program is " + identity.name,
                   "verify it with the program that recorded it");
    return false;
  }
  if (setup().physics_version != identity.version) {
    not_comparable("version: recorded with " + std::to_string(setup().physics_version) + ", here " +
                       std::to_string(identity.version),
                   "build the version that recorded it, or record again");
    return false;
  }
  return true;
}

bool Comparing::seek(std::uint64_t tick) {
  if (!has_saves()) return false;
  for (std::uint64_t wanted = tick; source_.seek(wanted);) {
    const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&source_.next());
    if (checkpoint == nullptr) break;
    if (checkpoint->save) {
      begin_ = verifier::copy_of(*checkpoint);
      begin_save_.emplace(checkpoint->save->begin(), checkpoint->save->end());
      report_.time_s = checkpoint->time_s.value_or(0);
      ahead_.clear();
      at_end_ = false;
      report_.end.reset();
      next_ = begin_->tick;
      return true;
    }
    if (checkpoint->tick == 0) break;
    wanted = checkpoint->tick - 1;
  }
  // The position is unchanged: the records are read again.
  source_.rewind();
  ahead_.clear();
  at_end_ = false;
  return false;
}

bool Comparing::start(const StateView& state, const std::vector<std::string>& stages) {
  if (const auto difference =
          verifier::first_schema_difference(setup().schema, *state.schema, verifier::Ranges::inside)) {
    not_comparable(verifier::schema_text(*difference),
                   "the program registers other columns than the one that recorded: record again");
    return false;
  }
  if (setup().stages != stages) {
    not_comparable("stages: recorded " + list_of(setup().stages) + "; here " + list_of(stages), "record again");
    return false;
  }
  note_floats();
  return true;
}

bool Comparing::check_begin(const StateView& state, const RowNamer& row_name) {
  if (decided_) return false;
  first_root_ = root_hash(state);
  if (!begin_) read_until(0);
  const std::optional<verifier::StoredCheckpoint>& recorded = begin_ ? begin_ : initial_;
  if (!recorded) return true;  // damaged: the tail of the trace reports it
  report_.checkpoints_compared += begin_ ? 1 : 0;
  if (recorded->root_hash == first_root_) return true;
  Divergence divergence;
  divergence.tick = recorded->tick;
  divergence.time_s = report_.time_s;
  divergence.stage = std::string(begin_ ? verifier::stage_load : verifier::stage_setup);
  divergence.stage_note = begin_ ? "the state behind the load callback is not the recorded one"
                                 : "the state before the first tick is not the recorded one";
  divergence.expected_root = recorded->root_hash;
  divergence.got_root = first_root_;
  Bytes got;
  encode_image(state, got);
  if (!verifier::locate_lanes(setup().schema, recorded->image, got, row_name, lane_report_count_max, divergence))
    report_.warnings.push_back("the recorded initial state cannot be read");
  note_addresses(divergence);
  report_.divergence = std::move(divergence);
  report_.verdict = Verdict::diverged;
  report_.hint = begin_ ? "does save write every registered value, and does load restore each of them?"
                        : "is the world made from the setup alone, and every registered value initialised?";
  decided_ = true;
  return false;
}

std::optional<Bytes> Comparing::save_behind(std::uint64_t tick) {
  read_until(tick + 1);
  for (const RecordedTick& recorded : ahead_)
    if (recorded.tick == tick) return recorded.save;
  return std::nullopt;
}

void Comparing::count(std::uint64_t tick) {
  next_ = tick + 1;
  if (tick < range_.from) return;
  ++report_.ticks_compared;
  if (counted_.empty() || counted_.back().second != tick)
    counted_.emplace_back(tick, tick + 1);
  else
    counted_.back().second = tick + 1;
}

std::string Comparing::gaps() const {
  auto ranges = counted_;
  std::sort(ranges.begin(), ranges.end());
  std::string text;
  std::uint64_t expected = std::max(range_.from, source_.first_tick());
  for (const auto& [first, behind] : ranges) {
    if (first > expected)
      text += (text.empty() ? "" : ", ") + std::to_string(expected) + ".." + std::to_string(first - 1);
    expected = std::max(expected, behind);
  }
  return text;
}

void Comparing::note_floats() {
  std::string recorded;
  for (const auto& [name, value] : source_.facts())
    if (name == "floats") recorded = value;
  const std::string here = float_deviation();
  if (recorded != here)
    report_.warnings.push_back("floating point: recorded with " +
                               (recorded.empty() ? std::string("IEEE 754's defaults") : recorded) + ", here " +
                               (here.empty() ? std::string("IEEE 754's defaults") : here));
}

/// Stores the checkpoint with its tick, which is not compared yet.
void Comparing::take_checkpoint(const replay::CheckpointRecord& checkpoint) {
  ++report_.checkpoints_compared;
  std::optional<Bytes> save;
  if (checkpoint.save) save.emplace(checkpoint.save->begin(), checkpoint.save->end());
  if (checkpoint.shown && !ahead_.empty() && !ahead_.back().shown)
    ahead_.back().shown.emplace(checkpoint.shown->begin(), checkpoint.shown->end());
  if (checkpoint.tick == 0) {
    initial_ = verifier::copy_of(checkpoint);
    first_save_ = std::move(save);
  } else if (!ahead_.empty() && ahead_.back().tick + 1 == checkpoint.tick) {
    ahead_.back().checkpoint = verifier::copy_of(checkpoint);
    ahead_.back().save = std::move(save);
  }
}

bool Comparing::read_until(std::uint64_t tick) {
  while (!at_end_ && (ahead_.empty() || ahead_.back().tick < tick)) {
    const replay::TraceReader::Item& item = source_.next();
    if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
      take_checkpoint(*checkpoint);
      continue;
    }
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record != nullptr) {
      last_dt_ = record->dt;
      ahead_.push_back(RecordedTick{verifier::copy_of(*record), {}, {}, {}, record->marks, record->has_bound});
      if (record->shown) ahead_.back().shown.emplace(record->shown->begin(), record->shown->end());
      continue;
    }
    at_end_ = true;
    const replay::TraceTail& tail = source_.tail();
    report_.end = verifier::TraceEnd{tail, inputs_json(tail.ticks_intact, tail.pending_inputs)};
    if (tail.condition == replay::TraceCondition::complete && tail.end &&
        tail.end->reason == replay::EndReason::non_finite) {
      RecordedTick last;
      last.tick = tail.ticks_intact;
      last.dt = tail.has_pending_inputs ? tail.pending_dt : last_dt_;
      last.inputs = tail.pending_inputs;
      last.is_not_finite = true;
      ahead_.push_back(std::move(last));
    }
  }
  return !ahead_.empty() && ahead_.back().tick >= tick;
}

const RecordedTick* Comparing::at(std::uint64_t tick) {
  if (range_.to && tick > *range_.to) return nullptr;
  read_until(tick);
  for (const RecordedTick& recorded : ahead_)
    if (recorded.tick == tick) return &recorded;
  return nullptr;
}

void Comparing::compare_marks(const RecordedTick& recorded, const DoneTick& done) {
  if (!has_marks() || report_.marks || !recorded.has_bound || done.bound == nullptr) return;
  const replay::TickMarks* expected = recorded.marks ? &*recorded.marks : nullptr;
  const replay::TickMarks* got = done.bound->marks ? &*done.bound->marks : nullptr;
  report_.marks = verifier::compare_marks(done.tick, expected, got);
  ++report_.compared.marks;
}

bool Comparing::compare(const DoneTick& done, const StateSchema& whole, const RowNamer& row_name) {
  if (decided_) return false;
  TICKTRUE_ASSERT(!ahead_.empty() && ahead_.front().tick == done.tick);
  const RecordedTick& recorded = ahead_.front();
  if (recorded.is_not_finite) return compare_non_finite(recorded, done, row_name);
  read_until(done.tick + 1);  // a checkpoint can follow
  compare_marks(recorded, done);
  verifier::TickSide here{done.root_hash, done.stage_hashes};
  here.state = done.state;
  std::vector<verifier::TickSide> sides{side_of(recorded), here};
  if (recorded.checkpoint) sides.push_back(side_of(*recorded.checkpoint));
  const auto difference = comparer_.compare(sides);
  report_.compared += comparer_.take_compared();
  report_.root_hash = here.root_hash;
  count(done.tick);
  if (difference) {
    const bool is_of_checkpoint = difference->b == 2;
    if (!is_of_checkpoint && !sides[0].image && recorded.checkpoint)
      sides[0].image = ByteView(recorded.checkpoint->image);
    diverge(recorded, done, sides[is_of_checkpoint ? 2 : 0], here, row_name);
    const std::string contradiction = verifier::contradiction_text(done.tick, difference->part);
    if (is_of_checkpoint) {
      report_.divergence->tick = recorded.checkpoint->tick;
      report_.divergence->stage = "checkpoint";
      report_.divergence->stage_note = "the hash of the tick before agrees, the checkpoint does not";
    }
    if (!contradiction.empty()) report_.notes.push_back(contradiction);
    note_shown(recorded.shown ? &*recorded.shown : nullptr, done.contents.shown, whole);
    return false;
  }
  changed_ = changed_ || here.root_hash != first_root_;
  report_.time_s += done.dt;
  ahead_.pop_front();
  return true;
}

void Comparing::diverge(const RecordedTick& recorded, const DoneTick& done, const verifier::TickSide& expected,
                        const verifier::TickSide& here, const RowNamer& row_name) {
  decided_ = true;
  report_.verdict = Verdict::diverged;
  Divergence divergence;
  divergence.tick = done.tick;
  divergence.time_s = report_.time_s;
  divergence.inputs = inputs_json(done.tick, recorded.inputs);
  verifier::DescribeContext context{setup().schema, setup().stages, row_name, lane_report_count_max};
  if (setup().stages.empty()) context.no_stages = "not known: the program names no stages";
  if (!describe_tick(context, expected, here, divergence))
    report_.warnings.push_back("the stored state of tick " + std::to_string(done.tick) + " cannot be read");
  if (const auto place = find_non_finite(*done.state))
    report_.notes.push_back("the state here is not finite: " + place_text(*done.state->schema, *place, row_name));
  note_addresses(divergence);
  const std::string tick = std::to_string(done.tick);
  if (!divergence.has_values())
    report_.again.push_back("record with detail full, ticks " + tick + ".." + tick +
                            ", by both builds; then `ticktrue diff A B` names columns and values");
  if (const std::string program = program_command(report_.file); !program.empty()) {
    const std::string file_and_program = verifier::shell_word(report_.file) + " -- " + program;
    if (report_.marks)
      report_.again.push_back("ticktrue trail " + file_and_program + "  # shows the marks that differ first");
    report_.again.push_back("ticktrue shake " + file_and_program + "  # shows what the program takes from outside");
  }
  report_.again.push_back(
      "verify once more with this build: another tick or other values mean that this program does not repeat itself");
  report_.divergence = std::move(divergence);
}

void Comparing::note_shown_schema(const StateSchema& whole) {
  const std::string recorded = shown_columns(setup().whole_schema ? *setup().whole_schema : setup().schema);
  const std::string here = shown_columns(whole);
  if (recorded != here) report_.notes.push_back("shown columns: recorded " + recorded + "; here " + here);
}

void Comparing::note_shown(const Bytes* recorded, const Bytes* here, const StateSchema& whole) {
  const StateSchema& recorded_schema = setup().whole_schema ? *setup().whole_schema : setup().schema;
  std::size_t count = 0;
  const verifier::LaneReport* before = nullptr;
  for (const verifier::LaneReport& row : report_.divergence->rows) {
    if (before != nullptr && before->table == row.table && before->row == row.row) continue;
    before = &row;
    const std::string there = shown_row(recorded_schema, recorded, row.table, row.row);
    const std::string now = shown_row(whole, here, row.table, row.row);
    if (there.empty() && now.empty()) continue;
    report_.notes.push_back("shown of " + row.table + " row " + std::to_string(row.row) + ": " +
                            (there.empty() ? "" : "recorded " + there + (now.empty() ? "" : "; ")) +
                            (now.empty() ? "" : "here " + now));
    if (++count == shown_rows_max) return;
  }
}

void Comparing::note_addresses(const Divergence& divergence) {
  for (const verifier::LaneReport& row : divergence.rows) {
    const bool is_wide = row.type == ScalarType::u64 || row.type == ScalarType::i64;
    if (!is_wide || !row.expected || !row.got || !looks_like_address(*row.expected) || !looks_like_address(*row.got))
      continue;
    report_.notes.push_back("both values of " + row.table + "." + row.column +
                            " look like addresses, which differ in every run: register an index or id instead");
    return;
  }
}

bool Comparing::compare_non_finite(const RecordedTick& recorded, const DoneTick& done, const RowNamer& row_name) {
  verifier::NonFiniteTick found =
      verifier::compare_non_finite(done.tick, *done.state, report_.end->tail.end->note, row_name);
  if (found.is_as_recorded) {
    report_.notes.push_back(found.text);
    ahead_.pop_front();
    return true;
  }
  decided_ = true;
  report_.verdict = Verdict::diverged;
  report_.reason = found.text;
  found.divergence.time_s = report_.time_s;
  found.divergence.inputs = inputs_json(done.tick, recorded.inputs);
  report_.divergence = std::move(found.divergence);
  return false;
}

void Comparing::other_inputs(std::uint64_t tick, const std::string& what) {
  not_comparable("tick " + std::to_string(tick) + ": inputs: " + what,
                 "the loop reads its inputs in other pieces than the one that recorded them");
}

void Comparing::finish(std::uint64_t ticks_run) {
  const std::optional<std::uint64_t> salvaged_from = source_.salvaged_from();
  const bool compared_salvaged = salvaged_from && next_ > *salvaged_from;
  if (!at_end_ && compared_salvaged)
    read_until(limits::tick_count_max);  // the checks of records prove no match
  else if (!at_end_ && !is_behind_range())
    read_until(ticks_run);
  if (report_.end) set_salvaged(*report_.end, salvaged_from);
  if (report_.end && !report_.ticks_recorded)
    report_.ticks_recorded =
        report_.end->tail.ticks_intact - std::min(source_.first_tick(), report_.end->tail.ticks_intact);
  if (report_.ticks_compared > 0 && !changed_ && report_.verdict != Verdict::diverged)
    report_.warnings.push_back("no registered value changed in " + count_text(report_.ticks_compared, "tick") +
                               ": is all of the state registered?");
  if (counted_.size() > 1) {  // a tick that was compared twice counts once
    std::sort(counted_.begin(), counted_.end());
    std::uint64_t behind = report_.ticks_compared = 0;
    for (const auto& [first, end] : counted_) {
      report_.ticks_compared += end - std::min(end, std::max(first, behind));
      behind = std::max(behind, end);
    }
  }
  if (report_.marks && !report_.divergence)
    report_.warnings.push_back("marks differ first at tick " + std::to_string(report_.marks->tick) + ": " +
                               verifier::marks_text(*report_.marks) + "; they decide no verdict");
  if (decided_) return;
  decided_ = true;
  const replay::TraceTail* tail = report_.end ? &report_.end->tail : nullptr;
  report_.verdict = Verdict::incomplete;
  if (tail != nullptr && tail->condition == replay::TraceCondition::damaged) {
    report_.verdict = Verdict::damaged;
    report_.reason = tail->message;
    if (report_.ticks_compared > 0) {
      report_.hint =
          "every tick compared matches; `ticktrue recover` makes a complete trace of what is before the damage";
      report_.again.push_back("ticktrue recover " + verifier::shell_word(report_.file) + " -o WHOLE.ttr");
    }
  } else if (!is_behind_range() && (!at_end_ || !ahead_.empty())) {
    report_.reason =
        "the program ended its loop after " + count_text(report_.ticks_compared, "tick") + ", before the trace ends";
    report_.hint = "leave the loop when ticktrue_begin_tick does not return TICKTRUE_OK";
  } else if (tail != nullptr && tail->condition == replay::TraceCondition::truncated) {
    report_.reason = tail->message;
    report_.hint = "every tick up to the cut matches; `ticktrue recover` makes a complete trace of it";
  } else if (report_.ticks_compared == 0) {
    report_.reason = "no tick was compared";
  } else if (const std::string missing = gaps(); !missing.empty()) {
    report_.reason = "ticks " + missing + " were not compared: ticktrue_seek went past them";
  } else {
    report_.verdict = Verdict::match;
  }
}

void Comparing::second_run_differs(SecondRunFinding finding) {
  if (decided_) return;
  decided_ = true;
  report_.verdict = Verdict::state_incomplete;
  report_.checkpoint = finding.begin;
  report_.reason = std::move(finding.reason);
  report_.hint = verifier::second_run_hint;
  constexpr std::array<std::string_view, 3> second_runs{"--mode", "--sync-test", "--from"};
  if (const std::string program = program_command(report_.file, second_runs); !program.empty())
    report_.again.push_back("ticktrue unsaved " + verifier::shell_word(report_.file) + " -- " + program +
                            "  # names what the save lacks");
  report_.divergence = std::move(finding.divergence);
}

void Comparing::not_whole(const std::string& reason, const std::string& hint) {
  if (report_.verdict != Verdict::match) return;
  report_.verdict = Verdict::incomplete;
  report_.reason = reason;
  report_.hint = hint;
}

}  // namespace ticktrue::capi
