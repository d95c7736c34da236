// Claims: one winner for a free unit and for an expired one, among threads and processes, whatever clocks say.
// SPDX-License-Identifier: MIT
//
// Each worker has its own StoreFolder, as a process has. The test moves the clock instead of waiting.
// `ticktrue_tests "[claims][.slow]"` is the long run: 10,000 races of each kind.
#include "verifier/store/claims.h"

#include <atomic>
#include <barrier>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "verifier/runs/child_process.h"
#include "verifier/store/verdict_store.h"
#ifdef TICKTRUE_HAS_FORK
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#endif

namespace ticktrue::test {
namespace {

namespace fs = std::filesystem;
using verifier::Claims;
using verifier::FoundVerdict;
using verifier::StoreFolder;
using Answer = Claims::Answer;

constexpr double lease_s = 60;
const std::string a_unit = "00112233445566778899aabbccddeeff";

StoreFolder open_store(const std::string& path) {
  Result<StoreFolder> store = StoreFolder::open(path, StoreFolder::Use::writing, false);
  REQUIRE(store);
  return *std::move(store);
}

/// One worker, whose clock stands still unless the test turns it.
struct Worker {
  explicit Worker(const std::string& store, double start_s = 0)
      : now_s(start_s), folder(open_store(store)), claims(folder, lease_s, [this] { return now_s; }) {}
  Answer claim(const std::string& unit) {
    const Result<Answer> answer = claims.try_claim(unit);
    REQUIRE(answer);
    return *answer;
  }
  double now_s;
  StoreFolder folder;
  Claims claims;
};

std::string unit_name(int number) {
  const std::string digits = std::to_string(number);
  return std::string(6 - digits.size(), '0') + digits + "445566778899aabbccddeeff00";
}

std::vector<fs::path> claim_files(const StoreFolder& folder) {
  std::vector<fs::path> files;
  std::error_code failure;
  for (fs::recursive_directory_iterator at(folder.path_of("claims"), failure), end; !failure && at != end;
       at.increment(failure))
    if (at->is_regular_file()) files.push_back(at->path());
  return files;
}

verifier::Report match_report() {
  verifier::Report report;
  report.verdict = verifier::Verdict::match;
  report.ticks_compared = 60;
  return report;
}

using Workers = std::vector<std::unique_ptr<Worker>>;

Workers make_workers(const std::string& store, double clock_step_s) {
  Workers workers;
  for (int i = 0; i < 3; ++i) workers.push_back(std::make_unique<Worker>(store, clock_step_s * i));
  return workers;
}

/// Threads that ask for the same units in the same order, for each at once; gives the number of winners of each unit.
std::vector<int> race_of_threads(Workers& workers, int first_unit, int unit_count) {
  std::vector<std::atomic<int>> winners(static_cast<std::size_t>(unit_count));
  std::barrier<> start(static_cast<std::ptrdiff_t>(workers.size()));
  const auto run = [&](Worker& worker) {
    for (int unit = 0; unit < unit_count; ++unit) {
      start.arrive_and_wait();
      const Result<Answer> answer = worker.claims.try_claim(unit_name(first_unit + unit));
      if (!answer) winners[static_cast<std::size_t>(unit)] += 1000;
      if (answer && *answer == Answer::won) ++winners[static_cast<std::size_t>(unit)];
    }
  };
  std::vector<std::thread> threads;
  for (const auto& worker : workers) threads.emplace_back([&run, &worker] { run(*worker); });
  for (std::thread& thread : threads) thread.join();
  std::vector<int> counts;
  for (const auto& count : winners) counts.push_back(count.load());
  return counts;
}

void check_one_winner(const std::vector<int>& counts) {
  int wrong = 0;
  for (const int count : counts) wrong += count == 1 ? 0 : 1;
  CHECK(wrong == 0);
}

/// Races of three threads for free units; then, a lease later, of three others for the units of the first, which give
/// no sign of life. In parts: each claim that is held has an open file.
void race_threads(int unit_count) {
  constexpr int part_size = 250;
  const TemporaryFolder folder;
  for (int first = 0; first < unit_count; first += part_size) {
    Workers workers = make_workers(folder.file("store"), 300);
    check_one_winner(race_of_threads(workers, first, part_size));
    Workers takers = make_workers(folder.file("store"), -300);
    for (const auto& taker : takers)
      for (int unit = first; unit < first + part_size; ++unit)
        if (taker->claim(unit_name(unit)) != Answer::busy) FAIL_CHECK("a live claim was taken");
    for (const auto& taker : takers) taker->now_s += lease_s + 1;
    check_one_winner(race_of_threads(takers, first, part_size));
  }
}

#ifdef TICKTRUE_HAS_FORK
/// In a child: claims all units as soon as the gate opens, and writes the number of each that it won.
[[noreturn]] void race_in_child(const std::string& store, int first_unit, int unit_count, int gate, int result) {
  Result<StoreFolder> folder = StoreFolder::open(store, StoreFolder::Use::writing, false);
  if (!folder) ::_exit(1);
  const auto claims = std::make_unique<Claims>(*folder, lease_s);
  char go = 0;
  if (::read(gate, &go, 1) < 0) ::_exit(1);
  for (int unit = 0; unit < unit_count; ++unit) {
    const Result<Answer> answer = claims->try_claim(unit_name(first_unit + unit));
    if (!answer) ::_exit(2);
    if (*answer == Answer::won && ::write(result, &unit, sizeof unit) != sizeof unit) ::_exit(3);
  }
  ::_exit(0);  // as by kill -9: what it holds stays held
}

void race_processes_once(const std::string& store, int first_unit, int unit_count) {
  constexpr int child_count = 3;
  std::vector<int> counts(static_cast<std::size_t>(unit_count));
  int gate[2] = {-1, -1}, results[2] = {-1, -1};
  REQUIRE(::pipe2(gate, O_CLOEXEC) == 0);
  REQUIRE(::pipe2(results, O_CLOEXEC) == 0);
  std::vector<pid_t> children;
  for (int i = 0; i < child_count; ++i) {
    const pid_t id = ::fork();
    REQUIRE(id >= 0);
    if (id == 0) {
      ::close(gate[1]);
      ::close(results[0]);
      race_in_child(store, first_unit, unit_count, gate[0], results[1]);
    }
    children.push_back(id);
  }
  ::close(gate[0]);
  ::close(results[1]);
  ::close(gate[1]);  // opens the gate for all
  for (int unit = 0; ::read(results[0], &unit, sizeof unit) == sizeof unit;) ++counts[static_cast<std::size_t>(unit)];
  ::close(results[0]);
  for (const pid_t id : children) {
    int status = 0;
    REQUIRE(::waitpid(id, &status, 0) == id);
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
  }
  check_one_winner(counts);
}

void race_processes(int unit_count) {
  constexpr int part_size = 250;
  const TemporaryFolder folder;
  open_store(folder.file("store"));
  for (int first = 0; first < unit_count; first += part_size)
    race_processes_once(folder.file("store"), first, part_size);
}
#endif

#ifdef TICKTRUE_HAS_FORK
/// In a child: claims the unit, tells so, waits for the gate, and stores its verdict as if nothing had happened.
/// Its exit code is 0 if it saw that the unit is another's, and that its verdict was there.
[[noreturn]] void work_in_child(const std::string& store, double child_lease_s, int told, int gate) {
  Result<StoreFolder> folder = StoreFolder::open(store, StoreFolder::Use::writing, false);
  if (!folder) ::_exit(1);
  Claims claims(*folder, child_lease_s);
  claims.start_heartbeat();
  const Result<Answer> answer = claims.try_claim(a_unit);
  if (!answer || *answer != Answer::won || ::write(told, "c", 1) != 1) ::_exit(2);
  char go = 0;
  if (::read(gate, &go, 1) < 0) ::_exit(3);
  const bool was_held = claims.is_held(a_unit);
  const Result<FoundVerdict> stored = verifier::VerdictStore(*folder).add(a_unit, match_report());
  claims.finish(a_unit);
  ::_exit(was_held || !stored || stored->kind != FoundVerdict::Kind::verdict || stored->is_new ? 4 : 0);
}

/// Whether the claim becomes free within the time.
bool wins_within(Claims& claims, double time_s) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(time_s);
  while (std::chrono::steady_clock::now() < end) {
    const Result<Answer> answer = claims.try_claim(a_unit);
    REQUIRE(answer);
    if (*answer == Answer::won) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}
#endif

}  // namespace

TEST_CASE("claims: a worker without a heartbeat thread keeps a unit as long as it beats when due",
          "[claims][determinism]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  const TemporaryFolder folder;
  Worker owner(folder.file("store"), 1000), other(folder.file("store"));
  REQUIRE(owner.claim(a_unit) == Answer::won);
  constexpr double step_s = 5;
  for (int step = 0; step < 60; ++step) {
    owner.claims.beat_when_due();
    CHECK(other.claim(a_unit) == Answer::busy);
    owner.now_s += step_s;
    other.now_s += step_s;
  }
  CHECK(owner.claims.is_held(a_unit));
  other.now_s += 2 * lease_s;
  CHECK(other.claim(a_unit) == Answer::won);
  CHECK(!owner.claims.is_held(a_unit));
}

TEST_CASE("claims: the first worker wins, others wait, and a finished unit is free", "[verifier][claims][analytic]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  const TemporaryFolder folder;
  Worker first(folder.file("store")), second(folder.file("store"));
  CHECK(first.claim(a_unit) == Answer::won);
  CHECK(first.claim(a_unit) == Answer::busy);
  CHECK(second.claim(a_unit) == Answer::busy);
  CHECK(first.claims.is_held(a_unit));
  first.claims.finish(a_unit);
  CHECK_FALSE(first.claims.is_held(a_unit));
  CHECK(claim_files(first.folder).empty());
  CHECK(second.claim(a_unit) == Answer::won);
}

TEST_CASE("claims: a unit that was given up is free at once", "[verifier][claims][analytic]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  const TemporaryFolder folder;
  Worker second(folder.file("store"));
  {
    Worker first(folder.file("store"));
    CHECK(first.claim(a_unit) == Answer::won);
    CHECK(second.claim(a_unit) == Answer::busy);
  }
  CHECK(second.claim(a_unit) == Answer::won);
  second.claims.finish(a_unit);
  CHECK(claim_files(second.folder).empty());
}

TEST_CASE("claims: a lease lasts as long as its owner beats, by the clock of who waits",
          "[verifier][claims][analytic]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  const TemporaryFolder folder;
  Worker owner(folder.file("store"), 0), other(folder.file("store"), 300);
  CHECK(owner.claim(a_unit) == Answer::won);
  for (int i = 0; i < 20; ++i) {
    CHECK(other.claim(a_unit) == Answer::busy);
    other.now_s += 0.9 * lease_s;
    owner.claims.beat();
  }
  CHECK(other.claim(a_unit) == Answer::busy);
  other.now_s += 0.9 * lease_s;
  CHECK(other.claim(a_unit) == Answer::busy);
  other.now_s += 0.2 * lease_s;
  CHECK(other.claim(a_unit) == Answer::won);
}

TEST_CASE("claims: file times five minutes apart change nothing", "[verifier][claims][analytic]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  for (const int minutes : {-5, 5}) {
    const TemporaryFolder folder;
    Worker owner(folder.file("store")), other(folder.file("store"));
    CHECK(owner.claim(a_unit) == Answer::won);
    const auto set_times = [&] {
      for (const fs::path& file : claim_files(owner.folder))
        fs::last_write_time(file, fs::file_time_type::clock::now() + std::chrono::minutes(minutes));
    };
    set_times();
    CHECK(other.claim(a_unit) == Answer::busy);
    other.now_s += 0.9 * lease_s;
    owner.claims.beat();
    set_times();
    CHECK(other.claim(a_unit) == Answer::busy);
    other.now_s += 0.9 * lease_s;
    CHECK(other.claim(a_unit) == Answer::busy);
    other.now_s += 0.2 * lease_s;
    CHECK(other.claim(a_unit) == Answer::won);
  }
}

