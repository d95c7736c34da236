// A session behind the C interface: registered state, the order of calls, ticks that wait for confirmation.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/state/gathered_state.h"
#include "base/state/kept_state.h"
#include "base/state/save_calls.h"
#include "base/state/second_run.h"
#include "capi/change_summary.h"
#include "capi/comparing.h"
#include "capi/marks/marks.h"
#include "capi/marks/trail_log.h"
#include "capi/peers/peers.h"
#include "capi/program_facts.h"
#include "capi/recording.h"
#include "capi/tick.h"
#include "capi/unsaved/probe.h"
#include "include/ticktrue.h"

namespace ticktrue::capi {

/// Every call returns a status of the C interface. The first that is not TICKTRUE_OK stays.
class Session {
 public:
  /// Checks and copies the options, and opens the trace of a verification.
  explicit Session(const ticktrue_options& options);
  /// A session that has failed before it began.
  explicit Session(const Error& error) { fail(error); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  int status() const { return status_; }
  /// Why the session failed or lost its recording.
  const std::string& message() const { return message_; }
  /// That, else why the last call was refused.
  const std::string& last_message() const { return message_.empty() ? refusal_ : message_; }
  std::uint64_t tick() const { return tick_; }
  ByteView setup() const;

  int build_facts(const char* unit, const char* facts);
  int column(const char* table, const char* name, const void* data, int type, std::uint32_t lanes, std::uint32_t rows,
             std::size_t stride);
  /// `table_number` becomes that of the table.
  int table(const char* name, std::size_t stride, const ticktrue_member* members, std::uint32_t member_count,
            std::uint32_t& table_number);
  int rows(std::uint32_t table, const void* base, std::uint32_t rows);
  /// `source`: form, callback and stride.
  int child(const char* name, const char* parent, const ChildSource& source, const ticktrue_member* members,
            std::uint32_t member_count);
  int key(const char* table, std::uint32_t columns);
  int reference(const char* table, const char* column, const char* target);
  int row_names(const char* table, ticktrue_namer call, void* user);
  int add_stage(const char* name);
  int stage(const char* name);
  int input(void* data, std::size_t size);
  /// A mark for which there is little to do. False: nothing was done, and mark() does it.
  bool mark_quickly(const char* name, std::uint64_t value) {
    if (status_ != TICKTRUE_OK) return false;
    if (phase_ != Phase::inside) return true;
    return marks_.add_again(name, value) || (has_dropped_marks_ && !marks_.is_on());
  }
  /// `caller`: where the call of the program returns to; null: not known.
  int mark(const char* name, std::uint64_t value, const void* caller);
  int note(const char* topic, const char* text);
  int begin_tick(double* dt);
  int end_tick();
  int rewind(std::uint64_t tick);
  int confirm(std::uint64_t tick);
  int seek(std::uint64_t tick);

  // ---- Other players (session_peers.cpp) ----

  int root(std::uint64_t tick, std::uint64_t* root);
  /// Returns the size; writes if it fits. 0: the session has failed.
  std::size_t hello(void* buffer, std::size_t size);
  int hello_check(std::uint32_t peer, const void* bytes, std::size_t size, char* text, std::size_t text_size);
  int peer_root(std::uint32_t peer, std::uint64_t tick, std::uint64_t root);
  std::size_t desync_message(std::uint32_t peer, void* buffer, std::size_t size);
  int desync_receive(std::uint32_t peer, const void* bytes, std::size_t size);
  /// One file about a desync. A file that cannot be written is refused, and the session goes on.
  int bundle(const char* path);
  /// The black box so far, as a trace. The same.
  int box_save(const char* path);
  /// Empty: no desync is known.
  std::string desync_report(bool& is_complete);

  /// Closes the session, decides the verdict and returns the exit code. A second call returns the same.
  int finish();
  bool is_finished() const { return phase_ == Phase::finished; }
  /// Whether the program calls from inside a callback. Then this is a failure of the session.
  bool refuse_in_callback(const char* what);
  bool is_quiet() const { return (flags_ & TICKTRUE_QUIET) != 0; }
  bool wants_json() const { return (flags_ & TICKTRUE_JSON) != 0; }
  /// Requires: is_finished(). Empty where the session failed.
  std::string report_text() const;
  std::string report_json() const;
  /// The same, also of a verification that failed; empty for a recording.
  std::string result_json() const;

  /// A failure from outside, such as memory that ran out.
  int fail(const Error& error);

 private:
  enum class Phase { registering, between, inside, finished };

  /// A tick that has run and is not confirmed yet, with the state after it.
  struct PendingTick {
    std::uint64_t tick = 0;
    double dt = 0;
    Bytes inputs;
    std::vector<std::uint64_t> stage_hashes;
    KeptState state;
    std::optional<Bytes> save;
    std::optional<Bytes> shown;
    BoundContents bound;
  };

  Status check_options(const ticktrue_options& options);
  Status check_run_options(const ticktrue_options& options);
  Status make_recording(const ticktrue_options& options);
  void set_facts();
  int stop(int status);
  /// Copies the registered state. The callbacks of child tables are called.
  Status gather();
  int wrong_order(const std::string& what, const std::string& hint);
  bool can_call(const char* what);
  int start();
  bool wants_stages(const RecordedTick* recorded) const;
  /// The recorded tick that begins next; null at the end of the trace.
  const RecordedTick* recorded();
  int take(DoneTick done);
  int write_notes();
  /// Has the preload library mark calls, where the environment asks for it.
  void take_calls();
  static void take_call(void* session, const char* name, std::uint64_t value, const void* caller);
  MarkDetail mark_detail() const;
  int confirm_pending(std::uint64_t tick);
  RowNamer namer();
  int finish_recording();
  /// The disk took no more: the recording ends, the game goes on. Other errors fail the session.
  int recording_failed(const Error& error);
  bool is_recording() const { return recording_ && !is_recording_lost_; }
  int begin_recorded_tick(double dt, ByteView inputs);
  void take_live_tick(const DoneTick& done);
  bool can_call_peers(const char* what, std::uint32_t peer);
  bool know_game();
  replay::TraceSetup game_setup() const;
  /// Nothing has changed: the session goes on.
  int refuse(const Error& error);
  int peers_status() const { return peers_->has_desync() ? TICKTRUE_DIVERGED : TICKTRUE_OK; }
  /// Puts what is known of the other players into the report.
  void report_peers();
  std::string live_text() const;
  std::string live_json() const;

  // ---- Saves and second runs (session_runs.cpp) ----

  /// Calls the save callback; `bytes` becomes nothing where it has no save now. False: the session has failed.
  bool save_now(std::optional<Bytes>& bytes);
  /// False: the session has failed.
  bool gather_shown(std::optional<Bytes>& bytes);
  /// Calls the load callback and gathers the state. False: the session has failed.
  bool load_now(std::uint64_t tick, ByteView bytes);
  bool open_sync_block();
  /// Loads the save at the begin of the ticks that ran once: they come again. False: the session has ended.
  bool go_back();
  bool can_go_back() const { return second_.is_open() && !second_.is_second() && second_.behind() > second_.first(); }
  /// Behind a tick of the first run. `recorded_save`: of the trace, for the state now.
  int after_first_run(std::optional<Bytes> recorded_save);
  /// Behind a tick of the second run.
  int end_second(std::uint64_t tick);
  int differs(std::uint64_t tick, const KeptState* first, const std::string& reason, std::string_view stage);
  int input_of_second(void* data, std::size_t size);
  int begin_second_tick(double* dt);
  void judge_second_runs();
  /// Behind a tick, where `ticktrue unsaved` looks for what the save forgets.
  int after_probed_tick();
  void tell_probe(const char* table, const char* column, const ColumnSource& source);
  /// Ticks that the first run has done.
  std::uint64_t ticks_done() const { return second_.is_second() ? std::max(tick_, second_.behind()) : tick_; }

  Identity identity_;
  ProgramFacts facts_;
  std::string path_;
  std::uint32_t flags_ = 0;
  std::uint32_t rollback_max_ = 0;
  double default_dt_ = 0;  // s
  Bytes setup_;
  std::optional<Recording> recording_;
  std::optional<Comparing> comparing_;
  std::optional<Peers> peers_;  // always, but in a session that has failed before it began
  bool is_live_ = false;        // nothing is recorded or verified
  double live_time_s_ = 0;
  std::uint64_t live_root_ = 0;          // of the last confirmed tick
  std::vector<std::string> live_notes_;  // of the report
  ChangeSummary changes_;
  bool is_recording_lost_ = false;
  std::vector<std::string> file_notes_;    // about bundles and saved boxes
  std::string desync_text_, desync_json_;  // of the report

  GatheredState state_;
  struct Namer {
    ticktrue_namer call = nullptr;
    void* user = nullptr;
  };
  std::map<std::string, Namer, std::less<>> namers_;  // by table
  std::vector<std::string> stages_;

  Phase phase_ = Phase::registering;
  int status_ = TICKTRUE_OK;
  std::string message_;
  std::string refusal_;
  int exit_code_ = 0;

  std::uint64_t tick_ = 0;        // ticks done
  std::uint64_t confirmed_ = 0;   // of them
  double dt_ = 0;                 // of the tick that runs
  Bytes inputs_;                  // of the tick that begins next, or runs
  std::size_t inputs_taken_ = 0;  // verify: bytes returned
  std::size_t stages_done_ = 0;
  std::vector<std::uint64_t> stage_hashes_;
  std::deque<PendingTick> pending_;
  SessionMarks marks_;
  std::vector<replay::Note> notes_;  // of the tick that runs or begins next, not yet written
  bool has_dropped_marks_ = false;   // of a recording that stores none
  bool takes_calls_ = false;         // marks of the preload library
  std::string calls_warning_;
  const void* tick_thread_ = nullptr;  // an address of the thread in whose tick marks count
  std::unique_ptr<TrailLog> trail_;    // of a verification that `ticktrue trail` runs

  std::unique_ptr<Probe> probe_;  // of a verification that `ticktrue unsaved` runs
  SaveCalls saves_;
  bool in_callback_ = false;
  bool is_gathering_ = false;  // the callback gives elements of a child table
  std::uint64_t from_ = 0;     // verify
  std::uint32_t sync_ticks_ = 0;
  bool restores_ = false;
  SecondRun second_;
  std::optional<Bytes> next_save_;  // restore: of the state behind the ticks that run a second time
  std::uint64_t second_count_ = 0;  // ticks that ran twice with the same result
  std::uint64_t second_run_count_ = 0;
  bool begins_twice_ = true;  // the next second run
  std::uint64_t load_count_ = 0;
  std::uint64_t missing_saves_ = 0;  // that a sync test asked for
};

}  // namespace ticktrue::capi
