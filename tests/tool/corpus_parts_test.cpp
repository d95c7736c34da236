// Long traces in parts, shards by cost: the verdict equals that of one run, no unit is lost, and no failure becomes a
// match.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "base/random.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/faulty_engine.h"
#include "tests/support/scenes.h"
#include "tests/support/text.h"
#include "tool/corpus/run/corpus_run.h"
#include "tool/corpus/run/costs.h"
#include "tool/corpus/run/shard_plan.h"
#include "tool/session/session.h"
#include "verifier/report/report_transfer.h"
#include "verifier/store/claims.h"
#include "verifier/store/history.h"
#include "verifier/store/mapped_libraries.h"

namespace ticktrue::test {
namespace {

namespace fs = std::filesystem;
using tool::CorpusOptions;
using tool::CorpusUnit;
using tool::UnitSource;
using verifier::Report;
using verifier::StoreFolder;
using verifier::Verdict;
using verifier::VerdictStore;
using Units = std::vector<CorpusUnit>;

bool has_engine_digest() {
  return tool::build_subject(verifier::VerifyMode::replay).has_value();
}

/// Six falling boxes, with a checkpoint every 20 ticks. With a fault, the trace diverges at that tick.
void record_boxes(const std::string& path, std::uint64_t tick_count, std::uint64_t fault_tick) {
  const Scene scene = stack_scene(6, 0.5, Precision::f32);
  const auto made = engine::make_engine(scene);
  REQUIRE(made);
  tool::TraceChoices choices;
  choices.checkpoint_interval = 20;
  const replay::TraceSetup setup = tool::make_trace_setup(**made, choices);
  replay::NoInputs inputs(scene.settings.dt);
  replay::RecordOptions options;
  options.tick_count = tick_count;
  options.writer = plain_writer();
  FaultyEngine engine(**made, Fault{fault_tick, 3, 20});
  REQUIRE(replay::record(engine, inputs, path, setup, {}, options));
}

constexpr std::uint64_t no_fault = std::numeric_limits<std::uint64_t>::max() - 1;

/// Two long traces and a short one. The test chooses the fault of the second trace. The store has learned that all
/// traces are expensive.
class LongCorpus {
 public:
  explicit LongCorpus(std::uint64_t fault_tick = no_fault) {
    fs::create_directory(folder_.file("traces"));
    add("a", 200, no_fault);
    add("b", 120, fault_tick);
    add("c", 10, no_fault);
    const StoreFolder store = open("learned");
    for (const CorpusUnit& unit : verify("learned", {})) whole_.push_back(unit.report);
    // A second store, which only has the history.
    open("store");
    fs::copy(store.path_of("history"), folder_.file("store") + "/history", fs::copy_options::recursive);
  }
  const std::vector<std::string>& files() const { return files_; }
  /// The reports of a single run.
  const std::vector<Report>& whole() const { return whole_; }
  StoreFolder open(const std::string& name = "store") const {
    Result<StoreFolder> folder = StoreFolder::open(folder_.file(name), StoreFolder::Use::writing, false);
    REQUIRE(folder);
    return *std::move(folder);
  }
  /// A later run of another build. New plans would differ after this run.
  void learn_that_the_last_is_expensive() const {
    const Result<Hash128> hash = verifier::file_hash(files_.back());
    REQUIRE(hash);
    verifier::HistoryRow row;
    row.key = "00112233445566778899aabbccddeeff";
    row.mode = "replay";
    row.when_s = std::numeric_limits<std::int32_t>::max();
    row.seconds = 1e6;
    const StoreFolder folder = open();
    REQUIRE(verifier::History(folder).add(verifier::history_name(*hash, fs::file_size(files_.back())), row));
  }
  Units verify(const std::string& name, const CorpusOptions& options) const {
    const StoreFolder folder = open(name);
    Result<Units> units = tool::verify_corpus(files_, folder_.file("traces"), VerdictStore(folder), options);
    REQUIRE(units);
    return *std::move(units);
  }
  Units verify(const CorpusOptions& options) const { return verify("store", options); }
  Units look_up() const {
    const StoreFolder folder = open();
    Result<Units> units = tool::look_up_corpus(files_, folder_.file("traces"), VerdictStore(folder), {});
    REQUIRE(units);
    return *std::move(units);
  }

