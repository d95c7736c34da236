// Windows: copies of the process, and their results in shared memory.
// SPDX-License-Identifier: MIT
#include "capi/unsaved/probe.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <utility>

#include "base/hash.h"
#include "base/state/schema.h"
#include "capi/marks/shake_page.h"
#include "capi/unsaved/window.h"

#ifdef __linux__
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#endif

namespace ticktrue::capi {

#ifdef __linux__
namespace {

constexpr std::uint64_t heap_room_max = std::uint64_t{512} << 20;
constexpr std::uint64_t lengths[] = {5, 13, 31};  // lengths of windows in ticks, by rotation
constexpr std::uint64_t dense_windows = 100;      // the first windows, which overlap
constexpr std::uint64_t dense_step = 4;           // ticks between the begins of these windows
// A trial runs as many ticks as the window. If it takes this many times as long plus a second, it hangs.
constexpr std::uint64_t times_of_window = 10;
constexpr std::uint64_t trial_time_least_ms = 1'000;
constexpr std::uint64_t harmless_windows = 6;  // windows without moved columns whose differences are recorded

std::size_t count_columns(const StateSchema& schema) {
  std::size_t count = 0;
  for (const TableSchema& table : schema.tables) count += table.columns.size() + 1;
  return count;
}

/// Computes one hash for each column, and one for the row count of each table.
void hash_columns(const StateView& state, std::uint64_t* hashes) {
  Bytes values;
  for (std::size_t t = 0; t < state.tables.size(); ++t) {
    const TableSchema& table = state.schema->tables[t];
    const TableRows& rows = state.tables[t];
    *hashes++ = rows.row_count;
    for (const Column& column : table.columns) {
      values.clear();
      const std::size_t size = std::size_t{scalar_info(column.type)->size} * column.lane_count;
      for (std::size_t row = 0; row < rows.row_count && !column.is_shown; ++row) {
        const std::uint8_t* at = rows.data + row * table.row_size + column.offset;
        values.insert(values.end(), at, at + size);
      }
      *hashes++ = hash64(values);
    }
  }
}

/// The clock of the system itself: the program may see other clocks.
std::uint64_t now_ms() {
  timespec now{};
  ::syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000 + static_cast<std::uint64_t>(now.tv_nsec) / 1'000'000;
}

/// Waits for the end of a process, and kills it after `limit_ms`. Returns its status.
int wait_for(pid_t process, int limit_ms) {
  const int file = static_cast<int>(::syscall(SYS_pidfd_open, process, 0));
  if (file >= 0) {
    pollfd ended{file, POLLIN, 0};
    if (::poll(&ended, 1, limit_ms) == 0) ::kill(process, SIGKILL);
    ::close(file);
  }
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) continue;
  return status;
}

/// Makes a copy print nothing and end with its parent process.
void become_copy() {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nothing < 0) return;
  for (const int stream : {1, 2}) ::dup2(nothing, stream);
  ::close(nothing);
}

void copy_name(const std::string& name, char* out) {
  const std::size_t size = std::min(name.size(), name_room - 1);
  std::memcpy(out, name.data(), size);
  out[size] = 0;
}

}  // namespace

std::unique_ptr<Probe> Probe::from_environment() {
  static bool is_taken = false;
  const char* path = std::getenv(unsaved_variable);
  if (path == nullptr || *path == 0 || std::exchange(is_taken, true)) return nullptr;
  return std::unique_ptr<Probe>(new Probe(path));
}

Probe::Probe(std::string path) : path_(std::move(path)) {
  write_log();
}

Probe::~Probe() {
  unmap_window();
}