TEST_CASE("claims: a worker that goes on after its lease changes nothing", "[verifier][claims][analytic]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  const TemporaryFolder folder;
  Worker stopped(folder.file("store")), taker(folder.file("store")), third(folder.file("store"));
  CHECK(stopped.claim(a_unit) == Answer::won);
  CHECK(taker.claim(a_unit) == Answer::busy);
  taker.now_s += lease_s + 1;
  CHECK(taker.claim(a_unit) == Answer::won);
  CHECK_FALSE(stopped.claims.is_held(a_unit));
  CHECK(taker.claims.is_held(a_unit));

  // It beats, stores and finishes as if nothing had happened: the claim of the taker stays, and there is one verdict.
  stopped.claims.beat();
  const verifier::VerdictStore store(stopped.folder);
  const Result<FoundVerdict> late = store.add(a_unit, match_report());
  REQUIRE(late);
  stopped.claims.finish(a_unit);
  CHECK(taker.claims.is_held(a_unit));
  CHECK(third.claim(a_unit) == Answer::busy);
  const Bytes stored = read_file(stopped.folder.path_of(verifier::spread_name(a_unit)));
  const Result<FoundVerdict> again = verifier::VerdictStore(taker.folder).add(a_unit, match_report());
  REQUIRE(again);
  CHECK(again->kind == FoundVerdict::Kind::verdict);
  CHECK(read_file(stopped.folder.path_of(verifier::spread_name(a_unit))) == stored);
  taker.claims.finish(a_unit);
  CHECK(claim_files(taker.folder).empty());
}