 private:
  void add(const std::string& name, std::uint64_t tick_count, std::uint64_t fault_tick) {
    files_.push_back(folder_.file("traces/" + name + ".ttr"));
    record_boxes(files_.back(), tick_count, fault_tick);
  }
  TemporaryFolder folder_;
  std::vector<std::string> files_;
  std::vector<Report> whole_;
};

/// Every trace exceeds this limit.
CorpusOptions in_parts() {
  CorpusOptions options;
  options.part_s = 0;
  options.thread_count = 2;
  return options;
}

/// The keys of all verdicts, including parts.
std::vector<std::string> stored_keys(const StoreFolder& folder) {
  constexpr std::size_t name_size = 33;  // "ab/cdef..."
  std::vector<std::string> keys;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    const std::string inside = fs::relative(entry.path(), folder.path()).string();
    if (entry.is_regular_file() && inside.size() == name_size && inside[2] == '/')
      keys.push_back(inside.substr(0, 2) + inside.substr(3));
  }
  return keys;
}

std::size_t entry_count(const StoreFolder& folder) {
  return stored_keys(folder).size();
}

/// The report without measured times.
Bytes same_of(Report report) {
  report.wall_s = 0;
  return verifier::encode_report(report);
}

}  // namespace

TEST_CASE("corpus: a long trace in parts gets the verdict of one run", "[verifier][corpus][parts][equivalence]") {
  SKIP_UNLESS(has_engine_digest(), "this build has no digest of the engine");
  const LongCorpus corpus;
  const Units units = corpus.verify(in_parts());
  // 10 parts, 6 parts, and one trace with a single segment: three verdicts, and 16 verdicts of parts.
  CHECK(entry_count(corpus.open()) == 3 + 10 + 6);
  REQUIRE(units.size() == 3);
  for (std::size_t i = 0; i < units.size(); ++i) {
    CHECK(units[i].source == UnitSource::verified);
    CHECK(units[i].report.verdict == Verdict::match);
    CHECK(same_of(units[i].report) == same_of(corpus.whole()[i]));
  }
  for (const CorpusUnit& unit : corpus.verify(in_parts())) CHECK(unit.source == UnitSource::cached);
}

TEST_CASE("corpus: a part that is no match is followed by a run from tick 0, and its verdict counts",
          "[verifier][corpus][parts][equivalence]") {
  SKIP_UNLESS(has_engine_digest(), "this build has no digest of the engine");
  for (const std::uint64_t tick : {std::uint64_t{3}, std::uint64_t{47}, std::uint64_t{119}}) {
    CAPTURE(tick);
    const LongCorpus corpus(tick);
    for (int run = 0; run < 2; ++run) {
      const Units units = corpus.verify(in_parts());
      CHECK(units[0].report.verdict == Verdict::match);
      CHECK(units[1].report.verdict == Verdict::diverged);
      REQUIRE(units[1].report.divergence);
      CHECK(units[1].report.divergence->tick == tick);
      CHECK(same_of(units[1].report) == same_of(corpus.whole()[1]));
      CHECK(units[1].source == UnitSource::verified);
      CHECK(tool::corpus_exit_code(units, false) == verifier::exit_finding);
    }
  }
}

TEST_CASE("corpus: a part that was no match once is not forgotten when the whole matches",
          "[verifier][corpus][parts][corruption]") {
  SKIP_UNLESS(has_engine_digest(), "this build has no digest of the engine");
  const LongCorpus corpus;
  const Units first = corpus.verify(in_parts());
  // Of the first trace, the verdict is removed, and one part gets another verdict, like that of a machine that computes
  // wrongly.
  const StoreFolder folder = corpus.open();
  fs::remove(folder.path_of(verifier::spread_name(first[0].key)));
  bool is_forged = false;
  const VerdictStore store(folder);
  for (const std::string& key : stored_keys(folder)) {
    const auto found = store.find(key);
    REQUIRE(found);
    if (is_forged || !found->report || found->report->ticks_recorded != 200 || found->report->first_tick != 40)
      continue;
    Report red = *found->report;
    red.verdict = Verdict::diverged;
    fs::remove(folder.path_of(verifier::spread_name(key)));
    REQUIRE(store.add(key, red));
    is_forged = true;
  }
  REQUIRE(is_forged);
  CHECK(corpus.look_up()[0].source == UnitSource::missing);
  for (int run = 0; run < 2; ++run) {
    const Units units = corpus.verify(in_parts());
    CHECK(units[0].report.verdict == Verdict::not_reproducible);
    CHECK(tool::corpus_exit_code(units, false) == verifier::exit_not_reproducible);
  }
  CHECK(tool::corpus_exit_code(corpus.look_up(), false) == verifier::exit_not_reproducible);
}

