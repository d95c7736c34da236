// Recording a session.
// SPDX-License-Identifier: MIT
#include "capi/recording.h"

#include <algorithm>
#include <cstdio>

#include "base/count_text.h"
#include "base/hash.h"
#include "base/state/child_tables.h"

namespace ticktrue::capi {
namespace {

constexpr std::uint64_t slot_reserve = 8u << 10;  // bytes of a slot in addition to twice the largest tick

std::string reason_name(replay::EndReason reason) {
  for (const replay::EndReasonInfo& info : replay::end_reasons)
    if (info.reason == reason) return std::string(info.name);
  return "";
}

std::string json_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) >= 0x20) out += c;
  }
  return out + "\"";
}

}  // namespace

bool Recording::wants_stages(std::uint64_t tick) const {
  return options_.detail == replay::Detail::full && options_.full_first <= tick && tick <= options_.full_last;
}

bool Recording::wants_save(std::uint64_t tick) const {
  const auto saves = static_cast<std::uint32_t>(replay::Feature::saves);
  return (options_.features & saves) != 0 && (tick % options_.checkpoint_interval == 0 || is_slot_low());
}

bool Recording::wants_shown(std::uint64_t tick) const {
  return wants_stages(tick) || (tick + 1) % options_.checkpoint_interval == 0 || is_slot_low();
}

Status Recording::write_checkpoint(const StateView& state, std::uint64_t tick, const CheckpointContents& contents) {
  if (const Status status = writer_->checkpoint(state, root_); !status) return status;
  if (contents.shown != nullptr)
    if (const Status status = writer_->shown(*contents.shown); !status) return status;
  if (contents.save != nullptr) return writer_->save(*contents.save);
  if (wants_save(tick)) ++missing_saves_;
  return {};
}

bool Recording::is_slot_low() const {
  return box_ != nullptr && (box_->is_full() || box_->room() < 2 * tick_size_max_ + slot_reserve);
}

Status Recording::begin_slot(const StateView& state, std::uint64_t tick, const CheckpointContents& contents) {
  Result<replay::TraceWriter> writer = box_->begin_slot(setup_, options_.facts, tick, time_s_);
  if (!writer) return writer.error();
  writer_.emplace(std::move(*writer));
  box_checkpoint_ = box_written_ = box_->written_size();
  if (const Status status = write_checkpoint(state, tick, contents); !status) return status;
  if (box_->is_full() || is_slot_low()) {
    const std::uint64_t wanted = 4 * std::max(box_->wanted_size(), tick_size_max_ + slot_reserve);
    return Error{ErrorCode::io,
                 options_.path + ": black box: a slot has " + std::to_string(box_->slot_size()) +
                     " bytes: found a checkpoint of " + std::to_string(box_->wanted_size()) +
                     ", expected less than half a slot",
                 "box_kib: " + std::to_string(wanted * box_->file_size() / box_->slot_size() / 1024 + 1) + " would do"};
  }
  box_->publish();
  return {};
}

/// In a box, a checkpoint begins the next slot if the ticks up to the next checkpoint might not fit.
Status Recording::write_due_checkpoint(const DoneTick& tick) {
  const std::uint64_t next = tick.tick + 1;
  const bool is_due = writer_->wants_checkpoint();
  if (box_ == nullptr) return is_due ? write_checkpoint(*tick.state, next, tick.contents) : Status();
  const std::uint64_t written = box_->written_size();
  tick_size_max_ = std::max(tick_size_max_, written - box_written_);
  box_written_ = written;
  if (is_due) interval_size_max_ = std::max(interval_size_max_, written - box_checkpoint_);
  const bool is_low = is_slot_low() || (is_due && box_->room() < interval_size_max_ + interval_size_max_ / 4);
  const bool has_saves = (options_.features & static_cast<std::uint32_t>(replay::Feature::saves)) != 0;
  // With rollback, the save of this tick was requested before the slot was known to be low.
  if (is_low && (is_due || !has_saves || tick.contents.save != nullptr)) {
    box_gaps_ += box_->is_full() ? 1 : 0;
    return begin_slot(*tick.state, next, tick.contents);
  }
  if (!is_due) return {};
  box_checkpoint_ = written;
  return write_checkpoint(*tick.state, next, tick.contents);
}

