// Claims as numbered files, and the thread that renews them.
// SPDX-License-Identifier: MIT
//
// Verified: races of threads and of processes for a free unit and for an expired unit, clocks that differ, a worker
// that stops for longer than its lease and continues. Not verified: two machines on a real NFS server.
#include "verifier/store/claims.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <utility>
#include <vector>

#if !defined(_WIN32) && !defined(__EMSCRIPTEN__) && defined(TICKTRUE_HAS_THREADS)
#define TICKTRUE_HAS_CLAIMS 1
#include <fcntl.h>
#include <unistd.h>

#include <condition_variable>
#include <thread>

#include "replay/file/file_calls.h"
#endif

namespace ticktrue::verifier {

#ifdef TICKTRUE_HAS_CLAIMS

namespace {

constexpr std::uint64_t generation_max = 1'000;  // number of workers that died with the same unit
constexpr std::size_t claim_size_max = 4096;
constexpr double beats_in_lease = 6;
constexpr std::string_view free_state = "state free\n";
constexpr std::string_view held_state = "state held\n";

/// All texts of one owner have the same length, because each overwrites the last.
Bytes claim_text(const std::string& owner, std::uint64_t beat, std::string_view state) {
  std::string count = std::to_string(beat);
  constexpr std::size_t width = 20;
  count.insert(0, width - count.size(), '0');
  const std::string text = "ticktrue claim 1\nowner " + owner + "\nbeat " + count + "\n" + std::string(state);
  return Bytes(text.begin(), text.end());
}

bool says_free(const Bytes& bytes) {
  return bytes.size() > free_state.size() && std::equal(free_state.rbegin(), free_state.rend(), bytes.rbegin());
}

double system_now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

struct Claims::Held {
  std::uint64_t generation = 0;
  std::string owner;
  std::uint64_t beat_count = 0;
  int descriptor = -1;  // stays open: writes go to this claim, even after it was renamed

  Held() = default;
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  ~Held() {
    if (descriptor >= 0) ::close(descriptor);
  }
  bool write(std::string_view state) {
    const Bytes text = claim_text(owner, ++beat_count, state);
    return ::pwrite(descriptor, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()) &&
           ::fsync(descriptor) == 0;
  }
};

class Claims::Heartbeat {
 public:
  Heartbeat(Claims& claims, double period_s) : thread_([this, &claims, period_s] { run(claims, period_s); }) {}
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;
  ~Heartbeat() {
    {
      const std::lock_guard<std::mutex> guard(lock_);
      ends_ = true;
    }
    wake_.notify_all();
    thread_.join();
  }