TEST_CASE("corpus: workers that claim share the parts of a trace, and replace one that died",
          "[verifier][corpus][parts][determinism]") {
  SKIP_UNLESS(has_engine_digest() && verifier::can_claim(), "this build has no digest of the engine, or no claims");
  for (const std::uint64_t tick : {no_fault, std::uint64_t{61}}) {
    CAPTURE(tick);
    const LongCorpus corpus(tick);
    // A worker has claimed every unit and every part, and does not respond.
    corpus.verify(in_parts());
    const StoreFolder dead_folder = corpus.open();
    verifier::Claims dead(dead_folder, 1);
    for (const std::string& key : stored_keys(dead_folder)) {
      REQUIRE(dead.try_claim(key));
      fs::remove(dead_folder.path_of(verifier::spread_name(key)));
    }
    CorpusOptions options = in_parts();
    options.claims = true;
    options.lease_s = 1;
    std::vector<Units> found(3);
    std::vector<std::thread> workers;
    for (Units& units : found) workers.emplace_back([&corpus, &options, &units] { units = corpus.verify(options); });
    for (std::thread& worker : workers) worker.join();
    for (std::size_t i = 0; i < corpus.files().size(); ++i) {
      CAPTURE(i);
      std::size_t verified_count = 0;
      for (const Units& units : found) {
        CHECK(same_of(units[i].report) == same_of(corpus.whole()[i]));
        verified_count += units[i].source == UnitSource::verified ? 1u : 0u;
      }
      CHECK(verified_count == 1);
    }
    CHECK(tool::corpus_exit_code(corpus.look_up(), false) ==
          (tick == no_fault ? verifier::exit_ok : verifier::exit_finding));
  }
}

TEST_CASE("corpus: a damaged verdict of a part is told and found again", "[verifier][corpus][parts][corruption]") {
  SKIP_UNLESS(has_engine_digest(), "this build has no digest of the engine");
  const LongCorpus corpus;
  corpus.verify(in_parts());
  const StoreFolder folder = corpus.open();
  for (const std::string& key : stored_keys(folder)) {
    const std::string path = folder.path_of(verifier::spread_name(key));
    Bytes bytes = read_file(path);
    bytes[bytes.size() / 2] ^= 1;
    write_file(path, bytes);
  }
  CHECK(tool::corpus_exit_code(corpus.look_up(), false) == verifier::exit_usage);
  const Units again = corpus.verify(in_parts());
  for (std::size_t i = 0; i < again.size(); ++i) {
    CHECK(again[i].source == UnitSource::verified);
    CHECK(same_of(again[i].report) == same_of(corpus.whole()[i]));
  }
  CHECK(tool::corpus_exit_code(again, false) == verifier::exit_ok);
}

TEST_CASE("corpus: parts of a stopped run are kept, and a report misses what is missing",
          "[verifier][corpus][parts][analytic]") {
  SKIP_UNLESS(has_engine_digest(), "this build has no digest of the engine");
  const LongCorpus corpus;
  CorpusOptions options = in_parts();
  options.thread_count = 1;
  int asked = 0;
  options.stops = [&] { return ++asked > 16; };
  const Units stopped = corpus.verify(options);
  CHECK(tool::corpus_exit_code(stopped, false) == verifier::exit_usage);
  const std::size_t kept = entry_count(corpus.open());
  CHECK(kept > 0);
  const Units missing = corpus.look_up();
  CHECK(tool::corpus_exit_code(missing, false) == verifier::exit_usage);
  CHECK(contains(missing[0].report.reason, "found no verdict of "));
  CHECK(tool::corpus_exit_code(corpus.verify(in_parts()), false) == verifier::exit_ok);
  CHECK(tool::corpus_exit_code(corpus.look_up(), false) == verifier::exit_ok);
}

