// The store of verdicts: what it gives back, and that nothing damaged, foreign or contradicted is ever believed.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "base/random.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/full_disk.h"
#include "tests/support/text.h"
#include "verifier/report/report_transfer.h"
#include "verifier/store/mapped_libraries.h"
#include "verifier/store/stat_index.h"
#include "verifier/store/verdict_entry.h"
#include "verifier/store/verdict_store.h"

namespace ticktrue::test {
namespace {

namespace fs = std::filesystem;
using verifier::FoundVerdict;
using verifier::Report;
using verifier::StatIndex;
using verifier::StoreFolder;
using verifier::Verdict;
using verifier::VerdictStore;
using verifier::VerdictSubject;
using Kind = FoundVerdict::Kind;

const std::string a_key = "00112233445566778899aabbccddeeff";
const std::string another_key = "ff112233445566778899aabbccddeeff";

Report match_report() {
  Report report;
  report.file = "a.ttr";
  report.title = "a stack";
  report.mode = "replay";
  report.verdict = Verdict::match;
  report.ticks_recorded = 600;
  report.ticks_compared = 600;
  report.root_hash = 0x0123456789abcdef;
  report.wall_s = 0.25;
  return report;
}

Report diverged_report(std::uint64_t tick) {
  Report report = match_report();
  report.verdict = Verdict::diverged;
  report.ticks_compared = tick + 1;
  report.divergence.emplace();
  report.divergence->tick = tick;
  report.divergence->expected_root = 1;
  report.divergence->got_root = 2;
  return report;
}

StoreFolder open_store(const TemporaryFolder& folder) {
  Result<StoreFolder> store = StoreFolder::open(folder.file("store"), StoreFolder::Use::writing, false);
  REQUIRE(store);
  return *std::move(store);
}

std::string entry_path(const StoreFolder& folder, const std::string& key) {
  return folder.path_of(verifier::spread_name(key));
}

FoundVerdict find(const VerdictStore& store, const std::string& key) {
  Result<FoundVerdict> found = store.find(key);
  REQUIRE(found);
  return *std::move(found);
}

FoundVerdict add(const VerdictStore& store, const std::string& key, const Report& report) {
  Result<FoundVerdict> added = store.add(key, report);
  REQUIRE(added);
  return *std::move(added);
}

std::size_t count_files(const std::string& path) {
  std::error_code failure;
  std::size_t count = 0;
  for (fs::directory_iterator at(path, failure), end; !failure && at != end; at.increment(failure)) ++count;
  return count;
}

}  // namespace

TEST_CASE("store: a verdict comes back as it was stored, and no temporary file stays", "[verifier][store][analytic]") {
  const TemporaryFolder folder;
  const StoreFolder files = open_store(folder);
  const VerdictStore store(files);
  CHECK(find(store, a_key).kind == Kind::none);
  for (const auto& [key, report] : {std::pair(a_key, match_report()), std::pair(another_key, diverged_report(17))}) {
    CHECK(add(store, key, report).kind == Kind::verdict);
    const FoundVerdict found = find(store, key);
    REQUIRE(found.kind == Kind::verdict);
    CHECK(verifier::encode_report(*found.report) == verifier::encode_report(report));
    CHECK(add(store, key, report).kind == Kind::verdict);
  }
  CHECK(count_files(files.path_of("tmp")) == 0);
  const Bytes stored = read_file(entry_path(files, a_key));
  CHECK(contains(std::string(stored.begin(), stored.end()), a_key));
}

TEST_CASE("store: a changed byte or a cut is never a verdict, is named, and the next verdict replaces it",
          "[verifier][store][corruption]") {
  const TemporaryFolder folder;
  const StoreFolder files = open_store(folder);
  const VerdictStore store(files);
  add(store, a_key, match_report());
  const std::string path = entry_path(files, a_key);
  const Bytes whole = read_file(path);
  std::size_t damaged_count = 0;
  const auto check_damaged = [&](const Bytes& bytes) {
    fs::remove(path);
    write_file(path, bytes);
    const FoundVerdict found = find(store, a_key);
    if (found.kind != Kind::damaged) FAIL_CHECK("believed after damage " << damaged_count);
    if (!contains(found.what, path) || !fs::exists(found.file) || fs::exists(path))
      FAIL_CHECK("not set aside after damage " << damaged_count);
    ++damaged_count;
  };
  Random random(25);
  for (int i = 0; i < 1000; ++i) {
    Bytes bytes = whole;
    bytes[random.below(bytes.size())] ^= static_cast<std::uint8_t>(1 + random.below(255));
    check_damaged(bytes);
  }
  for (std::size_t size = 0; size < whole.size(); ++size)
    check_damaged(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
  Bytes longer = whole;
  longer.push_back(0);
  check_damaged(longer);
  longer.resize(5u << 20);
  check_damaged(longer);
  CHECK(count_files(files.path_of("damaged")) == damaged_count);
  CHECK(add(store, a_key, match_report()).kind == Kind::verdict);
  CHECK(find(store, a_key).kind == Kind::verdict);
}

TEST_CASE("store: a damaged file that nobody has looked at does not keep a verdict out",
          "[verifier][store][corruption]") {
  const TemporaryFolder folder;
  const StoreFolder files = open_store(folder);
  const VerdictStore store(files);
  fs::create_directories(fs::path(entry_path(files, a_key)).parent_path());
  write_file(entry_path(files, a_key), Bytes(100, 7));
  CHECK(add(store, a_key, match_report()).kind == Kind::verdict);
  CHECK(find(store, a_key).kind == Kind::verdict);
  CHECK(count_files(files.path_of("damaged")) == 1);
}

TEST_CASE("store: the verdict of another key is not believed", "[verifier][store][corruption]") {
  const TemporaryFolder folder;
  const StoreFolder files = open_store(folder);
  const VerdictStore store(files);
  add(store, a_key, match_report());
  fs::create_directories(fs::path(entry_path(files, another_key)).parent_path());
  fs::copy_file(entry_path(files, a_key), entry_path(files, another_key));
  const FoundVerdict found = find(store, another_key);
  CHECK(found.kind == Kind::damaged);
  CHECK(contains(found.what, "it is the verdict of " + a_key));
}

TEST_CASE("store: an entry whose key is too long is refused", "[verifier][store][corruption]") {
  verifier::VerdictEntry entry;
  entry.key = a_key;
  REQUIRE(verifier::decode_entry(verifier::encode_entry(entry)).has_value());
  entry.key += '0';
  REQUIRE_FALSE(verifier::decode_entry(verifier::encode_entry(entry)).has_value());
}

TEST_CASE("store: two verdicts of one key are a conflict that names both files and stays",
          "[verifier][store][analytic]") {
  const TemporaryFolder folder;
  const StoreFolder files = open_store(folder);
  const VerdictStore store(files);
  add(store, a_key, match_report());
  const FoundVerdict added = add(store, a_key, diverged_report(17));
  REQUIRE(added.kind == Kind::conflict);
  CHECK(contains(added.what, " says match after 600 ticks"));
  CHECK(contains(added.what, " says diverged after 18 ticks"));
  CHECK(count_files(files.path_of("conflicts")) == 2);
  for (const fs::directory_entry& kept : fs::directory_iterator(files.path_of("conflicts")))
    CHECK(contains(added.what, kept.path().string()));
  CHECK(find(store, a_key).kind == Kind::conflict);
  // Neither of the two, nor a third one, makes the key good again; people do, by removing the file.
  CHECK(add(store, a_key, match_report()).kind == Kind::conflict);
  CHECK(add(store, a_key, diverged_report(99)).kind == Kind::conflict);
  CHECK(count_files(files.path_of("conflicts")) >= 3);
  fs::remove(added.file);
  CHECK(add(store, a_key, match_report()).kind == Kind::verdict);
}

#ifndef _WIN32
TEST_CASE("store: on a full disk a verdict is not stored, the same one is found, and a contradicted one goes",
          "[verifier][store][corruption]") {
  const TemporaryFolder folder;
  const StoreFolder files = open_store(folder);
  add(VerdictStore(files), a_key, match_report());
  const FullDisk full;
  // The store was made before: a full disk does not keep it from being opened.
  const StoreFolder again = open_store(folder);
  const VerdictStore full_store(again);
  const Result<FoundVerdict> refused = full_store.add(another_key, match_report());
  REQUIRE_FALSE(refused);
  CHECK(contains(refused.error().message, again.path()));
  CHECK_FALSE(refused.error().hint.empty());
  CHECK(find(full_store, another_key).kind == Kind::none);
  CHECK(add(full_store, a_key, match_report()).kind == Kind::verdict);
  const Result<FoundVerdict> contradicted = full_store.add(a_key, diverged_report(17));
  REQUIRE_FALSE(contradicted);
  CHECK(contains(contradicted.error().message, "two verdicts for the same bytes, engine and options"));
  CHECK(contains(contradicted.error().message, " says diverged after 18 ticks"));
  CHECK(find(full_store, a_key).kind == Kind::none);
  CHECK(count_files(again.path_of("tmp")) == 0);
}
#endif

TEST_CASE("store: verdicts differ by what was found, not by file, time or words", "[verifier][store][analytic]") {
  const Report report = diverged_report(17);
  Report same = report;
  same.file = "b.ttr";
  same.wall_s = 99;
  same.notes = {"another note"};
  CHECK(verifier::is_same_verdict(report, same));
  for (int what = 0; what < 6; ++what) {
    Report other = report;
    if (what == 0) other.verdict = Verdict::not_reproducible;
    if (what == 1) other.ticks_compared = 3;
    if (what == 2) other.root_hash = 3;
    if (what == 3) other.divergence->tick = 3;
    if (what == 4) other.divergence->got_root = 3;
    if (what == 5) other.divergence.reset();
    CAPTURE(what);
    CHECK_FALSE(verifier::is_same_verdict(report, other));
  }
}

TEST_CASE("store: each part of its subject changes the key of a verdict", "[verifier][store][analytic]") {
  const VerdictSubject subject{{1, 2}, 3, {4, 5}, {6, 7}, "mode replay"};
  std::set<std::string> keys{verifier::verdict_key(subject)};
  CHECK(keys.begin()->size() == 32);
  std::vector<VerdictSubject> others(8, subject);
  ++others[0].trace.high;
  ++others[1].trace.low;
  ++others[2].size;
  ++others[3].engine.high;
  ++others[4].engine.low;
  ++others[5].libraries.high;
  ++others[6].libraries.low;
  others[7].options = "mode restore";
  for (const VerdictSubject& other : others) keys.insert(verifier::verdict_key(other));
  CHECK(keys.size() == 9);
  CHECK(verifier::verdict_key(subject) == *keys.find(verifier::verdict_key(subject)));
}

TEST_CASE("store: threads that store one verdict at once leave one, and conflicting ones leave a conflict",
          "[verifier][store][determinism]") {
  const TemporaryFolder folder;
  for (int round = 0; round < 50; ++round) {
    const StoreFolder files = open_store(folder);
    const std::string key = std::to_string(100 + round) + a_key.substr(3);
    const auto store_one = [&](bool is_green) {
      const VerdictStore store(files);
      const Result<FoundVerdict> added = store.add(key, is_green ? match_report() : diverged_report(5));
      if (!added) FAIL_CHECK(added.error().message);
    };
    const bool conflicts = round % 2 == 1;
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) threads.emplace_back(store_one, !conflicts || i % 2 == 0);
    for (std::thread& thread : threads) thread.join();
    const VerdictStore store(files);
    CHECK(find(store, key).kind == (conflicts ? Kind::conflict : Kind::verdict));
  }
  const StoreFolder files = open_store(folder);
  CHECK(count_files(files.path_of("tmp")) == 0);
  CHECK(count_files(files.path_of("damaged")) == 0);
}

TEST_CASE("store: the first publisher of a name creates the file, others change nothing",
          "[verifier][store][analytic]") {
  const TemporaryFolder folder;
  const StoreFolder first = open_store(folder), second = open_store(folder);
  CHECK(first.owner() != second.owner());
  const Bytes one(10, 1), two(20, 2);
  const auto publish = [](const StoreFolder& files, const Bytes& bytes) {
    const Result<StoreFolder::Publish> published = files.publish("ab/name", bytes);
    REQUIRE(published);
    return *published;
  };
  CHECK(publish(first, one) == StoreFolder::Publish::created);
  CHECK(publish(second, two) == StoreFolder::Publish::exists);
  CHECK(publish(first, one) == StoreFolder::Publish::exists);
  CHECK(read_file(first.path_of("ab/name")) == one);
  REQUIRE(second.replace("ab/name", two));
  CHECK(read_file(first.path_of("ab/name")) == two);
  const Result<std::string> aside = first.set_aside("ab/name");
  REQUIRE(aside);
  CHECK_FALSE(first.exists("ab/name"));
  first.put_back(*aside, "ab/name");
  CHECK(read_file(first.path_of("ab/name")) == two);
  CHECK_FALSE(first.exists(*aside));
  CHECK(count_files(first.path_of("tmp")) == 0);
}

TEST_CASE("store: only an empty folder becomes a store, and a missing one is not read", "[verifier][store][analytic]") {
  const TemporaryFolder folder;
  const auto open = [&](const std::string& name, StoreFolder::Use use) {
    return StoreFolder::open(folder.file(name), use, false);
  };
  fs::create_directory(folder.file("other"));
  write_file(folder.file("other/letter.txt"), Bytes(3, 65));
  const auto refused = open("other", StoreFolder::Use::writing);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::usage);
  CHECK(contains(refused.error().message, "not a store of verdicts"));
  CHECK_FALSE(fs::exists(folder.file("other/tmp")));
  const auto missing = open("missing", StoreFolder::Use::reading);
  REQUIRE_FALSE(missing);
  CHECK_FALSE(fs::exists(folder.file("missing")));
  CHECK(open("deep/er", StoreFolder::Use::writing));
  CHECK(open("deep/er", StoreFolder::Use::writing));
  CHECK(open("deep/er", StoreFolder::Use::reading));
  write_file(folder.file("deep/er/ticktrue-store"), Bytes(17, 65));
  const auto newer = open("deep/er", StoreFolder::Use::reading);
  REQUIRE_FALSE(newer);
  CHECK(newer.error().code == ErrorCode::incompatible);
}