 private:
  void run(Claims& claims, double period_s) {
    std::unique_lock<std::mutex> guard(lock_);
    while (!wake_.wait_for(guard, std::chrono::duration<double>(period_s), [this] { return ends_; })) {
      guard.unlock();
      claims.beat();
      guard.lock();
    }
  }
  std::mutex lock_;
  std::condition_variable wake_;
  bool ends_ = false;
  std::thread thread_;  // last member: it uses the others
};

bool can_claim() {
  return true;
}

Claims::Claims(const StoreFolder& folder, double lease_s, std::function<double()> now_s)
    : folder_(folder.unsynced()), lease_s_(lease_s), now_s_(now_s ? std::move(now_s) : system_now_s) {}

Claims::~Claims() {
  heartbeat_.reset();
  std::vector<std::string> units;
  for (const auto& [unit, held] : held_) units.push_back(unit);
  for (const std::string& unit : units) give_up(unit);
}

std::string Claims::name_of(const std::string& unit, std::uint64_t generation) const {
  return "claims/" + spread_name(unit) + "." + std::to_string(generation);
}

Result<Claims::Answer> Claims::try_claim(const std::string& unit) {
  {
    const std::lock_guard<std::mutex> guard(lock_);
    if (held_.count(unit) != 0) return Answer::busy;
  }
  Bytes last;
  std::uint64_t generation = 0;
  for (;; ++generation) {
    Result<std::optional<Bytes>> bytes = folder_.read(name_of(unit, generation + 1), claim_size_max);
    if (!bytes) return bytes.error();
    if (!*bytes) break;
    last = std::move(**bytes);
    if (generation + 1 == generation_max)
      return Error{ErrorCode::limit,
                   folder_.path_of(name_of(unit, generation_max)) + ": found so many claims of a " +
                       "unit whose workers ended, expected fewer",
                   "find out why they end; then remove the claims"};
  }
  if (generation > 0 && !may_follow(unit, generation, last)) return Answer::busy;
  return take(unit, generation + 1);
}

/// Whether the unit's last claim was given up, or was unchanged for the length of a lease.
bool Claims::may_follow(const std::string& unit, std::uint64_t generation, const Bytes& bytes) {
  if (says_free(bytes)) return true;
  const double now_s = now_s_();
  const std::lock_guard<std::mutex> guard(lock_);
  Seen& seen = seen_[unit];
  if (seen.generation != generation || seen.bytes != bytes) seen = Seen{generation, bytes, now_s};
  return now_s - seen.since_s >= lease_s_;
}

Result<Claims::Answer> Claims::take(const std::string& unit, std::uint64_t generation) {
  auto held = std::make_unique<Held>();
  held->generation = generation;
  {
    // Each claim of this process has its own number, because two threads are two workers.
    const std::lock_guard<std::mutex> guard(lock_);
    held->owner = folder_.owner() + "-" + std::to_string(++claim_count_);
  }
  const std::string name = name_of(unit, generation);
  const Bytes text = claim_text(held->owner, 0, held_state);
  const Result<StoreFolder::Publish> published = folder_.publish(name, text);
  if (!published) return published.error();
  if (*published == StoreFolder::Publish::exists) return Answer::busy;
  held->descriptor = replay::open_file(folder_.path_of(name), O_RDWR);
  if (held->descriptor < 0 && errno != ENOENT)
    return replay::io_error(folder_.path_of(name), "cannot open what was just made", errno);
  // No other process may write to the file between the two calls. But the verdict may be stored, and the file removed.
  Bytes found(text.size());
  const bool is_mine = held->descriptor >= 0 &&
                       ::pread(held->descriptor, found.data(), found.size(), 0) == static_cast<ssize_t>(found.size()) &&
                       found == text;
  if (!is_mine) return Answer::busy;
  const std::lock_guard<std::mutex> guard(lock_);
  seen_.erase(unit);
  held_[unit] = std::move(held);
  return Answer::won;
}

void Claims::finish(const std::string& unit) {
  std::unique_ptr<Held> held;
  {
    const std::lock_guard<std::mutex> guard(lock_);
    const auto found = held_.find(unit);
    if (found == held_.end()) return;
    held = std::move(found->second);
    held_.erase(found);
  }
  if (folder_.exists(name_of(unit, held->generation + 1))) {
    held->write(free_state);  // for the case that the next claim is removed before this one
    return;
  }
  for (std::uint64_t generation = 1; generation <= held->generation; ++generation)
    folder_.remove(name_of(unit, generation));
}

void Claims::give_up(const std::string& unit) {
  std::unique_ptr<Held> held;
  {
    const std::lock_guard<std::mutex> guard(lock_);
    const auto found = held_.find(unit);
    if (found == held_.end()) return;
    held = std::move(found->second);
    held_.erase(found);
  }
  held->write(free_state);
}

bool Claims::is_held(const std::string& unit) const {
  std::uint64_t generation = 0;
  {
    const std::lock_guard<std::mutex> guard(lock_);
    const auto found = held_.find(unit);
    if (found == held_.end()) return false;
    generation = found->second->generation;
  }
  return !folder_.exists(name_of(unit, generation + 1));
}

void Claims::start_heartbeat() {
  heartbeat_ = std::make_unique<Heartbeat>(*this, lease_s_ / beats_in_lease);
}

void Claims::beat() {
  const std::lock_guard<std::mutex> guard(lock_);
  // If a claim cannot be written, it expires, and another worker does the unit.
  for (const auto& [unit, held] : held_) held->write(held_state);
}

void Claims::beat_when_due() {
  const double now_s = now_s_();
  if (now_s - last_beat_s_ < lease_s_ / beats_in_lease) return;
  last_beat_s_ = now_s;
  beat();
}

#else

struct Claims::Held {};
class Claims::Heartbeat {};

bool can_claim() {
  return false;
}

Claims::Claims(const StoreFolder& folder, double lease_s, std::function<double()> now_s)
    : folder_(folder.unsynced()), lease_s_(lease_s), now_s_(std::move(now_s)) {}
Claims::~Claims() = default;
Result<Claims::Answer> Claims::try_claim(const std::string&) {
  return Error{ErrorCode::unsupported, "--claim: this system has no claims", "share the work by --shard I/N"};
}
void Claims::finish(const std::string&) {}
void Claims::give_up(const std::string&) {}
bool Claims::is_held(const std::string&) const {
  return false;
}
void Claims::start_heartbeat() {}
void Claims::beat() {}
void Claims::beat_when_due() {}

#endif

}  // namespace ticktrue::verifier