bool Probe::map_window(const StateView& state) {
  schema_ = state.schema;
  column_count_ = count_columns(*schema_);
  std::uint64_t ranges = 0;
  for (const MemoryRange& range : memory_.ranges) ranges += range.size;
  const std::uint64_t flags = (column_count_ + 7) / 8 * 8;
  const std::uint64_t hashes = (length_ + 1) * column_count_ * sizeof(std::uint64_t);
  heap_room_ = heap_room_max;
  shared_size_ = (sizeof(WindowResult) + 7) / 8 * 8 + flags + hashes + (ranges + 15) / 16 * 16 + 16 + heap_room_;
  void* at = ::mmap(nullptr, shared_size_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (at == MAP_FAILED) return false;
  shared_ = static_cast<WindowResult*>(at);
  auto* bytes = static_cast<std::uint8_t*>(at) + (sizeof(WindowResult) + 7) / 8 * 8 + flags;
  hashes_ = reinterpret_cast<std::uint64_t*>(bytes);
  copied_ = bytes + hashes;
  hash_columns(state, hashes_);
  return true;
}

void Probe::unmap_window() {
  if (shared_ != nullptr) ::munmap(shared_, shared_size_);
  shared_ = nullptr;
}

bool Probe::fork_copy(Role role, int limit_ms) {
  shared_->end = CopyEnd::none;
  shared_->has_crashed = 0;
  const pid_t process = ::fork();
  if (process == 0) {
    enter_library_again();
    become_copy();
    role_ = role;
    return true;
  }
  if (process > 0) {
    const std::uint64_t begin = now_ms();
    const int status = wait_for(process, limit_ms);
    copy_ms_ = now_ms() - begin;
    shared_->has_crashed = WIFSIGNALED(status) && shared_->end == CopyEnd::none ? 1 : 0;
  }
  enter_library_again();
  return false;
}

bool Probe::run_window(std::uint64_t tick, const StateView& state, const Register& apply) {
  begin_ = tick;
  next_ = tick + (window_count_ < dense_windows ? std::min(length_, dense_step) : length_);
  if (const std::size_t threads = thread_count(); threads > 1) {
    threads_ = threads;
    return false;
  }
  memory_ = program_memory(library_frame());
  modules_ = memory_.modules;
  heap_ = kept_heap();
  apply_ = apply;
  if (!map_window(state)) return false;
  ++window_count_;
  {
    const ParkedGenerator parked;  // so that the state stores its position
  }
  if (fork_copy(Role::straight, copy_time_ms)) {
    keep_heap_blocks(heap_);
    return true;
  }
  const std::uint64_t trial_limit = trial_time_least_ms + times_of_window * copy_ms_;
  trial_limit_ms_ = static_cast<int>(std::min<std::uint64_t>(trial_limit, copy_time_ms));
  left_out_ = std::max(left_out_, memory_.left_out);
  bool is_copy = false;
  switch (shared_->end) {
    case CopyEnd::moved:
      is_copy = examine();
      break;
    case CopyEnd::same:
      note_harmless();
      break;
    case CopyEnd::load_differs: {
      Finding finding;
      finding.tick = finding.window = tick;
      finding.columns = moved_columns();
      if (not_loaded_.empty()) not_loaded_.push_back(std::move(finding));
      break;
    }
    case CopyEnd::load_failed:
      lost_reason_ = shared_->message;
      [[fallthrough]];
    default:
      ++lost_count_;
      if (lost_reason_.empty())
        lost_reason_ = shared_->has_crashed != 0 ? "the program crashed or hung behind its load callback"
                                                 : "the loop of the program left the ticks that came again";
  }
  if (is_copy) return true;
  unmap_window();
  write_log();
  const auto* now = std::find(std::begin(lengths), std::end(lengths), length_);
  length_ = now + 1 == std::end(lengths) ? lengths[0] : now[1];
  return false;
}

void Probe::note_harmless() {
  if (window_count_ > harmless_windows) return;
  compare_with_copy();
  for (const Unit& unit : differences_.units)
    if (harmless_.size() < 64) harmless_.push_back(unit);
}

void Probe::copy_memory() {
  std::uint8_t* to = copied_;
  { const ParkedGenerator parked; }
  shared_->frame = library_frame();
  for (const MemoryRange& range : memory_.ranges) {
    const bool is_elsewhere =
        range.kind == RangeKind::stack && reinterpret_cast<std::uint64_t>(shared_->frame) / 8 * 8 != range.begin;
    if (!is_elsewhere) std::memcpy(to, reinterpret_cast<const void*>(range.begin), range.size);
    to += range.size;
  }
  to = copied_ + (static_cast<std::uint64_t>(to - copied_) + 15) / 16 * 16;
  to += (16 - reinterpret_cast<std::uint64_t>(to) % 16) % 16;
  shared_->heap = kept_heap();
  const auto used = static_cast<std::uint64_t>(shared_->heap.top - shared_->heap.begin);
  shared_->heap_copied = std::min(used, heap_room_);
  if (shared_->heap.begin != nullptr) std::memcpy(to, shared_->heap.begin, shared_->heap_copied);
}

void Probe::compare_with_copy() {
  other_ = OtherMemory();
  const std::uint8_t* from = copied_;
  for (const MemoryRange& range : memory_.ranges) {
    const bool is_elsewhere =
        range.kind == RangeKind::stack && reinterpret_cast<std::uint64_t>(shared_->frame) / 8 * 8 != range.begin;
    if (!is_elsewhere) other_.add(range.begin, range.size, from);
    from += range.size;
  }
  from = copied_ + (static_cast<std::uint64_t>(from - copied_) + 15) / 16 * 16;
  from += (16 - reinterpret_cast<std::uint64_t>(from) % 16) % 16;
  other_.add(reinterpret_cast<std::uint64_t>(shared_->heap.begin), shared_->heap_copied, from);
  std::vector<std::uint64_t> moved;
  for (std::uint64_t i = 0; i < std::min<std::uint64_t>(shared_->moved_column_count, moved_column_count_max); ++i)
    moved.push_back(reinterpret_cast<std::uint64_t>(shared_->moved_columns[i].source.data));
  differences_ = find_differences(memory_, other_, heap_, shared_->heap, moved, moved_group_);
  left_out_ = std::max(left_out_, memory_.left_out + differences_.left_out);
}

void Probe::tick_ended(std::uint64_t tick, const StateView& state, bool is_second) {
  if (tick < begin_ || tick - begin_ >= length_) leave();
  std::uint64_t* of_tick = hashes_ + (tick + 1 - begin_) * column_count_;
  if (role_ == Role::straight && !is_second) {
    hash_columns(state, of_tick);
    shared_->straight_count = tick + 1 - begin_;
    return;
  }
  std::vector<std::uint64_t> now(column_count_);
  hash_columns(state, now.data());
  if (!std::equal(now.begin(), now.end(), of_tick)) {
    auto* flags = reinterpret_cast<std::uint8_t*>(shared_ + 1);
    for (std::size_t i = 0; i < now.size(); ++i) flags[i] = now[i] != of_tick[i] ? 1 : 0;
    shared_->tick = tick;
    shared_->end = CopyEnd::moved;
    ::_exit(0);
  }
  if (tick + 1 - begin_ < shared_->straight_count) return;
  shared_->end = CopyEnd::same;
  ::_exit(0);
}

void Probe::column_moved(const MovedColumn& column) {
  if (role_ != Role::straight || shared_->moved_column_count >= moved_column_count_max) return;
  SharedColumn& to = shared_->moved_columns[shared_->moved_column_count++];
  copy_name(column.table, to.table);
  copy_name(column.column, to.column);
  to.source = column.source;
}

void Probe::loaded(const StateView& state) {
  copy_memory();
  std::vector<std::uint64_t> now(column_count_);
  hash_columns(state, now.data());
  if (std::equal(now.begin(), now.end(), hashes_)) return;
  auto* flags = reinterpret_cast<std::uint8_t*>(shared_ + 1);
  for (std::size_t i = 0; i < now.size(); ++i) flags[i] = now[i] != hashes_[i] ? 1 : 0;
  shared_->end = CopyEnd::load_differs;
  ::_exit(0);
}

void Probe::load_failed(const std::string& message) {
  const std::size_t size = std::min(message.size(), sizeof shared_->message - 1);
  std::memcpy(shared_->message, message.data(), size);
  shared_->message[size] = 0;
  shared_->end = CopyEnd::load_failed;
  ::_exit(0);
}

void Probe::leave() {
  shared_->end = CopyEnd::lost;
  ::_exit(0);
}

std::vector<std::string> Probe::moved_columns() const {
  std::vector<std::string> names;
  const auto* flag = reinterpret_cast<const std::uint8_t*>(shared_ + 1);
  for (const TableSchema& table : schema_->tables) {
    if (*flag++ != 0) names.push_back(table.name + " (number of rows)");
    for (const Column& column : table.columns)
      if (*flag++ != 0) names.push_back(table.name + "." + column.name);
  }
  return names;
}

void Probe::no_save(std::uint64_t tick) {
  ++missing_saves_;
  next_ = tick + 1;
}

void Probe::refuse(const std::string& reason, const std::string& hint) {
  refusal_ = reason;
  hint_ = hint;
  has_ended_ = true;
  write_log();
}

void Probe::finish(std::uint64_t ticks_run) {
  if (is_copy()) leave();
  ticks_run_ = ticks_run;
  has_ended_ = true;
  write_log();
}

#endif

}  // namespace ticktrue::capi
