// The options of a session: their checks, and the recording or comparison that they request.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>
#include <utility>

#include "base/limits.h"
#include "capi/call_values.h"
#include "capi/session.h"
#include "replay/file/file_calls.h"

namespace ticktrue::capi {
namespace {

constexpr std::uint32_t rollback_count_max = 4096;  // ticks: over a minute. Each has a copy of the state
constexpr std::uint32_t checkpoint_interval_default = 600;
constexpr std::uint32_t known_flags =
    TICKTRUE_OVERWRITE | TICKTRUE_QUIET | TICKTRUE_JSON | TICKTRUE_NO_SYNC | TICKTRUE_RESTORE | TICKTRUE_MARKS;

}  // namespace

Status Session::check_options(const ticktrue_options& options) {
  is_live_ = options.mode == TICKTRUE_LIVE;
  if (!is_live_ && options.mode != TICKTRUE_RECORD && options.mode != TICKTRUE_VERIFY)
    return usage("options: mode: found " + std::to_string(options.mode) +
                 ", expected TICKTRUE_RECORD, TICKTRUE_VERIFY or TICKTRUE_LIVE");
  const bool has_path = options.path != nullptr && options.path[0] != 0;
  if (!is_live_ && !has_path) return usage("options: path: found none, expected a file name");
  if (is_live_ && has_path)
    return usage("options: path: found a file name in a live session",
                 "TICKTRUE_RECORD records a live game, and takes the same calls");
  if (has_path) path_ = replay::utf8_path(options.path);
  identity_.name = std::string(text_of(options.name));
  if (const Status status = check_name("options: simulation", identity_.name); !status) return status;
  if (identity_.name.compare(0, 9, "ticktrue.") == 0)
    return usage("options: name: found " + identity_.name + ", expected one that does not begin with ticktrue.");
  identity_.version = options.version;
  facts_ = ProgramFacts(std::string(text_of(options.build)));
  if (options.caller_facts != nullptr)
    if (const Status status = facts_.add("", options.caller_facts); !status) return status;
  if ((options.flags & ~known_flags) != 0)
    return usage("options: flags: found " + number(options.flags) + ", expected those of this header",
                 "the library may be older than the header");
  flags_ = options.flags;
  default_dt_ = options.dt == 0 ? 1.0 / 60 : options.dt;
  if (!replay::is_dt(default_dt_)) return usage("options: dt: found a value that is negative or not finite");
  if (options.rollback_max > rollback_count_max)
    return usage("options: rollback_max: found " + number(options.rollback_max) + ", expected at most " +
                 number(rollback_count_max));
  rollback_max_ = options.rollback_max;

  if (const Status status = check_run_options(options); !status) return status;
  if (options.player > player_max)
    return usage("options: player: found " + number(options.player) + ", expected at most " + number(player_max));
  peers_.emplace(options.player, options.peer_bytes == 0
                                     ? KeptTicks::size_default
                                     : static_cast<std::size_t>(std::min<std::uint64_t>(options.peer_bytes, SIZE_MAX)));
  if (is_live_ || options.peer_bytes > 0) peers_->keep_states();

  if (options.mode == TICKTRUE_VERIFY) {
    Result<replay::TraceReader> reader = replay::TraceReader::open(path_);
    if (!reader) return reader.error();
    comparing_.emplace(std::move(*reader), path_,
                       CompareRange{from_, options.to == 0 ? std::nullopt : std::optional(options.to)});
    if (restores_) comparing_->set_mode("restore");
    trail_ = TrailLog::from_environment();
    if (comparing_->has_marks() || trail_ != nullptr) marks_.turn_on();
    probe_ = Probe::from_environment();
    if (probe_ && !saves_.is_set())
      probe_->refuse("the session has no load callback: nothing to compare",
                     "set save and load in the options: see docs/any_simulation.md");
    if (probe_) sync_ticks_ = 0, restores_ = false;
    return {};
  }
  if (options.setup == nullptr && options.setup_size > 0)
    return usage("options: setup: found null, expected " + number(options.setup_size) + " bytes");
  if (options.setup_size > limits::setup_size_max)
    return usage("options: setup: found " + number(options.setup_size) + " bytes, expected at most " +
                 number(limits::setup_size_max));
  const auto* setup = static_cast<const std::uint8_t*>(options.setup);
  setup_.assign(setup, setup + options.setup_size);
  if (is_live_) return {};
  return make_recording(options);
}

Status Session::make_recording(const ticktrue_options& options) {
  RecordingOptions recording;
  recording.path = path_;
  recording.identity = identity_;
  recording.title = options.title == nullptr ? identity_.name : std::string(text_of(options.title));
  recording.dt = default_dt_;
  recording.checkpoint_interval =
      options.checkpoint_interval == 0 ? checkpoint_interval_default : options.checkpoint_interval;
  recording.setup = setup_;
  if (saves_.is_set()) recording.features |= static_cast<std::uint32_t>(replay::Feature::saves);
  if ((flags_ & TICKTRUE_MARKS) != 0) marks_.turn_on();
  recording.writer.overwrite = (flags_ & TICKTRUE_OVERWRITE) != 0;
  recording.writer.sync = (flags_ & TICKTRUE_NO_SYNC) == 0;
  bool is_known = options.detail == TICKTRUE_DETAIL_DEFAULT;
  const std::int32_t wanted = is_known ? TICKTRUE_DETAIL_CELLS : options.detail;
  for (const replay::DetailInfo& info : replay::details) {
    if (static_cast<std::int32_t>(info.detail) != wanted) continue;
    recording.detail = info.detail;
    is_known = true;
  }
  if (!is_known)
    return usage("options: detail: found " + std::to_string(options.detail) + ", expected one of TICKTRUE_DETAIL_*");
  if (recording.detail == replay::Detail::full) {
    recording.full_first = options.full_first;
    recording.full_last = options.full_last == 0 ? std::numeric_limits<std::uint64_t>::max() : options.full_last;
    if (recording.full_first > recording.full_last)
      return usage("options: full_first: found " + number(options.full_first) + ", expected at most full_last, " +
                   number(options.full_last));
  }
  recording.box_size = std::uint64_t{options.box_kib} * 1024;
  if (recording.box_size > 0) {
    if (const auto layout = replay::divide_box(recording.box_size); !layout) return layout.error();
    if (recording.detail == replay::Detail::full)
      return usage("options: detail: found full with a black box, expected root or cells",
                   "the box holds the save of a tick before: run it again with detail full");
  }
  recording_.emplace(std::move(recording));
  if (marks_.is_on()) recording_->add_marks();
  return {};
}

Status Session::check_run_options(const ticktrue_options& options) {
  const bool is_verify = options.mode == TICKTRUE_VERIFY;
  if ((options.save == nullptr) != (options.load == nullptr))
    return usage(std::string("options: ") +
                     (options.save == nullptr ? "load: found it without save" : "save: found it without load") +
                     ", expected both or none",
                 "load takes the bytes that save gave");
  if (options.reserved != 0) return usage("options: reserved: found " + number(options.reserved) + ", expected 0");
  static_assert(TICKTRUE_SAVE_FAILED == save_refused);
  saves_ = SaveCalls(options.save, options.load, options.user);
  from_ = options.from;
  sync_ticks_ = options.sync_test;
  restores_ = (flags_ & TICKTRUE_RESTORE) != 0;
  if (sync_ticks_ > rollback_count_max)
    return usage("options: sync_test: found " + number(sync_ticks_) + ", expected at most " +
                 number(rollback_count_max));
  const struct {
    const char* name;
    bool is_there;
    bool needs_load;
    bool needs_verify;
  } rules[] = {{"from", from_ > 0, true, true},
               {"to", options.to > 0, false, true},
               {"sync_test", sync_ticks_ > 0, true, false},
               {"flags: TICKTRUE_RESTORE", restores_, true, true}};
  for (const auto& rule : rules) {
    if (!rule.is_there) continue;
    if (rule.needs_verify && !is_verify)
      return usage(std::string("options: ") + rule.name + ": found it in a recording",
                   "it says what a verification does");
    if (rule.needs_load && !saves_.is_set())
      return usage(std::string("options: ") + rule.name + ": found it without the callbacks save and load",
                   "without them the program can only begin at tick 0 and run on");
  }
  if (options.box_kib > 0 && options.mode != TICKTRUE_RECORD)
    return usage("options: box_kib: found it without TICKTRUE_RECORD", "a black box is a recording of the last ticks");
  if (is_live_ && sync_ticks_ > 0)
    return usage("options: sync_test: found it in a live session",
                 "record or verify with it: going back takes time that other players wait");
  if (restores_ && sync_ticks_ > 0)
    return usage("options: sync_test: found it with TICKTRUE_RESTORE, expected one of them",
                 "one loads saves of this run, the other those of the trace: verify twice");
  if (options.to > 0 && options.to < from_)
    return usage("options: to: found " + number(options.to) + ", expected at least from, " + number(from_));
  return {};
}

}  // namespace ticktrue::capi
