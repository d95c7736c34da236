// Corpora: verified traces, stored verdicts, and that no damage, conflict or dead worker makes a match.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/full_disk.h"
#include "tests/support/text.h"
#include "tool/corpus/engine_digest.h"
#include "tool/corpus/run/corpus_run.h"
#include "tool/corpus/trace_log.h"
#include "verifier/store/claims.h"
#include "verifier/store/renamed_report.h"

namespace ticktrue::test {
namespace {

namespace fs = std::filesystem;
using tool::CorpusOptions;
using tool::CorpusUnit;
using tool::UnitSource;
using verifier::StoreFolder;
using verifier::Verdict;
using verifier::VerdictStore;
using Units = std::vector<CorpusUnit>;

bool can_store() {
  return tool::build_subject(verifier::VerifyMode::replay).has_value();
}

/// A folder with a few of the golden traces, and a store beside them.
class Corpus {
 public:
  Corpus() {
    fs::create_directory(folder_.file("traces"));
    for (const char* name : {"projectile_f32", "projectile_f64", "slide_f32", "unsettled_f32", "verlet_f64"}) {
      const std::string file = std::string(name) + ".ttr";
      fs::copy_file(fs::path(TICKTRUE_SOURCE_DIR) / "traces" / file, folder_.file("traces/" + file));
      files_.push_back(folder_.file("traces/" + file));
    }
  }
  const std::vector<std::string>& files() const { return files_; }
  std::string store_path() const { return folder_.file("store"); }
  StoreFolder open(StoreFolder::Use use = StoreFolder::Use::writing) const {
    Result<StoreFolder> folder = StoreFolder::open(store_path(), use, false);
    REQUIRE(folder);
    return *std::move(folder);
  }
  Units verify(const CorpusOptions& options = {}) const {
    const StoreFolder folder = open();
    return taken(tool::verify_corpus(files_, folder_.file("traces"), VerdictStore(folder), options));
  }
  Units look_up() const {
    const StoreFolder folder = open(StoreFolder::Use::reading);
    return taken(tool::look_up_corpus(files_, folder_.file("traces"), VerdictStore(folder), {}));
  }
  std::string entry_of(const CorpusUnit& unit) const { return open().path_of(verifier::spread_name(unit.key)); }