Status Recording::begin_file(const StateView& state, const CheckpointContents& contents) {
  if (is_box()) {
    const Result<replay::BoxLayout> layout = replay::divide_box(options_.box_size);
    if (!layout) return layout.error();
    box_ = std::make_unique<replay::BoxWriter>(options_.path, *layout);
    const Status status = begin_slot(state, 0, contents);
    if (!box_->note().empty()) notes.push_back(box_->note());
    return status;
  }
  Result<replay::TraceWriter> writer =
      replay::TraceWriter::create(options_.path, setup_, options_.facts, options_.writer);
  if (!writer) return writer.error();
  writer_.emplace(std::move(*writer));
  if (const Status status = write_checkpoint(state, 0, contents); !status) return writer_->abandon(status.error());
  return {};
}

Status Recording::start(const StateView& state, const StateSchema& whole, const CheckpointContents& contents,
                        const std::vector<std::string>& stages, const RowNamer& row_name) {
  if (const auto place = find_non_finite(state))
    return Error{ErrorCode::usage,
                 options_.path + ": initial state: " + place_text(*state.schema, *place, row_name) +
                     ": found a value that is not finite",
                 "initialise it; a value that means \"none\" is better an integer"};
  replay::TraceSetup& setup = setup_;
  setup.simulation = options_.identity.name;
  setup.physics_version = options_.identity.version;
  setup.title = options_.title;
  setup.dt = options_.dt;
  setup.detail = options_.detail;
  setup.full_first = options_.full_first;
  setup.full_last = options_.full_last;
  setup.checkpoint_interval = options_.checkpoint_interval;
  if (has_shown_columns(whole)) {
    options_.features |= static_cast<std::uint32_t>(replay::Feature::shown);
    setup.whole_schema = whole;
  }
  if (is_box()) options_.features |= static_cast<std::uint32_t>(replay::Feature::tail);
  setup.features = options_.features;
  setup.schema = *state.schema;
  setup.stages = stages;
  setup.setup = options_.setup;
  // Version 3 is written only if the program uses its features.
  options_.writer.allow_third = options_.features != 0 || has_children(whole);
  first_root_ = root_ = root_hash(state);
  return begin_file(state, contents);
}

Status Recording::begin(double dt, ByteView inputs) {
  if (const Status status = writer_->begin_tick(TickInput{dt, inputs}); !status)
    return writer_->abandon(status.error());
  return {};
}

Status Recording::note(const replay::Note& note) {
  if (const Status status = writer_->note(note); !status) return writer_->abandon(status.error());
  return {};
}

Status Recording::write_bound(const BoundContents& bound, std::uint64_t tick) {
  for (const replay::Note& note : bound.notes)
    if (const Status status = writer_->note(note); !status) return status;
  if (bound.marks)
    if (const Status status = writer_->marks(*bound.marks); !status) return status;
  return bound.mark_list && wants_stages(tick) ? writer_->mark_list(*bound.mark_list) : Status();
}

Result<bool> Recording::end(const DoneTick& tick, const RowNamer& row_name) {
  if (const auto place = find_non_finite(*tick.state)) {
    const std::string note = "tick " + std::to_string(tick.tick) + ": " +
                             place_text(*tick.state->schema, *place, row_name) + ": found a value that is not finite";
    if (const Status status = finish(replay::EndReason::non_finite, note); !status) return status.error();
    return false;
  }
  root_ = tick.root_hash;
  changed_ = changed_ || root_ != first_root_;
  if (tick.bound != nullptr && has_marks())
    if (const Status status = write_bound(*tick.bound, tick.tick); !status) return writer_->abandon(status.error());
  if (const Status status = writer_->end_tick(root_, tick.stage_hashes, tick.state); !status)
    return writer_->abandon(status.error());
  if (tick.contents.shown != nullptr && wants_stages(tick.tick))
    if (const Status status = writer_->shown(*tick.contents.shown); !status) return writer_->abandon(status.error());
  time_s_ += tick.dt;
  if (const Status status = write_due_checkpoint(tick); !status)
    return box_ != nullptr ? status.error() : writer_->abandon(status.error());
  return true;
}