TEST_CASE("claims: a heartbeat keeps a unit longer than its lease", "[verifier][claims][analytic]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  const TemporaryFolder folder;
  const StoreFolder owner_folder = open_store(folder.file("store")), other_folder = open_store(folder.file("store"));
  constexpr double short_lease_s = 0.6;
  Claims other(other_folder, short_lease_s);
  {
    Claims owner(owner_folder, short_lease_s);
    owner.start_heartbeat();
    REQUIRE(owner.try_claim(a_unit));
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(2 * short_lease_s);
    bool was_taken = false;
    while (std::chrono::steady_clock::now() < end) {
      const Result<Answer> answer = other.try_claim(a_unit);
      was_taken = was_taken || !answer || *answer == Answer::won;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    CHECK_FALSE(was_taken);
  }
  const Result<Answer> answer = other.try_claim(a_unit);
  REQUIRE(answer);
  CHECK(*answer == Answer::won);
}

TEST_CASE("claims: of threads that race for a unit, free or expired, one wins", "[verifier][claims][determinism]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  race_threads(500);
}

TEST_CASE("claims: 10,000 races of threads for free and for expired units", "[claims][determinism][.slow]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  race_threads(10'000);
}

#ifdef TICKTRUE_HAS_FORK
TEST_CASE("claims: of processes that race for a unit one wins", "[verifier][claims][determinism]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  race_processes(500);
}

TEST_CASE("claims: a process that is stopped past its lease and continued changes nothing",
          "[verifier][claims][determinism]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  constexpr double short_lease_s = 0.5;
  const TemporaryFolder folder;
  const StoreFolder files = open_store(folder.file("store"));
  int told[2] = {-1, -1}, gate[2] = {-1, -1};
  REQUIRE(::pipe2(told, O_CLOEXEC) == 0);
  REQUIRE(::pipe2(gate, O_CLOEXEC) == 0);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    ::close(gate[1]);
    work_in_child(folder.file("store"), short_lease_s, told[1], gate[0]);
  }
  ::close(told[1]);
  ::close(gate[0]);
  char claimed = 0;
  REQUIRE(::read(told[0], &claimed, 1) == 1);
  Claims taker(files, short_lease_s), third(files, short_lease_s);
  REQUIRE(::kill(child, SIGSTOP) == 0);
  constexpr double patience_s = 30;
  CHECK(wins_within(taker, patience_s));
  taker.start_heartbeat();
  const Result<FoundVerdict> first = verifier::VerdictStore(files).add(a_unit, match_report());
  REQUIRE(first);
  CHECK(first->is_new);
  const Bytes stored = read_file(files.path_of(verifier::spread_name(a_unit)));
  REQUIRE(::kill(child, SIGCONT) == 0);
  ::close(gate[1]);  // opens the gate
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  ::close(told[0]);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(taker.is_held(a_unit));
  CHECK_FALSE(wins_within(third, 2 * short_lease_s));
  CHECK(read_file(files.path_of(verifier::spread_name(a_unit))) == stored);
  taker.finish(a_unit);
  CHECK(claim_files(files).empty());
}

TEST_CASE("claims: 10,000 races of processes for free units", "[claims][determinism][.slow]") {
  SKIP_UNLESS(verifier::can_claim(), "this system has no claims");
  race_processes(10'000);
}
#endif

}  // namespace ticktrue::test
