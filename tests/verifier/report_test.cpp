// What reports look like, and which exit codes they mean.
// SPDX-License-Identifier: MIT
#include "verifier/report/report.h"

#include <nlohmann/json.hpp>

#include "base/random.h"
#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"
#include "verifier/report/json_parts.h"

namespace ticktrue::test {
namespace {

using verifier::Report;
using verifier::Verdict;

Report diverged_report() {
  injected = {37, ToySimulation::move_stage,
              [](ToySimulation& toy) { toy.bodies[1].velocity[1] = std::nextafter(toy.bodies[1].velocity[1], 1e9F); }};
  return verify_bytes(toy_trace_with(full_toy_setup(6, 0, 100), 50, 8), faulty_info);
}

TEST_CASE("report: each verdict has the exit code of the design", "[verifier][report][analytic]") {
  const std::pair<Verdict, int> codes[] = {
      {Verdict::match, 0},   {Verdict::diverged, 1},       {Verdict::error, 2},           {Verdict::incomplete, 3},
      {Verdict::damaged, 4}, {Verdict::not_comparable, 5}, {Verdict::not_reproducible, 6}};
  for (const auto& [verdict, code] : codes) {
    CHECK(verifier::verdict_info(verdict).exit_code == code);
    Report report;
    report.verdict = verdict;
    CHECK(report.exit_code() == code);
    const int bisect = verifier::git_bisect_exit_code(code);
    CHECK(bisect == (code == 2 || code == 4 || code == 5 || code == 6 ? 125 : code));
  }
  for (const auto& info : verifier::verdicts) CHECK(verifier::verdict_info(info.verdict).name == info.name);
}

TEST_CASE("report: of several files the worst counts", "[verifier][report][analytic]") {
  const int worst_first[] = {2, 1, 6, 4, 5, 3, 0};
  for (std::size_t i = 0; i < 7; ++i)
    for (std::size_t k = i; k < 7; ++k) {
      const std::vector<int> codes{worst_first[k], worst_first[i], 0};
      CHECK(verifier::worst_exit_code(codes) == worst_first[i]);
    }
}

TEST_CASE("report: only what the operating system refuses is an error of the call", "[verifier][report][corruption]") {
  CHECK(verifier::verdict_of_open_error(ErrorCode::io) == Verdict::error);
  for (const auto code : {ErrorCode::corrupt, ErrorCode::truncated, ErrorCode::incompatible, ErrorCode::unsupported,
                          ErrorCode::limit, ErrorCode::invalid_scene, ErrorCode::invalid_input}) {
    Report report = verifier::open_error_report("x.ttr", Error{code, "x.ttr: broken", "mend it"});
    CHECK(report.exit_code() >= 3);
    CHECK(report.exit_code() <= 5);
    CHECK(contains(verifier::report_text(report), "reason  x.ttr: broken"));
    CHECK(nlohmann::json::parse(verifier::report_json({&report, 1}, false))["ticks_recorded"].is_null());
  }
}

TEST_CASE("report: the text names tick, stage, column, values, builds and the next command",
          "[verifier][report][analytic]") {
  const std::string text = verifier::report_text(diverged_report());
  CAPTURE(text);
  CHECK(contains(text, "diverged  toy.ttr  tick 37 of 50 ("));
  CHECK(contains(text, "\n  stage   move              first stage whose output differs; forces and before agree\n"));
  CHECK(contains(text, "\n  column  bodies.velocity   row 1 (id "));
  CHECK(contains(text, ", lane 1\n"));
  CHECK(contains(text, "\n  value   expected "));
  CHECK(contains(text, ".  1 ulp\n"));
  CHECK(contains(text, "\n  builds  recorded gcc"));
  CHECK(contains(text, "\n          here ticktrue "));
  CHECK(contains(text, "\n  input   {\"tick\":37,\"type\":\"push\""));
  CHECK(contains(text, "\n  again   ticktrue verify toy.ttr --mode replay --from 32 --to 37\n"));
}

TEST_CASE("report: a match is one line", "[verifier][report][analytic]") {
  const Report report = verify_bytes(toy_trace_with(toy_setup(6), 50, 8), toy_info);
  CHECK(verifier::report_text(report) == "match  toy.ttr  50 of 50 ticks compared (0.703 s)\n");
}

TEST_CASE("report: a cut trace names the last good tick and the inputs in flight", "[verifier][report][corruption]") {
  const Bytes trace = toy_trace_with(toy_setup(4), 40, 0);
  bool seen = false;
  for (std::size_t size = trace.size() / 2; size < trace.size() && !seen; ++size) {
    auto reader = replay::TraceReader::open_bytes(ByteView(trace).first(size), "cut.ttr");
    REQUIRE(reader);
    const Report report = verify(*reader, verify_options(toy_info));
    REQUIRE(report.end);
    if (report.end->pending_inputs.empty()) continue;
    seen = true;
    const std::string last = std::to_string(report.ticks_compared - 1);
    const std::string text = verifier::report_text(report);
    CAPTURE(text);
    CHECK(contains(text, "incomplete  cut.ttr  "));
    CHECK(contains(text, "last good tick " + last));
    CHECK(contains(text, "tick " + std::to_string(report.ticks_compared) + " was in flight"));
    CHECK(contains(text, "ticktrue recover cut.ttr"));
    const auto json = nlohmann::json::parse(verifier::report_json({&report, 1}, false));
    CHECK(json["end"]["last_good_tick"] == report.ticks_compared - 1);
    CHECK(json["end"]["condition"] == "truncated");
    CHECK(json["end"]["pending"]["tick"] == report.ticks_compared);
    CHECK(json["end"]["pending"]["inputs"].size() > 0);
  }
  CHECK(seen);
}

TEST_CASE("report: JSON has the fields of the design", "[verifier][report][analytic]") {
  const Report report = diverged_report();
  const auto json = nlohmann::json::parse(verifier::report_json({&report, 1}, false));
  CHECK(json["schema"] == "ticktrue.verify/2");
  CHECK(json["verdict"] == "diverged");
  CHECK(json["ticks_recorded"] == 50);
  CHECK(json["ticks_compared"] == 38);
  const auto& divergence = json["divergence"];
  CHECK(divergence["tick"] == 37);
  CHECK(divergence["time_s"].is_number_float());
  CHECK(divergence["stage"] == "move");
  CHECK(divergence["table"] == "bodies");
  CHECK(divergence["columns"] == std::vector<std::string>{"velocity"});
  REQUIRE(divergence["rows"].size() == 1);
  const auto& row = divergence["rows"][0];
  CHECK(row["row"] == 1);
  CHECK(row["id"].is_number_unsigned());
  CHECK(row["name"] == "toy_" + std::to_string(row["id"].get<int>()));
  CHECK(row["column"] == "velocity");
  CHECK(row["lane"] == 1);
  CHECK(row["expected"].get<std::string>().size() == 8);
  CHECK(row["got"].get<std::string>().size() == 8);
  CHECK(row["ulp"] == 1);
  for (const char* field : {"file", "warnings", "end", "intact_after", "builds", "inputs", "passed", "failed",
                            "expected", "not_applicable"})
    CHECK(json.contains(field));
  CHECK(json["failed"] == 1);

  const Report match = verify_bytes(toy_trace_with(toy_setup(6), 50, 8), toy_info);
  const auto same = nlohmann::json::parse(verifier::report_json({&match, 1}, false));
  CHECK(same["verdict"] == "match");
  CHECK(same["divergence"].is_null());
  CHECK(same["passed"] == 1);
}

TEST_CASE("report: values in JSON are numbers, and texts where no number is exact", "[verifier][report][analytic]") {
  struct Value {
    ScalarType type;
    std::uint64_t bits;
    const char* json;
  };
  const Value values[] = {
      {ScalarType::u8, 255, "255"},
      {ScalarType::i8, 0xff, "-1"},
      {ScalarType::i16, 0x8000, "-32768"},
      {ScalarType::i32, 0x80000000, "-2147483648"},
      {ScalarType::u32, 0xffffffff, "4294967295"},
      {ScalarType::u64, std::uint64_t{1} << 53, "9007199254740992"},
      {ScalarType::u64, (std::uint64_t{1} << 53) + 1, "\"9007199254740993\""},
      {ScalarType::u64, ~std::uint64_t{0}, "\"18446744073709551615\""},
      {ScalarType::i64, ~std::uint64_t{0}, "-1"},
      {ScalarType::i64, 0 - (std::uint64_t{1} << 53), "-9007199254740992"},
      {ScalarType::i64, 0 - (std::uint64_t{1} << 53) - 1, "\"-9007199254740993\""},
      {ScalarType::i64, std::uint64_t{1} << 63, "\"-9223372036854775808\""},
      {ScalarType::f32, bits_of(0.1f), "0.1"},
      {ScalarType::f32, bits_of(-0.0f), "-0.0"},
      {ScalarType::f64, bits_of(0.1), "0.1"},
      {ScalarType::f64, bits_of(1e300), "1e+300"},
      {ScalarType::f64, bits_of(5e-324), "5e-324"},
      {ScalarType::f64, bits_of(9007199254740994.0), "9.007199254740994e+15"},
      {ScalarType::f64, 0x7ff0000000000000, "\"inf\""},
      {ScalarType::f64, 0xfff0000000000000, "\"-inf\""},
      {ScalarType::f32, 0x7fc00000, "\"nan\""},
  };
  for (const Value& value : values) {
    CAPTURE(value.json);
    const nlohmann::ordered_json json = verifier::value_json(value.type, value.bits);
    CHECK(json.dump() == value.json);
    // As text it is what the text of a report has, and in version 1 the JSON had.
    CHECK(verifier::value_text(json) == lane_text(value.type, value.bits));
    CHECK(verifier::value_text(lane_text(value.type, value.bits)) == lane_text(value.type, value.bits));
  }
  for (const char* none : {"null", "true", "[1]", "{}"})
    CHECK(verifier::value_text(nlohmann::json::parse(none)).empty());
}

TEST_CASE("report: a number in JSON gives back the bits of its type", "[verifier][report][property]") {
  Random random(20261126);
  for (int i = 0; i < 20'000; ++i) {
    const std::uint64_t bits = random.bits();
    const nlohmann::ordered_json wide = verifier::value_json(ScalarType::f64, bits);
    if (wide.is_number()) CHECK(bits_of(nlohmann::json::parse(wide.dump()).get<double>()) == bits);
    const auto low = static_cast<std::uint32_t>(bits);
    const nlohmann::ordered_json narrow = verifier::value_json(ScalarType::f32, low);
    if (narrow.is_number()) CHECK(bits_of(nlohmann::json::parse(narrow.dump()).get<float>()) == low);
  }
}

TEST_CASE("report: several files are one JSON object with a row each", "[verifier][report][analytic]") {
  const Report reports[] = {verify_bytes(toy_trace_with(toy_setup(6), 50, 8), toy_info), diverged_report(),
                            verifier::open_error_report("x.ttr", Error{ErrorCode::incompatible, "x.ttr: newer", ""})};
  const auto json = nlohmann::json::parse(verifier::report_json(reports, false));
  CHECK(json["schema"] == "ticktrue.verify/2");
  CHECK(json["passed"] == 1);
  CHECK(json["failed"] == 1);
  CHECK(json["not_applicable"] == 1);
  CHECK(json["expected"] == 0);
  REQUIRE(json["rows"].size() == 3);
  CHECK(json["rows"][1]["divergence"]["tick"] == 37);
  CHECK(json["rows"][2]["verdict"] == "not_comparable");
}

TEST_CASE("report: text from a file cannot steer a terminal or a shell", "[verifier][report][analytic]") {
  Report report = diverged_report();
  report.recorded_build = {{"compiler", "gcc\x1b[31m"}};
  report.divergence->inputs = "{\"a\":\"\x07\"}\n";
  const std::string text = verifier::report_text(report);
  CHECK(!contains(text, "\x1b"));
  CHECK(!contains(text, "\x07"));
  CHECK(verifier::shell_word("a b'c.ttr") == "'a b'\\''c.ttr'");
  CHECK(verifier::shell_word("traces/x-1.ttr") == "traces/x-1.ttr");
}

}  // namespace
}  // namespace ticktrue::test
