// Results of a campaign: rows survive unchanged, even after a killed campaign.
// SPDX-License-Identifier: MIT
#include "tool/campaign/campaign.h"

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "tool/campaign/campaign_results.h"

namespace ticktrue::test {
namespace {

using campaign::SeedResult;

SeedResult random_result(std::mt19937& random) {
  constexpr std::string_view characters = "ab_-.# {}\\";  // no character that plain_line changes
  const auto text = [&] {
    std::string word;
    for (std::size_t n = random() % 6; n > 0; --n) word += characters[random() % characters.size()];
    return word == "-" || word == ".." ? std::string() : word;  // "-" is no text, ".." no file in the folder
  };
  SeedResult result;
  result.seed = random() % 20;
  result.program = text();
  do {
    result.verdict = verifier::verdicts[random() % verifier::verdicts.size()].verdict;
  } while (result.verdict == verifier::Verdict::error);  // an error has no row
  result.ticks = random();
  if (random() % 2 == 0) result.tick = random();
  result.table = text();
  result.column = text();
  result.trace = text();
  result.second = text();
  result.reason = text();
  return result;
}

TEST_CASE("results that were written are read as they were, and the last of a seed counts",
          "[tool][campaign][equivalence]") {
  std::mt19937 random(20261126);
  for (int i = 0; i < 300; ++i) {
    std::string text = campaign::results_head();
    std::map<std::uint64_t, SeedResult> expected;
    for (std::size_t n = random() % 30; n > 0; --n) {
      const SeedResult result = random_result(random);
      text += campaign::result_line(result);
      expected.insert_or_assign(result.seed, result);
    }
    CAPTURE(i, text);
    CHECK(campaign::parse_results(text, {}) == expected);
  }
}

TEST_CASE("a text of a result stays in its cell", "[tool][campaign][corruption]") {
  SeedResult result;
  result.verdict = verifier::Verdict::diverged;
  result.seed = 3;
  result.reason = "two\tcells\nand a line\n4\tx";
  const std::map<std::uint64_t, SeedResult> read = campaign::parse_results(campaign::result_line(result), {});
  REQUIRE(read.size() == 1);
  CHECK(read.at(3).reason == "two\\u0009cells\\u000aand a line\\u000a4\\u0009x");
}

TEST_CASE("results that were cut anywhere are rows that are whole", "[tool][campaign][corruption]") {
  std::mt19937 random(7);
  std::string text;
  std::vector<SeedResult> written;
  std::vector<std::size_t> ends;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    written.push_back(random_result(random));
    written.back().seed = seed;
    text += campaign::result_line(written.back());
    ends.push_back(text.size());
  }
  for (std::size_t size = 0; size <= text.size(); ++size) {
    const auto read = campaign::parse_results(std::string_view(text).substr(0, size), {});
    std::size_t whole = 0;
    while (whole < ends.size() && ends[whole] <= size) ++whole;
    CAPTURE(size);
    REQUIRE(read.size() == whole);
    for (std::size_t i = 0; i < whole; ++i) CHECK(read.at(i) == written[i]);
  }
}

TEST_CASE("a file of results goes on behind a line that was cut short", "[tool][campaign][corruption]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("");
  SeedResult result;
  result.verdict = verifier::Verdict::match;
  result.seed = 1;
  {
    auto file = campaign::ResultsFile::open(path, {});
    REQUIRE(file);
    REQUIRE(file->append(result));
    CHECK(!campaign::ResultsFile::open(path, {}));  // only one campaign at a time
  }
  std::ofstream(folder.file(campaign::results_name), std::ios::app) << "2\tcut";
  result.seed = 3;
  {
    auto file = campaign::ResultsFile::open(path, {});
    REQUIRE(file);
    CHECK(file->before().size() == 1);
    REQUIRE(file->append(result));
  }
  const auto file = campaign::ResultsFile::open(path, {});
  REQUIRE(file);
  CHECK(file->before().count(1) == 1);
  CHECK(file->before().count(2) == 0);
  CHECK(file->before().count(3) == 1);
}

TEST_CASE("a line that no campaign wrote is no result", "[tool][campaign][corruption]") {
  const std::string good = "7\tp\tmatch\t5\t-\t-\t-\tseed-7.ttr\t-\t-\n";
  REQUIRE(campaign::parse_results(good, {}).size() == 1);
  for (const std::string& line : {
           std::string("\n"),
           std::string("7\n"),
           std::string("\t\t\t\t\t\t\t\t\t\n"),
           std::string("-1\tp\tmatch\t5\t-\t-\t-\t-\t-\t-\n"),
           std::string("+1\tp\tmatch\t5\t-\t-\t-\t-\t-\t-\n"),
           std::string(" 1\tp\tmatch\t5\t-\t-\t-\t-\t-\t-\n"),
           std::string("0x1\tp\tmatch\t5\t-\t-\t-\t-\t-\t-\n"),
           std::string("1e3\tp\tmatch\t5\t-\t-\t-\t-\t-\t-\n"),
           std::string("18446744073709551616\tp\tmatch\t5\t-\t-\t-\t-\t-\t-\n"),  // 2^64
           std::string("7\tp\tMatch\t5\t-\t-\t-\t-\t-\t-\n"),
           std::string("7\tp\tmatch \t5\t-\t-\t-\t-\t-\t-\n"),
           std::string("7\tp\t\t5\t-\t-\t-\t-\t-\t-\n"),
           std::string("7\tp\terror\t5\t-\t-\t-\t-\t-\t-\n"),
           std::string("7\tp\tmatch\t-\t-\t-\t-\t-\t-\t-\n"),
           std::string("7\tp\tmatch\t5\t\t-\t-\t-\t-\t-\n"),
           std::string("7\tp\tmatch\t5\t-\t-\t-\t-\t-\n"),            // 9 columns
           std::string("7\tp\tmatch\t5\t-\t-\t-\t-\t-\t-\t-\n"),      // 11
           std::string("7\tp\tmatch\t5\t-\t-\t-\t../x.ttr\t-\t-\n"),  // not in the folder
           std::string("7\tp\tmatch\t5\t-\t-\t-\t/x.ttr\t-\t-\n"),
           std::string("7\tp\tdiverged\t5\t-\t-\t-\t-\t..\t-\n"),
           "7" + std::string(1, '\0') + "\tp\tmatch\t5\t-\t-\t-\t-\t-\t-\n",
       }) {
    CAPTURE(line);
    CHECK(campaign::parse_results(line, {}).empty());
    // The neighbouring lines count, and no earlier result of the seed is lost.
    CHECK(campaign::parse_results(good + line, {}) == campaign::parse_results(good, {}));
    CHECK(campaign::parse_results(line + good, {}) == campaign::parse_results(good, {}));
  }
}

TEST_CASE("changed bytes of results change no other line", "[tool][campaign][corruption]") {
  std::mt19937 random(11);
  for (int i = 0; i < 2'000; ++i) {
    std::vector<SeedResult> written;
    std::vector<std::string> lines;
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      written.push_back(random_result(random));
      written.back().seed = 1'000'000 * (seed + 1);  // no changed byte turns one seed into another
      lines.push_back(campaign::result_line(written.back()));
    }
    std::string& changed = lines[2];
    for (std::size_t n = 1 + random() % 3; n > 0; --n)
      if (const std::size_t at = random() % (changed.size() - 1); random() % 4 != 0)
        changed[at] = static_cast<char>(random() % 256);
      else
        changed.erase(at, 1 + random() % 4);
    std::string text;
    for (const std::string& line : lines) text += line;
    const auto read = campaign::parse_results(text, {});
    CAPTURE(i, text);
    // A line without its end merges with the next line.
    const bool has_end = changed.back() == '\n';
    for (const std::size_t seed : {0u, 1u, 3u, 4u}) {
      if (seed == 3 && !has_end) continue;
      REQUIRE(read.count(1'000'000 * (seed + 1)) == 1);
      CHECK(read.at(1'000'000 * (seed + 1)) == written[seed]);
    }
    for (const auto& [seed, result] : read) {
      CHECK(result.trace.find('/') == std::string::npos);
      CHECK(campaign::parse_results(campaign::result_line(result), {}).count(seed) == 1);
    }
  }
}

