// Facts about the build of the program: what a session writes, what it refuses, and how reports tell differences.
// SPDX-License-Identifier: MIT
#include "capi/program_facts.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "base/build_info.h"
#include "include/ticktrue.h"
#include "replay/trace_reader.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/compare/diff.h"
#include "verifier/report/fact_differences.h"
#include "verifier/report/report.h"

namespace ticktrue::test {
namespace {

using capi::program_build_id;
using replay::BuildFacts;
using verifier::FactDifference;

struct Run {
  int exit_code = 0;
  std::string text;
  std::string json;
  std::string message;
};

/// A counter of ten ticks; `fault` is added in tick 5.
Run count_ticks(const std::string& path, int mode, const char* facts, std::uint32_t fault = 0,
                void (*before)(ticktrue_session*) = nullptr) {
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = mode;
  options.path = path.c_str();
  options.name = "facts-test";
  options.build = "r12";
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC;
  options.caller_facts = facts;
  ticktrue_session* session = ticktrue_open(&options);
  if (before != nullptr) before(session);
  std::uint32_t value = 0;
  ticktrue_column(session, "world", "value", &value, TICKTRUE_U32, 1, 1, 0);
  for (int tick = 0; tick < 10; ++tick) {
    if (ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK) break;
    value += 3 + (tick == 5 ? fault : 0);
    ticktrue_end_tick(session);
  }
  Run run;
  run.exit_code = ticktrue_finish(session);
  run.text = ticktrue_report(session);
  run.json = ticktrue_report_json(session);
  run.message = ticktrue_message(session);
  ticktrue_close(session);
  return run;
}

BuildFacts facts_in(const std::string& path) {
  auto reader = replay::TraceReader::open(path);
  REQUIRE(reader);
  return reader->facts();
}

std::string value_of(const BuildFacts& facts, const std::string& name) {
  for (const auto& [found, value] : facts)
    if (found == name) return value;
  return "";
}

constexpr const char* plain_facts =
    "compiler=gcc 12.2.0\nlanguage=c17\nfused=no\nsimd=sse2\nndebug=no\ntarget=x86_64 linux";
constexpr const char* fused = "compiler=gcc 13.1.0\nlanguage=c17\nsimd=avx2\nndebug=no\nfused=yes\ntarget=x86_64 linux";

TEST_CASE("the facts of the unit that opens a session are in its trace", "[capi][facts]") {
  const TracePath path;
  REQUIRE(count_ticks(path("x.ttr"), TICKTRUE_RECORD, TICKTRUE_CALLER_FACTS).exit_code == 0);
  const BuildFacts facts = facts_in(path("x.ttr"));
#if defined(__clang__)
  CHECK(contains(value_of(facts, "caller.compiler"), "clang " + std::to_string(__clang_major__) + "."));
#else
  CHECK(contains(value_of(facts, "caller.compiler"), "gcc " + std::to_string(__GNUC__) + "."));
#endif
  CHECK(value_of(facts, "caller.language") == "c++20");
  CHECK(value_of(facts, "caller.fused") == "no");
  CHECK(value_of(facts, "caller.fast_math") == "no");
  CHECK(value_of(facts, "caller.pointer") == std::to_string(8 * sizeof(void*)));
  CHECK(value_of(facts, "caller.long") == std::to_string(8 * sizeof(long)));
  CHECK(value_of(facts, "build") == "r12");
  for (const auto& [name, value] : facts) {
    CAPTURE(name);
    CHECK_FALSE(value.empty());
  }
  // A program that gives no facts has none; the facts change no bit of what is recorded.
  REQUIRE(count_ticks(path("none.ttr"), TICKTRUE_RECORD, nullptr).exit_code == 0);
  for (const auto& [name, value] : facts_in(path("none.ttr"))) CHECK_FALSE(contains(name, "caller."));
  CHECK(count_ticks(path("none.ttr"), TICKTRUE_VERIFY, plain_facts).exit_code == 0);
}

TEST_CASE("a red report of a session tells the programs and what differs, not the library's flags", "[capi][facts]") {
  const TracePath path;
  REQUIRE(count_ticks(path("x.ttr"), TICKTRUE_RECORD, plain_facts).exit_code == 0);
  const Run green = count_ticks(path("x.ttr"), TICKTRUE_VERIFY, fused);
  CHECK(green.exit_code == 0);
  CHECK_FALSE(contains(green.text, "fused"));
  const Run red = count_ticks(path("x.ttr"), TICKTRUE_VERIFY, fused, 1);
  CAPTURE(red.text);
  CHECK(red.exit_code == 1);
  CHECK(contains(red.text, "\n  program recorded gcc 12.2.0, c17, x86_64 linux"));
  CHECK(contains(red.text, "\n          here gcc 13.1.0, c17, x86_64 linux"));
  CHECK(contains(red.text, "\n  differs fused: recorded no, here yes (changes bits)\n"));
  CHECK(contains(red.text, "\n          compiler: recorded gcc 12.2.0, here gcc 13.1.0\n"));
  CHECK(contains(red.text, "\n          simd: recorded sse2, here avx2\n"));
  CHECK_FALSE(contains(red.text, "ndebug"));
  CHECK(contains(red.text, "build r12"));
  CHECK_FALSE(contains(red.text, " " + build_info().compiler + " "));
  CHECK_FALSE(contains(red.text, build_line()));
  const auto json = nlohmann::json::parse(red.json);
  CHECK(json["builds"]["recorded"]["caller.fused"] == "no");
  CHECK(json["builds"]["here"]["caller.fused"] == "yes");
  CHECK_FALSE(json["builds"]["here"].contains("flags"));
  REQUIRE(json["builds"]["differ"].size() == 3);
  CHECK(json["builds"]["differ"][0] == nlohmann::json::parse(R"({"name": "fused", "recorded": "no", "here": "yes",
    "changes_bits": true})"));
  CHECK(json["builds"]["differ"][1]["changes_bits"] == false);

  // If one side gives no facts, the report says so, and names no difference.
  const Run silent = count_ticks(path("x.ttr"), TICKTRUE_VERIFY, nullptr, 1);
  CAPTURE(silent.text);
  CHECK(contains(silent.text, "program recorded gcc 12.2.0, c17"));
  CHECK(contains(silent.text, program_build_id().empty() ? "here not known" : "here build id "));
  CHECK_FALSE(contains(silent.text, "differs"));
}

TEST_CASE("further units have facts of their own", "[capi][facts]") {
  const TracePath path;
  const auto with_unit = [](ticktrue_session* session) {
    CHECK(ticktrue_build_facts(session, "physics.c", "fused=no\nfast_math=no") == TICKTRUE_OK);
    CHECK(ticktrue_build_facts(session, "audio", "fast_math=yes") == TICKTRUE_OK);
  };
  const auto with_fast_unit = [](ticktrue_session* session) {
    CHECK(ticktrue_build_facts(session, "physics.c", "fused=no\nfast_math=yes") == TICKTRUE_OK);
  };
  REQUIRE(count_ticks(path("x.ttr"), TICKTRUE_RECORD, plain_facts, 0, with_unit).exit_code == 0);
  CHECK(value_of(facts_in(path("x.ttr")), "caller.physics.c.fast_math") == "no");
  const Run red = count_ticks(path("x.ttr"), TICKTRUE_VERIFY, plain_facts, 1, with_fast_unit);
  CAPTURE(red.text);
  CHECK(contains(red.text, "differs physics.c.fast_math: recorded no, here yes (changes bits)"));
  CHECK(contains(red.text, "audio: recorded with facts, here not known\n"));
}

TEST_CASE("facts that are wrong are refused with the line to mend", "[capi][facts][corruption]") {
  const std::string long_value = "flags=" + std::string(5'000, 'x');
  std::string many;
  for (int i = 0; i < 33; ++i) many += "f" + std::to_string(i) + "=1\n";
  const struct {
    const char* facts;
    const char* message;
  } wrongs[] = {
      {"fused", "caller_facts: found a line without '=': fused"},
      {"Fused=no", "caller_facts: name: found \"Fused\", expected 1..64 of a-z, 0-9 and _"},
      {"=no", "name: found \"\""},
      {"fused=no\nfused=yes", "caller_facts: fused: stands twice"},
      {long_value.c_str(), "flags: bytes: expected at most 4096"},
      {many.c_str(), "caller_facts: facts: expected at most 32"},
  };
  const TracePath path;
  for (const auto& wrong : wrongs) {
    const Run run = count_ticks(path("x.ttr"), TICKTRUE_RECORD, wrong.facts);
    CAPTURE(run.message, wrong.message);
    CHECK(run.exit_code == 2);
    CHECK(contains(run.message, wrong.message));
    CHECK_FALSE(std::filesystem::exists(path("x.ttr")));
  }
  const struct {
    void (*call)(ticktrue_session*);
    const char* message;
  } wrong_calls[] = {
      {[](ticktrue_session* s) { ticktrue_build_facts(s, nullptr, "fused=no"); }, "build_facts: unit: name: found 0"},
      {[](ticktrue_session* s) { ticktrue_build_facts(s, "a", nullptr); }, "unit a: found null, expected lines"},
      {[](ticktrue_session* s) {
         ticktrue_build_facts(s, "a", "fused=no");
         ticktrue_build_facts(s, "a", "fused=no");
       },
       "unit a: stands twice"},
      {[](ticktrue_session* s) {
         for (char c = 'a'; c < 'z'; ++c) ticktrue_build_facts(s, std::string(1, c).c_str(), "fused=no");
       },
       "units: expected at most 16"},
      {[](ticktrue_session* s) {
         std::string text;
         for (int i = 0; i < 30; ++i) text += "f" + std::to_string(i) + "=1\n";
         for (char c = 'a'; c < 'm'; ++c) ticktrue_build_facts(s, std::string(1, c).c_str(), text.c_str());
       },
       "facts of all units: expected at most 240"},
      {[](ticktrue_session* s) {
         static std::uint32_t value = 0;
         ticktrue_column(s, "world", "value", &value, TICKTRUE_U32, 1, 1, 0);
         ticktrue_begin_tick(s, nullptr);
         ticktrue_build_facts(s, "late", "fused=no");
       },
       "build_facts: found facts after the first tick"},
  };
  for (const auto& wrong : wrong_calls) {
    const Run run = count_ticks(path("call.ttr"), TICKTRUE_RECORD, plain_facts, 0, wrong.call);
    CAPTURE(run.message, wrong.message);
    CHECK(run.exit_code == 2);
    CHECK(contains(run.message, wrong.message));
  }
  CHECK(ticktrue_build_facts(nullptr, nullptr, nullptr) == TICKTRUE_OK);
}

TEST_CASE("as many facts as a session takes are in its trace, and recovering keeps them", "[capi][facts][limits]") {
  const TracePath path;
  const auto with_units = [](ticktrue_session* session) {
    std::string text;
    for (int i = 0; i < 30; ++i) text += "f" + std::to_string(i) + "=" + std::string(2'000, 'x') + "\n";
    for (const char* unit : {"a", "b", "c", "d", "e", "f", "g", "h"})
      CHECK(ticktrue_build_facts(session, unit, text.c_str()) == TICKTRUE_OK);
    CHECK(ticktrue_build_facts(session, "empty", "") == TICKTRUE_OK);
  };
  REQUIRE(count_ticks(path("x.ttr"), TICKTRUE_RECORD, nullptr, 0, with_units).exit_code == 0);
  const BuildFacts facts = facts_in(path("x.ttr"));
  const auto is_of_unit = [](const auto& fact) { return contains(fact.first, "caller."); };
  CHECK(std::count_if(facts.begin(), facts.end(), is_of_unit) == 240);
  CHECK(count_ticks(path("x.ttr"), TICKTRUE_VERIFY, nullptr).exit_code == 0);
  std::filesystem::resize_file(path("x.ttr"), std::filesystem::file_size(path("x.ttr")) - 100);
  REQUIRE(replay::recover_trace(path("x.ttr"), path("again.ttr"), false));
  CHECK(facts_in(path("again.ttr")) == facts);
}

TEST_CASE("any text is refused, or is facts in the order of its lines", "[capi][facts][property]") {
  std::mt19937 random(31);
  const std::string letters = "ab_9=\n\n.A \x01\xff";
  int accepted = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::string text;
    for (std::size_t size = random() % 12; size > 0; --size) text += letters[random() % letters.size()];
    capi::ProgramFacts facts("");
    const std::size_t before = facts.all().size();
    const bool is_taken = static_cast<bool>(facts.add("u", text.c_str()));
    std::string again;
    const BuildFacts all = facts.all();
    for (std::size_t i = before; i < all.size(); ++i)
      again += all[i].first.substr(std::string("caller.u.").size()) + "=" + all[i].second + "\n";
    std::string expected;  // the lines without empty ones
    for (const std::string& line : verifier::split_lines(text))
      if (!line.empty()) expected += line + "\n";
    if (is_taken) CHECK(again == expected);
    if (!is_taken) CHECK(again.empty());
    accepted += is_taken && !expected.empty();
  }
  CHECK(accepted > 100);
}

TEST_CASE("the build id is the one in the program's file", "[capi][facts]") {
  const std::string id = program_build_id();
  SKIP_UNLESS(!id.empty(), "a program without a build id");
  REQUIRE(id.size() % 2 == 0);
  std::string bytes;
  for (std::size_t i = 0; i < id.size(); i += 2) bytes += static_cast<char>(std::stoi(id.substr(i, 2), nullptr, 16));
  std::ifstream in("/proc/self/exe", std::ios::binary);
  SKIP_UNLESS(in.good(), "a system without /proc");
  const std::string program(std::istreambuf_iterator<char>(in), {});
  CHECK(contains(program, bytes));
  const TracePath path;
  REQUIRE(count_ticks(path("x.ttr"), TICKTRUE_RECORD, nullptr).exit_code == 0);
  CHECK(value_of(facts_in(path("x.ttr")), "program.build_id") == id);
}

TEST_CASE("diff tells the programs of two sessions and what differs", "[capi][facts][diff]") {
  const TracePath path;
  REQUIRE(count_ticks(path("a.ttr"), TICKTRUE_RECORD, plain_facts).exit_code == 0);
  REQUIRE(count_ticks(path("b.ttr"), TICKTRUE_RECORD, fused, 1).exit_code == 0);
  auto a = replay::TraceReader::open(path("a.ttr"));
  auto b = replay::TraceReader::open(path("b.ttr"));
  REQUIRE(a);
  REQUIRE(b);
  const verifier::DiffReport report = verifier::diff(*a, *b, {});
  const std::string text = verifier::diff_text(report);
  CAPTURE(text);
  CHECK(report.verdict == verifier::DiffVerdict::different);
  CHECK(contains(text, "\n  program a gcc 12.2.0, c17, x86_64 linux"));
  CHECK(contains(text, "\n          b gcc 13.1.0, c17, x86_64 linux"));
  CHECK(contains(text, "\n  differs fused: a no, b yes (changes bits)\n"));
  const auto json = nlohmann::json::parse(verifier::diff_json(report));
  CHECK(json["build_differences"][0]["name"] == "fused");
  CHECK(json["build_differences"][0]["b"] == "yes");
}

TEST_CASE("facts that change bits come first, whatever their order in the traces", "[capi][facts]") {
  const BuildFacts a{{"version", "1"},           {"caller.compiler", "x"}, {"caller.flt_eval_method", "0"},
                     {"caller.fast_math", "no"}, {"caller.u.fused", "no"}, {"caller.fused", "no"}};
  BuildFacts b{{"version", "2"},
               {"caller.fused", "yes"},
               {"caller.compiler", "y"},
               {"caller.fast_math", "yes"},
               {"caller.flt_eval_method", "2"},
               {"caller.u.fused", "yes"}};
  std::string names;
  for (const FactDifference& difference : verifier::fact_differences(a, b)) names += difference.name + " ";
  CHECK(names == "u.fused fused fast_math flt_eval_method compiler ");
  CHECK(verifier::fact_differences(a, a).empty());
  CHECK(verifier::fact_differences(a, {{"version", "2"}}).empty());
  // A fact that one side lacks is no cause.
  b.erase(b.begin() + 1);
  const std::vector<FactDifference> found = verifier::fact_differences(a, b);
  REQUIRE(found.size() == 5);
  CHECK(found.back().name == "fused");
  CHECK(found.back().b == "not known");
  CHECK_FALSE(found.back().changes_bits);
}

}  // namespace
}  // namespace ticktrue::test
