// Agreements of workers and the history of a trace: one decision each, and damage is never read as content.
// SPDX-License-Identifier: MIT
#include "verifier/store/history.h"

#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/store/agreement.h"

namespace ticktrue::test {
namespace {

using verifier::History;
using verifier::HistoryRow;
using verifier::StoreFolder;

const std::string first_key = "00112233445566778899aabbccddeeff";

StoreFolder history_store(const TemporaryFolder& folder) {
  Result<StoreFolder> store = StoreFolder::open(folder.file("store"), StoreFolder::Use::writing, false);
  REQUIRE(store);
  return *std::move(store);
}

HistoryRow history_row(const std::string& key, std::int64_t when_s) {
  HistoryRow row;
  row.key = key;
  row.engine = {1, 2};
  row.mode = "replay";
  row.commit = "3f2a1c";
  row.when_s = when_s;
  row.seconds = 1.5;
  row.verdict = "match";
  row.ticks_recorded = row.ticks_compared = 600;
  return row;
}

}  // namespace

TEST_CASE("agreement: of many workers one decides, and all follow", "[store][agreement][determinism]") {
  const TemporaryFolder folder;
  const StoreFolder store = history_store(folder);
  constexpr int round_count = 50, worker_count = 4;
  for (int round = 0; round < round_count; ++round) {
    const std::string key = first_key.substr(0, 28) + std::to_string(1000 + round);
    std::vector<Bytes> found(worker_count);
    std::vector<std::thread> workers;
    for (int w = 0; w < worker_count; ++w)
      workers.emplace_back([&, w] {
        const Result<Bytes> agreed = verifier::agree_on(store, key, Bytes{static_cast<std::uint8_t>(w)});
        if (agreed) found[static_cast<std::size_t>(w)] = *agreed;
      });
    for (std::thread& worker : workers) worker.join();
    CHECK(std::set<Bytes>(found.begin(), found.end()).size() == 1);
    CHECK(found[0].size() == 1);
  }
}

TEST_CASE("agreement: a damaged one is set aside and decided again", "[store][agreement][corruption]") {
  const TemporaryFolder folder;
  const StoreFolder store = history_store(folder);
  REQUIRE(verifier::agree_on(store, first_key, Bytes{7}));
  const std::string path = store.path_of("agreed/" + verifier::spread_name(first_key));
  const Bytes whole = read_file(path);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    CAPTURE(at);
    Bytes bytes = whole;
    bytes[at] ^= 4;
    write_file(path, bytes);
    const auto found = verifier::find_agreement(store, first_key);
    REQUIRE(found);
    CHECK(!*found);
    const Result<Bytes> again = verifier::agree_on(store, first_key, Bytes{8});
    REQUIRE(again);
    CHECK(*again == Bytes{8});
  }
}

TEST_CASE("history: rows come back oldest first, and a damaged one is told", "[store][history][corruption]") {
  const TemporaryFolder folder;
  const StoreFolder store = history_store(folder);
  const History history(store);
  CHECK(history.find("abc").rows.empty());
  HistoryRow late = history_row(first_key, 300);
  late.verdict = "diverged";
  late.diverged = 137;
  const std::string other_key = "ff" + first_key.substr(2);
  REQUIRE(history.add("abc", late));
  REQUIRE(history.add("abc", history_row(other_key, 200)));
  REQUIRE(history.add("abc", history_row(other_key, 900)));  // the first one stays
  const auto found = history.find("abc");
  REQUIRE(found.rows.size() == 2);
  CHECK(found.warnings.empty());
  CHECK(found.rows[0].when_s == 200);
  CHECK(found.rows[0].commit == "3f2a1c");
  CHECK(found.rows[0].seconds == 1.5);
  CHECK(found.rows[1].key == first_key);
  CHECK(found.rows[1].diverged == 137);

  const std::string path = store.path_of("history/" + verifier::spread_name("abc") + "/" + first_key);
  const Bytes whole = read_file(path);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    CAPTURE(at);
    Bytes bytes = whole;
    bytes[at] ^= 1;
    write_file(path, bytes);
    const auto after = history.find("abc");
    CHECK(after.rows.size() == 1);
    CHECK(after.warnings.size() == 1);
  }
}

}  // namespace ticktrue::test