TEST_CASE("store: workers that start at once on a missing folder all get the store that one of them makes",
          "[verifier][store][regression]") {
  const TemporaryFolder folder;
  constexpr int worker_count = 4;
  for (int round = 0; round < 300; ++round) {
    const std::string path = folder.file("store" + std::to_string(round));
    std::vector<std::string> errors(worker_count);
    std::vector<std::thread> workers;
    for (int i = 0; i < worker_count; ++i)
      workers.emplace_back([&, i] {
        const auto files = StoreFolder::open(path, StoreFolder::Use::writing, false);
        const Result<StoreFolder::Publish> claimed =
            files ? files->publish("claims/" + std::to_string(i), Bytes(1, 65)) : files.error();
        if (!claimed) errors[static_cast<std::size_t>(i)] = claimed.error().message;
      });
    for (std::thread& worker : workers) worker.join();
    for (const std::string& error : errors) CHECK(error.empty());
  }
}

TEST_CASE("stat index: a row holds for the same file, and a file that changed lately gets none",
          "[verifier][store][analytic]") {
  const TemporaryFolder folder;
  const StoreFolder files = open_store(folder);
  const replay::FileFacts facts{1, 2, 3, 4, 5};
  {
    StatIndex index(files, "traces");
    index.note("a.ttr", facts, {6, 7});
    replay::FileFacts fresh = facts;
    write_file(folder.file("fresh"), Bytes(3, 65));
    fresh = *replay::file_facts(folder.file("fresh"));
    index.note("fresh.ttr", fresh, {8, 9});
    CHECK_FALSE(index.find("fresh.ttr", fresh));
    REQUIRE(index.save());
  }
  const StatIndex index(files, "traces");
  REQUIRE(index.find("a.ttr", facts));
  CHECK(*index.find("a.ttr", facts) == Hash128{6, 7});
  CHECK_FALSE(index.find("b.ttr", facts));
  std::vector<replay::FileFacts> others(5, facts);
  ++others[0].device;
  ++others[1].inode;
  ++others[2].size;
  ++others[3].modified_ns;
  ++others[4].changed_ns;
  for (const replay::FileFacts& other : others) CHECK_FALSE(index.find("a.ttr", other));
  CHECK_FALSE(StatIndex(files, "other traces").find("a.ttr", facts));

  REQUIRE(count_files(files.path_of("index")) == 1);
  const std::string path = fs::directory_iterator(files.path_of("index"))->path().string();
  const Bytes whole = read_file(path);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Bytes bytes = whole;
    bytes[i] ^= 0x10;
    write_file(path, bytes);
    if (StatIndex(files, "traces").find("a.ttr", facts)) FAIL_CHECK("believed with byte " << i << " changed");
  }
}

