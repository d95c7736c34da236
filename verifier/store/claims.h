// Claims: any number of processes divide units of work without a server, a lock or a common clock.
// SPDX-License-Identifier: MIT
//
// A claim of a unit is a file STORE/claims/ab/cdef....1. A worker creates it by link(2), which succeeds for only one
// process. The owner writes a counter into the file, the heartbeat. If another worker sees the same bytes for the
// length of a lease, by its own monotonic clock, it may create the next claim: cdef....2. The claim with the highest
// number counts. Each number has one owner, no claim is renamed, and an owner never writes to another owner's file.
// Clocks of different machines are never compared.
//
// After the verdict is stored, the owner removes the claims of the unit. A new owner therefore looks into the store
// again before it works. An owner that continues after its lease has ended does the same work as the new owner. Both
// store the same verdict, and the store has it once.
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

/// Whether this system supports claims (POSIX, and threads for the heartbeat).
bool can_claim();

class Claims {
 public:
  /// `now_s`: a monotonic clock, for tests; empty: the system's clock.
  Claims(const StoreFolder& folder, double lease_s, std::function<double()> now_s = {});
  Claims(const Claims&) = delete;
  Claims& operator=(const Claims&) = delete;
  ~Claims();  // gives up all held units

  enum class Answer { won, busy };
  /// Thread-safe. Errors: io, limit.
  Result<Answer> try_claim(const std::string& unit);
  /// To be called after the verdict is stored. Removes the claims of the unit, unless another worker has taken it over.
  void finish(const std::string& unit);
  /// Gives up a unit without a verdict: the next worker may claim it at once.
  void give_up(const std::string& unit);
  /// Whether this object holds the unit, and no other worker has taken it over.
  bool is_held(const std::string& unit) const;

  /// Starts a thread that renews the claims several times per lease.
  void start_heartbeat();
  /// Writes the counters of all held units.
  void beat();
  /// Renews the claims several times per lease, for a process without threads. To be called far more often.
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

  StoreFolder folder_;  // a claim need not survive a power failure
  double lease_s_;
  std::function<double()> now_s_;
  mutable std::mutex lock_;
  std::uint64_t claim_count_ = 0;
  std::map<std::string, std::unique_ptr<Held>> held_;
  std::map<std::string, Seen> seen_;  // the claims of others, and the time since they are unchanged
  std::unique_ptr<Heartbeat> heartbeat_;
  double last_beat_s_ = 0;
};

}  // namespace ticktrue::verifier
