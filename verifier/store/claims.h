// Who works on what: any number of processes share units without a server, a lock or a clock.
// SPDX-License-Identifier: MIT
//
// A claim of a unit is a file STORE/claims/ab/cdef....1 that a worker links to the name; link(2) has one winner. The
// owner writes a counter into it, the heartbeat. A worker that sees the same bytes for the length of a lease, by its
// own monotonic clock, may link the next one: cdef....2. The claim with the highest number counts. Each number has one
// winner, no claim is renamed, and an owner never writes to the file of another. Clocks of machines are not compared.
//
// After the verdict is stored, the owner removes the claims of the unit. A winner therefore asks the store once more
// before it works. An owner that comes back after its lease works on what another worker has, too: both store the same
// verdict, once.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "verifier/store/store_folder.h"

namespace ticktrue::verifier {

/// Whether this system has what claims need (POSIX, and threads for the heartbeat).
bool can_claim();

class Claims {
 public:
  /// `now_s`: a monotonic clock, for tests; empty: that of the system.
  Claims(const StoreFolder& folder, double lease_s, std::function<double()> now_s = {});
  Claims(const Claims&) = delete;
  Claims& operator=(const Claims&) = delete;
  ~Claims();  // gives up what is held

  enum class Answer { won, busy };
  /// Any thread. Errors: io, limit.
  Result<Answer> try_claim(const std::string& unit);
  /// The verdict is stored: removes the claims of the unit, unless another worker has taken it over.
  void finish(const std::string& unit);
  /// There is no verdict: the next worker may claim the unit at once.
  void give_up(const std::string& unit);
  /// Whether no other worker has taken the unit over.
  bool is_held(const std::string& unit) const;

  /// From here on a thread of this object beats, several times in a lease.
  void start_heartbeat();
  /// Writes the counters of all that is held.
  void beat();
  /// The same several times in a lease, for a process without threads: called far more often.
  void beat_when_due();

 private:
  struct Held;
  struct Seen {
    std::uint64_t generation = 0;
    Bytes bytes;
    double since_s = 0;
  };
  class Heartbeat;

  std::string name_of(const std::string& unit, std::uint64_t generation) const;
  bool may_follow(const std::string& unit, std::uint64_t generation, const Bytes& bytes);
  Result<Answer> take(const std::string& unit, std::uint64_t generation);

  StoreFolder folder_;  // a claim need not outlive a loss of power
  double lease_s_;
  std::function<double()> now_s_;
  mutable std::mutex lock_;
  std::uint64_t claim_count_ = 0;
  std::map<std::string, std::unique_ptr<Held>> held_;
  std::map<std::string, Seen> seen_;  // claims of others, and since when they are as they are
  std::unique_ptr<Heartbeat> heartbeat_;
  double last_beat_s_ = 0;
};

}  // namespace ticktrue::verifier