#ifdef __linux__
TEST_CASE("mapped libraries: the C library is among them, and only content and name count",
          "[verifier][store][analytic]") {
  const auto libraries = verifier::mapped_libraries();
  REQUIRE(libraries);
  CHECK(std::any_of(libraries->begin(), libraries->end(), [](const verifier::MappedLibrary& library) {
    return contains(library.path, "/libc.so") || contains(library.path, "/libc.musl");
  }));
  const Hash128 digest = verifier::libraries_digest(*libraries);
  std::vector<verifier::MappedLibrary> moved = *libraries;
  std::reverse(moved.begin(), moved.end());
  for (verifier::MappedLibrary& library : moved) library.path = "/elsewhere" + library.path;
  CHECK(verifier::libraries_digest(moved) == digest);
  ++moved.front().content.low;
  CHECK_FALSE(verifier::libraries_digest(moved) == digest);
  moved.pop_back();
  CHECK_FALSE(verifier::libraries_digest(moved) == digest);
}
#endif

TEST_CASE("file_hash: the hash of all bytes, of files larger than its buffer too", "[verifier][store][analytic]") {
  const TemporaryFolder folder;
  Bytes bytes;
  for (int i = 0; i < 3'000'001; ++i) bytes.push_back(static_cast<std::uint8_t>(i * 7 + (i >> 9)));
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, bytes.size()}) {
    const Bytes part(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    write_file(folder.file("file"), part);
    const Result<Hash128> hash = verifier::file_hash(folder.file("file"));
    REQUIRE(hash);
    CHECK(*hash == hash128(part));
  }
  CHECK_FALSE(verifier::file_hash(folder.file("missing")));
}

}  // namespace ticktrue::test