TEST_CASE("of a file with results of many seeds, those of the campaign are held", "[tool][campaign][limits]") {
  SeedResult result;
  std::string text;
  result.verdict = verifier::Verdict::match;
  for (result.seed = 0; result.seed < 1'000; ++result.seed) text += campaign::result_line(result);
  result.seed = ~std::uint64_t{0};
  text += campaign::result_line(result);
  CHECK(campaign::parse_results(text, {}).size() == 1'001);
  const auto read = campaign::parse_results(text, {10, 19});
  REQUIRE(read.size() == 10);
  CHECK(read.begin()->first == 10);
  CHECK(read.rbegin()->first == 19);
}

TEST_CASE("the digest of a program changes with its words and with the files they name", "[tool][campaign][analytic]") {
  const TemporaryFolder folder;
  const std::string script = folder.file("game.sh");
  std::ofstream(script) << "one";
  campaign::CampaignOptions options;
  options.record = {"sh", script, "{seed}"};
  const auto digest = [&] {
    const Result<std::string> found = campaign::program_digest(options);
    REQUIRE(found);
    return *found;
  };
  const std::string first = digest();
  CHECK(digest() == first);
  std::ofstream(script) << "two";
  CHECK(digest() != first);
  std::ofstream(script) << "one";
  CHECK(digest() == first);
  options.verify = {"sh", script};
  const std::string verified = digest();
  CHECK(verified != first);
  options.restore = true;
  CHECK(digest() != verified);
  options = {};
  options.record = {"sh", script + "{seed}"};  // the same letters, split into other words
  CHECK(digest() != first);
  options.record = {folder.file("nothing")};
  CHECK(!campaign::program_digest(options));
}

}  // namespace
}  // namespace ticktrue::test