TEST_CASE("corpus: shards make up the whole, whenever each of them starts", "[verifier][corpus][shards][equivalence]") {
  SKIP_UNLESS(has_engine_digest(), "this build has no digest of the engine");
  for (const std::uint64_t tick : {no_fault, std::uint64_t{61}}) {
    const LongCorpus corpus(tick);
    std::uint64_t part_ticks = 0;
    std::vector<int> codes;
    for (const std::uint64_t index : {std::uint64_t{2}, std::uint64_t{3}, std::uint64_t{1}}) {
      CorpusOptions options = in_parts();
      options.shard = verifier::Shard{index, 3};
      const Units units = corpus.verify(options);
      codes.push_back(tool::corpus_exit_code(units, false));
      for (const CorpusUnit& unit : units)
        if (unit.source == UnitSource::partial) part_ticks += unit.report.ticks_compared;
      corpus.learn_that_the_last_is_expensive();
      CHECK((index == 1 || tool::corpus_exit_code(corpus.look_up(), false) == verifier::exit_usage));
    }
    CHECK(part_ticks > 0);
    const Units all = corpus.look_up();
    const int expected = tick == no_fault ? verifier::exit_ok : verifier::exit_finding;
    CHECK(verifier::worst_exit_code(codes) == expected);
    CHECK(tool::corpus_exit_code(all, false) == expected);
    for (std::size_t i = 0; i < all.size(); ++i) CHECK(same_of(all[i].report) == same_of(corpus.whole()[i]));
  }
}

TEST_CASE("shards of a corpus of very different lengths are within 10 % of each other",
          "[verifier][corpus][shards][analytic]") {
  Random random(7);
  for (const std::uint32_t shard_count : {2u, 3u, 8u, 16u}) {
    // Traces from a hundredth of a second to six hours. Traces above a minute are split.
    std::vector<double> costs;
    std::vector<std::size_t> parts;
    constexpr std::size_t segments_max = 128;
    for (int i = 0; i < 2000; ++i) {
      const double share = static_cast<double>(random.bits() % 10'000) / 10'000;
      costs.push_back(0.01 * std::pow(2e6, share * share));
      parts.push_back(std::min(segments_max, tool::wanted_parts(costs.back(), 60)));
    }
    const tool::ShardPlan plan = tool::plan_shards(parts, costs, shard_count);
    REQUIRE(plan.traces.size() == costs.size());
    std::vector<double> loads(shard_count);
    for (std::size_t i = 0; i < costs.size(); ++i) {
      CHECK(plan.traces[i].size() == parts[i]);
      for (const std::uint32_t shard : plan.traces[i]) loads.at(shard - 1) += costs[i] / static_cast<double>(parts[i]);
    }
    const auto [least, most] = std::minmax_element(loads.begin(), loads.end());
    CAPTURE(shard_count, *least, *most);
    CHECK(*most <= 1.1 * *least);

    const Bytes bytes = tool::encode_plan(plan);
    const auto again = tool::decode_plan(bytes, costs.size(), shard_count);
    REQUIRE(again);
    CHECK(again->traces == plan.traces);
    CHECK(!tool::decode_plan(bytes, costs.size() + 1, shard_count));
    CHECK(!tool::decode_plan(bytes, costs.size(), shard_count - 1));
    CHECK(!tool::decode_plan(ByteView(bytes).first(bytes.size() - 1), costs.size(), shard_count));
  }
}

TEST_CASE("costs are learned, and by size where nothing is known", "[verifier][corpus][analytic]") {
  using tool::TraceCost;
  const std::vector<double> costs =
      tool::estimated_costs({TraceCost{2.0, 1000}, TraceCost{std::nullopt, 500}, TraceCost{4.0, 2000}});
  CHECK(costs == std::vector<double>{2.0, 1.0, 4.0});
  const std::vector<double> unknown =
      tool::estimated_costs({TraceCost{std::nullopt, 1'000'000}, TraceCost{std::nullopt, 3'000'000}});
  CHECK(std::abs(unknown[1] - 3 * unknown[0]) < 1e-9);
  std::vector<double> one_is_long(20, 1.0);
  one_is_long.push_back(10);
  const std::vector<std::uint32_t> shares = tool::share_out(one_is_long, 2);
  double first_s = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) first_s += shares[i] == 1 ? one_is_long[i] : 0;
  CHECK(first_s == 15);
  CHECK(tool::wanted_parts(59, 60) == 1);
  CHECK(tool::wanted_parts(61, 60) == 2);
  CHECK(tool::wanted_parts(3600, 60) == 60);
}

}  // namespace ticktrue::test