 private:
  static Units taken(Result<Units> units) {
    REQUIRE(units);
    return *std::move(units);
  }
  TemporaryFolder folder_;
  std::vector<std::string> files_;
};

std::size_t count(const Units& units, UnitSource source) {
  return static_cast<std::size_t>(
      std::count_if(units.begin(), units.end(), [&](const CorpusUnit& unit) { return unit.source == source; }));
}

std::size_t count(const Units& units, Verdict verdict) {
  return static_cast<std::size_t>(std::count_if(
      units.begin(), units.end(), [&](const CorpusUnit& unit) { return unit.report.verdict == verdict; }));
}

/// Changes a byte in the middle, and keeps size and time of modification.
void change_byte(const std::string& path) {
  const fs::file_time_type time = fs::last_write_time(path);
  Bytes bytes = read_file(path);
  bytes[bytes.size() / 2] ^= 1;
  write_file(path, bytes);
  fs::last_write_time(path, time);
}

}  // namespace

TEST_CASE("corpus: the second run verifies nothing, and its reports are those of the first",
          "[verifier][corpus][analytic]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  const Units first = corpus.verify();
  CHECK(count(first, UnitSource::verified) == first.size());
  CHECK(count(first, Verdict::match) == first.size());
  const Units second = corpus.verify();
  CHECK(count(second, UnitSource::cached) == second.size());
  CHECK(tool::corpus_exit_code(second, false) == verifier::exit_ok);
  for (std::size_t i = 0; i < first.size(); ++i) {
    CHECK(second[i].key == first[i].key);
    CHECK(second[i].report.file == corpus.files()[i]);
    CHECK(verifier::is_same_verdict(first[i].report, second[i].report));
  }
  CorpusOptions other_mode;
  other_mode.mode = verifier::VerifyMode::twice;
  CHECK(count(corpus.verify(other_mode), UnitSource::verified) == first.size());
}

TEST_CASE("corpus: a report of the same bytes under another name has that name in every text and command",
          "[verifier][corpus][analytic]") {
  verifier::Report report;
  report.file = "old/a.ttr";
  report.verdict = Verdict::diverged;
  report.reason = "old/a.ttr: broken; not of cold/a.ttr, old/a.ttrs and old/a.ttr.bak";
  report.hint = "look at old/a.ttr";
  report.warnings = {"(old/a.ttr)"};
  report.again = {"ticktrue verify old/a.ttr --from 0", "./game old/a.ttr"};
  report.end.emplace().tail.message = "old/a.ttr: offset 7";
  verifier::Report same = report;
  verifier::rename_file(same, "old/a.ttr");
  CHECK(same.notes.empty());
  CHECK(same.again == report.again);

  using Lines = std::vector<std::string>;
  verifier::rename_file(report, "new ones/b.ttr");
  CHECK(report.file == "new ones/b.ttr");
  CHECK(report.reason == "new ones/b.ttr: broken; not of cold/a.ttr, old/a.ttrs and old/a.ttr.bak");
  CHECK(report.hint == "look at new ones/b.ttr");
  CHECK(report.warnings == Lines{"(new ones/b.ttr)"});
  CHECK(report.again == Lines{"ticktrue verify 'new ones/b.ttr' --from 0", "./game 'new ones/b.ttr'"});
  CHECK(report.end->tail.message == "new ones/b.ttr: offset 7");
  CHECK(report.notes == Lines{"found first in old/a.ttr, a file of the same bytes"});
  verifier::rename_file(report, "old/a.ttr");
  CHECK(report.again == Lines{"ticktrue verify old/a.ttr --from 0", "./game old/a.ttr"});

  verifier::Report match;
  match.file = "old/a.ttr";
  match.verdict = Verdict::match;
  verifier::rename_file(match, "b.ttr");
  CHECK(match.file == "b.ttr");
  CHECK(match.notes.empty());
}

TEST_CASE("corpus: bytes changed under a kept time are verified anew", "[verifier][corpus][corruption]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  const Units first = corpus.verify();
  change_byte(corpus.files()[1]);
  const Units second = corpus.verify();
  CHECK(second[1].source == UnitSource::verified);
  CHECK(second[1].report.verdict == Verdict::damaged);
  CHECK(count(second, UnitSource::cached) == first.size() - 1);
  CHECK(tool::corpus_exit_code(second, false) == verifier::exit_damaged);
}

TEST_CASE("corpus: a verdict that is no match is never taken from the store", "[verifier][corpus][analytic]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  fs::resize_file(corpus.files()[2], fs::file_size(corpus.files()[2]) - 100);
  for (int run = 0; run < 3; ++run) {
    const Units units = corpus.verify();
    CHECK(units[2].source == UnitSource::verified);
    CHECK(units[2].report.verdict == Verdict::incomplete);
    CHECK(count(units, UnitSource::cached) == (run == 0 ? 0 : units.size() - 1));
    CHECK(tool::corpus_exit_code(units, false) == verifier::exit_incomplete);
    CHECK(tool::corpus_exit_code(units, true) == verifier::exit_ok);
  }
}

TEST_CASE(
    "corpus: a program that does not tell its libraries is run by several threads, and its verdicts are not stored",
    "[verifier][corpus][programs]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  const TemporaryFolder folder;
  const std::string script = "\"" TICKTRUE_TOOL "\" verify -j 1 --json \"$1\" | tr -d '\\n' > \"$TICKTRUE_RESULT\"\n";
  write_file(folder.file("game.sh"), Bytes(script.begin(), script.end()));
  auto program = tool::ProgramSubject::make({{"sh", folder.file("game.sh"), "{}"}, {}, "-", 60});
  REQUIRE(program);
  CorpusOptions options;
  options.program = std::make_shared<tool::ProgramSubject>(*std::move(program));
  options.thread_count = 4;
  for (int run = 0; run < 2; ++run) {
    const Units units = corpus.verify(options);
    CHECK(count(units, UnitSource::verified) == units.size());
    CHECK(count(units, Verdict::match) == units.size());
    std::size_t warning_count = 0;
    for (const CorpusUnit& unit : units) warning_count += unit.warnings.size();
    CHECK(warning_count == 1);
  }
}

TEST_CASE("corpus: a red verdict of the store that a run does not confirm is a conflict, not a match",
          "[verifier][corpus][analytic]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  const Units first = corpus.verify();
  const StoreFolder folder = corpus.open();
  fs::remove(corpus.entry_of(first[0]));
  verifier::Report red = first[0].report;
  red.verdict = Verdict::diverged;
  REQUIRE(VerdictStore(folder).add(first[0].key, red));
  for (int run = 0; run < 2; ++run) {
    const Units units = corpus.verify();
    CHECK(units[0].report.verdict == Verdict::not_reproducible);
    CHECK(contains(units[0].report.reason, "two verdicts for the same bytes, engine and options"));
    CHECK(tool::corpus_exit_code(units, false) == verifier::exit_not_reproducible);
    CHECK(count(units, UnitSource::cached) == units.size() - (run == 0 ? 1 : 0));
  }
  CHECK(tool::corpus_exit_code(corpus.look_up(), false) == verifier::exit_not_reproducible);
}

TEST_CASE("corpus: a sample of everything runs everything, and finds a verdict that was forged",
          "[verifier][corpus][analytic]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  const Units first = corpus.verify();
  CorpusOptions all;
  all.recheck = 1;
  Units units = corpus.verify(all);
  CHECK(count(units, UnitSource::rechecked) == units.size());
  CHECK(tool::corpus_exit_code(units, false) == verifier::exit_ok);
  verifier::Report forged = first[3].report;
  forged.root_hash ^= 1;
  fs::remove(corpus.entry_of(first[3]));
  const StoreFolder folder = corpus.open();
  REQUIRE(VerdictStore(folder).add(first[3].key, forged));
  units = corpus.verify(all);
  CHECK(units[3].report.verdict == Verdict::not_reproducible);
}

TEST_CASE("corpus: a damaged verdict is told and verified again", "[verifier][corpus][corruption]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  const Units first = corpus.verify();
  change_byte(corpus.entry_of(first[4]));
  const Units found = corpus.look_up();
  CHECK(found[4].source == UnitSource::missing);
  CHECK(found[4].warnings.size() == 1);
  CHECK(tool::corpus_exit_code(found, false) == verifier::exit_usage);
  change_byte(corpus.entry_of(first[3]));
  const Units units = corpus.verify();
  CHECK(units[3].warnings.size() == 1);
  CHECK(count(units, UnitSource::verified) == 2);
  CHECK(count(units, Verdict::match) == units.size());
  CHECK(tool::corpus_exit_code(corpus.look_up(), false) == verifier::exit_ok);
}

TEST_CASE("corpus: the report fails where a trace has no verdict or cannot be read", "[verifier][corpus][analytic]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  corpus.open();
  const Units nothing = corpus.look_up();
  CHECK(count(nothing, UnitSource::missing) == nothing.size());
  CHECK(tool::corpus_exit_code(nothing, false) == verifier::exit_usage);
  corpus.verify();
  CHECK(tool::corpus_exit_code(corpus.look_up(), false) == verifier::exit_ok);
  fs::remove(corpus.files()[0]);
  const Units gone = corpus.look_up();
  CHECK(gone[0].report.verdict == Verdict::error);
  CHECK(tool::corpus_exit_code(gone, false) == verifier::exit_usage);
}

TEST_CASE("corpus: workers that claim do each trace once, and one that died is replaced",
          "[verifier][corpus][determinism]") {
  SKIP_UNLESS(can_store() && verifier::can_claim(), "this build has no digest of the engine, or no claims");
  const Corpus corpus;
  CorpusOptions options;
  options.claims = true;
  options.lease_s = 1;
  // A worker has claimed a trace and does not respond.
  const Units keys = [&] {
    corpus.open();
    return corpus.look_up();
  }();
  const StoreFolder dead_folder = corpus.open();
  verifier::Claims dead(dead_folder, options.lease_s);
  REQUIRE(dead.try_claim(keys[1].key));

  std::vector<Units> found(3);
  std::vector<std::thread> workers;
  for (Units& units : found) workers.emplace_back([&corpus, &options, &units] { units = corpus.verify(options); });
  for (std::thread& worker : workers) worker.join();
  for (std::size_t i = 0; i < corpus.files().size(); ++i) {
    int verified_count = 0;
    for (const Units& units : found) {
      CHECK(units[i].report.verdict == Verdict::match);
      verified_count += units[i].source == UnitSource::verified ? 1 : 0;
    }
    CHECK(verified_count == 1);
  }
}

#ifndef _WIN32
TEST_CASE("corpus: what a full disk kept out of the store is verified again, what was stored needs no room",
          "[verifier][corpus][corruption]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  corpus.open();
  Units units;
  {
    const FullDisk full;
    units = corpus.verify();
  }
  CHECK(count(units, Verdict::match) == units.size());
  for (const CorpusUnit& unit : units) {
    REQUIRE(unit.problems.size() == 1);
    CHECK(contains(unit.problems[0].message, corpus.store_path()));
    CHECK_FALSE(unit.problems[0].hint.empty());
  }
  CHECK(tool::corpus_exit_code(units, false) == verifier::exit_usage);
  CHECK(count(corpus.look_up(), UnitSource::missing) == units.size());
  CHECK(count(corpus.verify(), UnitSource::verified) == units.size());
  const FullDisk full;
  const Units cached = corpus.verify();
  CHECK(count(cached, UnitSource::cached) == units.size());
  CHECK(tool::corpus_exit_code(cached, false) == verifier::exit_ok);
}
#endif

TEST_CASE("corpus: a verdict without room for its row of the history is not stored", "[verifier][corpus][corruption]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  const std::string history = corpus.open().path_of("history");
  write_file(history, {});  // a file blocks this name for a folder
  const Units units = corpus.verify();
  CHECK(tool::corpus_exit_code(units, false) == verifier::exit_usage);
  CHECK(count(corpus.look_up(), UnitSource::missing) == units.size());
  fs::remove(history);
  CHECK(tool::corpus_exit_code(corpus.verify(), false) == verifier::exit_ok);
  for (const std::string& file : corpus.files()) {
    const auto log = tool::read_trace_log(file, corpus.open(), "replay");
    REQUIRE(log);
    CHECK(log->rows.size() == 1);
  }
}

TEST_CASE("corpus: a stopped run leaves the rest for the next one", "[verifier][corpus][analytic]") {
  SKIP_UNLESS(can_store(), "this build has no digest of the engine");
  const Corpus corpus;
  CorpusOptions options;
  std::size_t done_count = 0;
  options.progress = [&](std::size_t done, std::size_t) { done_count = done; };
  options.stops = [&] { return done_count == 2; };
  const Units stopped = corpus.verify(options);
  CHECK(count(stopped, UnitSource::verified) == 2);
  CHECK(tool::corpus_exit_code(stopped, false) == verifier::exit_usage);
  const Units rest = corpus.verify();
  CHECK(count(rest, UnitSource::cached) == 2);
  CHECK(count(rest, UnitSource::verified) == rest.size() - 2);
}

}  // namespace ticktrue::test
