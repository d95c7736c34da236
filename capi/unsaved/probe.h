// Finds what a save forgets: copies of the process run the same ticks, with single variables as load left them.
// SPDX-License-Identifier: MIT
//
// A window is a few ticks after a save. At its begin the process forks. The copy runs the ticks, loads the save,
// publishes its memory, and runs the ticks again. If the second run ends in another state, the process compares the
// published memory with its own memory, which load should have restored. Then further copies of the process run the
// ticks, each with some of the differences written into its memory. A copy that ends in another state has the cause.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/state/gathered_state.h"
#include "capi/unsaved/units.h"

namespace ticktrue::capi {

/// The variable with the name of the file for the findings. It turns the search on.
inline constexpr const char* unsaved_variable = "TICKTRUE_UNSAVED";

/// A column that load registered again at another place.
struct MovedColumn {
  std::string table, column;  // column empty: the rows of a table of structs
  ColumnSource source;
};

struct WindowResult;  // in memory that the process shares with its copies

class Probe {
 public:
  /// Null unless the variable is set. Only the first session of the process gets a probe.
  static std::unique_ptr<Probe> from_environment();
  ~Probe();
  Probe(const Probe&) = delete;
  Probe& operator=(const Probe&) = delete;

  /// `watching`: the process itself. The other roles are copies.
  enum class Role : std::uint8_t { watching, straight, trial };
  Role role() const { return role_; }
  bool is_copy() const { return role_ != Role::watching; }

  bool wants_window(std::uint64_t tick) const { return tick >= next_ && !has_ended_; }
  std::uint64_t length() const { return length_; }  // ticks of a window
  using Register = std::function<bool(const MovedColumn&)>;
  /// Returns true in a copy, which must then run the ticks. A `straight` copy must load the save after these ticks.
  bool run_window(std::uint64_t tick, const StateView& state, const Register& apply);
  void no_save(std::uint64_t tick);

  // For copies. These functions may end the process.
  void tick_ended(std::uint64_t tick, const StateView& state, bool is_second);
  void column_moved(const MovedColumn& column);
  void loaded(const StateView& state);
  [[noreturn]] void load_failed(const std::string& message);
  [[noreturn]] void leave();  // the program leaves the window early

  /// Records why nothing can be compared; empty: nothing prevents it.
  void refuse(const std::string& reason, const std::string& hint);
  void finish(std::uint64_t ticks_run);

 private:
  explicit Probe(std::string path);
  struct Finding {
    std::uint64_t tick = 0;
    std::uint64_t window = 0;
    std::vector<std::string> columns;
    std::vector<Unit> units;
    bool has_crashed = false;
    bool is_joint = false;  // only several units together move a column
  };
  struct Trial {
    bool has_moved = false;
    bool has_crashed = false;
    std::uint64_t tick = 0;
    std::vector<std::string> columns;
  };
  using Groups = std::vector<std::size_t>;

  bool map_window(const StateView& state);
  void unmap_window();
  void copy_memory();
  bool fork_copy(Role role, int limit_ms);
  void compare_with_copy();
  bool examine();
  bool search(const Groups& groups, const Trial* known);
  /// Whether this window has used up its trials or its time.
  bool is_spent() const;
  Trial try_groups(const Groups& groups);
  void write_groups(const Groups& groups);
  void add_finding(const Groups& groups, const Trial& trial, bool is_joint);
  void note_harmless();
  std::vector<std::string> moved_columns() const;
  void write_log() const;

  std::string path_;
  Role role_ = Role::watching;
  std::uint64_t next_ = 1;    // tick of the next window
  std::uint64_t length_ = 5;  // ticks
  std::uint64_t begin_ = 0;   // tick of the current window
  bool has_ended_ = false;

  // The current window.
  WindowResult* shared_ = nullptr;
  std::uint64_t shared_size_ = 0;
  std::uint64_t column_count_ = 0;
  std::uint64_t* hashes_ = nullptr;  // [tick - begin_][column]
  std::uint8_t* copied_ = nullptr;   // ranges, then the heap
  std::uint64_t heap_room_ = 0;      // capacity of the copied heap, bytes
  const StateSchema* schema_ = nullptr;
  ProgramMemory memory_;
  shim::KeptHeap heap_{};
  OtherMemory other_;
  Differences differences_;
  std::vector<std::ptrdiff_t> moved_group_;
  Register apply_;
  std::uint64_t trials_here_ = 0;
  std::uint64_t trials_ms_ = 0;  // total time of the trials
  std::uint64_t copy_ms_ = 0;    // time of the last copy
  int trial_limit_ms_ = 0;       // limit for a trial

  // For the report.
  std::vector<Finding> findings_;
  std::vector<Finding> unexplained_;
  std::vector<Finding> not_loaded_;
  std::vector<Unit> harmless_;
  std::set<std::string> known_;  // keys of units that move columns
  std::set<std::string> seen_;   // keys of harmless_
  std::vector<LoadedModule> modules_;
  std::uint64_t window_count_ = 0, moved_count_ = 0, trial_count_ = 0, lost_count_ = 0, missing_saves_ = 0;
  std::uint64_t unexamined_count_ = 0;  // windows with moved columns that were not examined completely
  std::uint64_t threads_ = 0, left_out_ = 0, ticks_run_ = 0;
  std::string refusal_, hint_;
  std::string lost_reason_;
};

}  // namespace ticktrue::capi