Status Recording::finish(replay::EndReason reason, const std::string& note) {
  if (closed_ || !writer_) return {};
  closed_ = true;
  reason_ = reason;
  note_ = note;
  if (writer_->tick_count() == 0 && reason == replay::EndReason::complete) {
    writer_->discard();
    return Error{ErrorCode::usage, options_.path + ": the session ends before its first tick: nothing was recorded",
                 "begin_tick and end_tick belong into the loop; a program that rolls back must confirm ticks"};
  }
  if (!changed_ && writer_->tick_count() > 0)
    warnings.push_back("no registered value changed in " + std::to_string(writer_->tick_count()) +
                       " ticks: is all of the state registered, and by its own address rather than a copy's?");
  if (missing_saves_ > 0)
    warnings.push_back(count_text(missing_saves_, "checkpoint") +
                       " without a save: the save callback returned TICKTRUE_SAVE_FAILED");
  if (const Status status = writer_->finish(reason, note); !status) return writer_->abandon(status.error());
  if (box_ != nullptr) {
    box_->close();
    notes.push_back(box_text());
  }
  return {};
}

std::string Recording::box_text() const {
  std::string text = "a black box: it holds ticks " + std::to_string(box_->first_tick()) + ".." +
                     std::to_string(std::max<std::uint64_t>(writer_->tick_count(), 1) - 1) + "; `ticktrue recover " +
                     verifier::shell_word(options_.path) + " -o F.ttr` makes a trace of them";
  if (box_gaps_ > 0)
    text += "; " + count_text(box_gaps_, "time") + " a tick did not fit into its slot: what is before it is lost";
  if ((options_.features & static_cast<std::uint32_t>(replay::Feature::saves)) == 0)
    text += "; without the callbacks save and load it names the place and cannot be run again";
  return text;
}

std::string Recording::text() const {
  char numbers[96];
  std::snprintf(numbers, sizeof numbers, "%llu ticks (%.3f s), %llu bytes",
                static_cast<unsigned long long>(writer_ ? writer_->tick_count() : 0), time_s_,
                static_cast<unsigned long long>(size()));
  std::string text = "recorded  " + options_.path + "  " + numbers + "\n  hash    " + hex64(root_) + "\n";
  if (reason_ != replay::EndReason::complete)
    text += "  ended   " + reason_name(reason_) + (note_.empty() ? "" : ": " + note_) + "\n";
  for (const std::string& line : notes) text += "  note    " + line + "\n";
  for (const std::string& warning : warnings) text += "  warning " + warning + "\n";
  return finding_ ? text + verifier::report_text(*finding_) : text;
}

std::string Recording::json(const std::string& desync) const {
  std::string text = "{\"schema\": \"ticktrue.record/1\", \"file\": " + json_string(options_.path) +
                     ", \"scene\": " + json_string(options_.title) +
                     ", \"ticks\": " + std::to_string(writer_ ? writer_->tick_count() : 0) +
                     ", \"size\": " + std::to_string(size()) + ", \"reason\": " + json_string(reason_name(reason_)) +
                     ", \"note\": " + json_string(note_) + ", \"hash\": \"" + hex64(root_) + "\", \"warnings\": [";
  for (std::size_t i = 0; i < warnings.size(); ++i) text += (i > 0 ? ", " : "") + json_string(warnings[i]);
  text += "]";
  if (finding_) {
    std::string finding = verifier::report_json({&*finding_, 1}, false);
    while (!finding.empty() && finding.back() == '\n') finding.pop_back();
    text += ", \"sync_test\": " + finding;
  }
  if (!desync.empty()) text += ", \"desync\": " + desync;
  return text + "}\n";
}

}  // namespace ticktrue::capi
