// A session behind the C interface: registered state, the order of calls, and ticks that wait for confirmation.
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

/// Each call returns a status of the C interface. The first status other than TICKTRUE_OK is kept.
class Session {
 public:
  /// Checks and copies the options, and opens the trace of a verification.
  explicit Session(const ticktrue_options& options);
  /// Makes a session that has already failed.
  explicit Session(const Error& error) { fail(error); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  int status() const { return status_; }
  /// Why the session failed or lost its recording.
  const std::string& message() const { return message_; }
  /// message(), else why the last call was refused.
  const std::string& last_message() const { return message_.empty() ? refusal_ : message_; }
  std::uint64_t tick() const { return tick_; }
  ByteView setup() const;

  int build_facts(const char* unit, const char* facts);
  int column(const char* table, const char* name, const void* data, int type, std::uint32_t lanes, std::uint32_t rows,
             std::size_t stride);
  /// `table_number`: set to the number of the new table.
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
  /// Counts a simple mark. False: nothing was done, and the caller must call mark().
  bool mark_quickly(const char* name, std::uint64_t value) {
    if (status_ != TICKTRUE_OK) return false;
    if (phase_ != Phase::inside) return true;
    return marks_.add_again(name, value) || (has_dropped_marks_ && !marks_.is_on());
  }
  /// `caller`: the return address of the program's call; null: unknown.
  int mark(const char* name, std::uint64_t value, const void* caller);
  int note(const char* topic, const char* text);
  int begin_tick(double* dt);
  int end_tick();
  int rewind(std::uint64_t tick);
  int confirm(std::uint64_t tick);
  int seek(std::uint64_t tick);

  // ---- Other players (session_peers.cpp) ----

  int root(std::uint64_t tick, std::uint64_t* root);
  /// Returns the size of the hello. Writes it if it fits. 0: the session has failed.
  std::size_t hello(void* buffer, std::size_t size);
  int hello_check(std::uint32_t peer, const void* bytes, std::size_t size, char* text, std::size_t text_size);
  int peer_root(std::uint32_t peer, std::uint64_t tick, std::uint64_t root);
  std::size_t desync_message(std::uint32_t peer, void* buffer, std::size_t size);
  int desync_receive(std::uint32_t peer, const void* bytes, std::size_t size);
  /// Writes a bundle about a desync. If the file cannot be written, the call is refused and the session continues.
  int bundle(const char* path);
  /// Writes the current content of the black box as a trace. Failures as for bundle().
  int box_save(const char* path);
  /// Empty: no desync is known.
  std::string desync_report(bool& is_complete);

  /// Closes the session, decides the verdict and returns the exit code. A second call returns the same exit code.
  int finish();
  bool is_finished() const { return phase_ == Phase::finished; }
  /// Whether the program calls from inside a callback. If so, the session fails.
  bool refuse_in_callback(const char* what);
  bool is_quiet() const { return (flags_ & TICKTRUE_QUIET) != 0; }
  bool wants_json() const { return (flags_ & TICKTRUE_JSON) != 0; }
  /// Requires: is_finished(). Empty: the session failed.
  std::string report_text() const;
  std::string report_json() const;
  /// The report as JSON, also for a failed verification; empty for a recording.
  std::string result_json() const;

  /// Makes the session fail with an error from outside, such as exhausted memory.
  int fail(const Error& error);

 private:
  enum class Phase { registering, between, inside, finished };

  /// A tick that has run and is not confirmed, with the state after it.
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
  /// Copies the registered state. Calls the callbacks of child tables.
  Status gather();
  int wrong_order(const std::string& what, const std::string& hint);
  bool can_call(const char* what);
  int start();
  bool wants_stages(const RecordedTick* recorded) const;
  /// The recorded tick that begins next; null: the end of the trace.
  const RecordedTick* recorded();
  int take(DoneTick done);
  int write_notes();
  /// Makes the preload library mark calls, if the environment asks for it.
  void take_calls();
  static void take_call(void* session, const char* name, std::uint64_t value, const void* caller);
  MarkDetail mark_detail() const;
  int confirm_pending(std::uint64_t tick);
  RowNamer namer();
  int finish_recording();
  /// Handles a failed write. If the disk is full, the recording ends and the session continues. Other errors fail the
  /// session.
  int recording_failed(const Error& error);
  bool is_recording() const { return recording_ && !is_recording_lost_; }
  int begin_recorded_tick(double dt, ByteView inputs);
  void take_live_tick(const DoneTick& done);
  bool can_call_peers(const char* what, std::uint32_t peer);
  bool know_game();
  replay::TraceSetup game_setup() const;
  /// Refuses a call that changed nothing. The session continues.
  int refuse(const Error& error);
  int peers_status() const { return peers_->has_desync() ? TICKTRUE_DIVERGED : TICKTRUE_OK; }
  /// Adds what is known about the other players to the report.
  void report_peers();
  std::string live_text() const;
  std::string live_json() const;

  // ---- Saves and second runs (session_runs.cpp) ----

  /// Calls the save callback. `bytes`: nothing if the program has no save now. False: the session has failed.
  bool save_now(std::optional<Bytes>& bytes);
  /// False: the session has failed.
  bool gather_shown(std::optional<Bytes>& bytes);
  /// Calls the load callback and gathers the state. False: the session has failed.
  bool load_now(std::uint64_t tick, ByteView bytes);
  bool open_sync_block();
  /// Loads the save from the begin of the ticks that ran once: they run again. False: the session has ended.
  bool go_back();
  bool can_go_back() const { return second_.is_open() && !second_.is_second() && second_.behind() > second_.first(); }
  /// To be called after a tick of the first run. `recorded_save`: the save of the trace for the present state.
  int after_first_run(std::optional<Bytes> recorded_save);
  /// To be called after a tick of the second run.
  int end_second(std::uint64_t tick);
  int differs(std::uint64_t tick, const KeptState* first, const std::string& reason, std::string_view stage);
  int input_of_second(void* data, std::size_t size);
  int begin_second_tick(double* dt);
  void judge_second_runs();
  /// To be called after a tick, while `ticktrue unsaved` looks for what the save forgets.
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
  std::optional<Peers> peers_;  // absent only in a session that failed before it began
  bool is_live_ = false;        // nothing is recorded or verified
  double live_time_s_ = 0;
  std::uint64_t live_root_ = 0;          // of the last confirmed tick
  std::vector<std::string> live_notes_;  // notes of the report
  ChangeSummary changes_;
  std::vector<std::uint64_t> table_hashes_;  // of the last state whose root was hashed
  bool is_recording_lost_ = false;
  std::vector<std::string> file_notes_;    // notes about bundles and saved boxes
  std::string desync_text_, desync_json_;  // text and JSON of the report

  GatheredState state_;
  struct Namer {
    ticktrue_namer call = nullptr;
    void* user = nullptr;
  };
  std::map<std::string, Namer, std::less<>> namers_;  // by name of the table
  std::vector<std::string> stages_;

  Phase phase_ = Phase::registering;
  int status_ = TICKTRUE_OK;
  std::string message_;
  std::string refusal_;
  int exit_code_ = 0;

  std::uint64_t tick_ = 0;        // ticks done
  std::uint64_t confirmed_ = 0;   // confirmed ticks
  double dt_ = 0;                 // of the running tick
  Bytes inputs_;                  // of the tick that runs, or begins next
  std::size_t inputs_taken_ = 0;  // verify: bytes returned to the program
  std::size_t stages_done_ = 0;
  std::vector<std::uint64_t> stage_hashes_;
  std::deque<PendingTick> pending_;
  SessionMarks marks_;
  std::vector<replay::Note> notes_;  // not written yet, of the tick that runs or begins next
  bool has_dropped_marks_ = false;   // a recording without marks dropped some
  bool takes_calls_ = false;         // the preload library marks calls
  std::string calls_warning_;
  const void* tick_thread_ = nullptr;  // an address of the thread whose marks count in the running tick
  std::unique_ptr<TrailLog> trail_;    // of a verification under `ticktrue trail`

  std::unique_ptr<Probe> probe_;  // of a verification under `ticktrue unsaved`
  SaveCalls saves_;
  bool in_callback_ = false;
  bool is_gathering_ = false;  // a callback returns elements of a child table
  std::uint64_t from_ = 0;     // verify: first tick
  std::uint32_t sync_ticks_ = 0;
  bool restores_ = false;
  SecondRun second_;
  std::optional<Bytes> next_save_;  // restore: the save after the ticks that run a second time
  std::uint64_t second_count_ = 0;  // ticks whose second run had the same result
  std::uint64_t second_run_count_ = 0;
  bool begins_twice_ = true;  // whether the next second run begins twice
  std::uint64_t load_count_ = 0;
  std::uint64_t missing_saves_ = 0;  // saves that a sync test requested and the program did not have
};

}  // namespace ticktrue::capi
