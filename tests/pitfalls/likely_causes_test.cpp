// Each cause is named if its mark is present, and only then.
// SPDX-License-Identifier: MIT
#include "verifier/report/likely_causes.h"

#include <algorithm>
#include <map>

#include "base/bytes.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

using verifier::Cause;
using verifier::LaneReport;
using verifier::Report;
using verifier::Verdict;

std::uint64_t f32(float value) {
  return bits_of(value);
}
std::uint64_t f64(double value) {
  return bits_of(value);
}

LaneReport lane_of(ScalarType type, std::uint64_t expected, std::uint64_t got, std::uint64_t row = 0) {
  LaneReport lane;
  lane.table = "units";
  lane.column = "x";
  lane.row = row;
  lane.type = type;
  lane.expected = expected;
  lane.got = got;
  return lane;
}

Report report_of(std::vector<LaneReport> lanes, Verdict verdict = Verdict::diverged) {
  Report report;
  report.simulation = "game";
  report.verdict = verdict;
  report.divergence.emplace();
  report.divergence->tables = {{"units", {"x"}}};
  report.divergence->lane_count = lanes.size();
  report.divergence->rows = std::move(lanes);
  return report;
}

Report with_builds(const char* name, const char* recorded, const char* here) {
  Report report = report_of({lane_of(ScalarType::u32, 3, 4)});
  report.recorded_build = {{"caller.compiler", "gcc"}, {name, recorded}};
  report.here_build = {{"caller.compiler", "gcc"}, {name, here}};
  return report;
}

Report with_marks(const char* name, std::uint64_t expected, std::uint64_t got) {
  Report report = report_of({lane_of(ScalarType::u32, 3, 4)});
  report.marks.emplace();
  report.marks->names = {{name, expected, got}};
  return report;
}

std::map<Cause, Report> reports_with_marks() {
  return {
      {Cause::contraction, with_builds("caller.fused", "no", "yes")},
      {Cause::fast_math, with_builds("caller.fast_math", "no", "yes")},
      {Cause::unsaved_state, report_of({lane_of(ScalarType::u32, 3, 4)}, Verdict::state_incomplete)},
      {Cause::shared_generator, with_marks("libc.rand", 40, 41)},
      {Cause::uninitialised_memory, report_of({lane_of(ScalarType::f32, f32(1.5F), 0xcdcdcdcd)})},
      {Cause::address, report_of({lane_of(ScalarType::u64, 0x7f12'3456'7890, 0x7fa0'3456'7890)})},
      {Cause::clock, report_of({lane_of(ScalarType::i64, 1'764'000'000'123, 1'764'000'931'002)})},
      {Cause::negative_zero, report_of({lane_of(ScalarType::f32, f32(0), f32(-0.0F))})},
      {Cause::flush_to_zero, report_of({lane_of(ScalarType::f64, f64(1e-310), f64(0))})},
      {Cause::conversion_out_of_range, report_of({lane_of(ScalarType::i32, 0x80000000, 0x7fffffff)})},
      {Cause::decimal_comma, report_of({lane_of(ScalarType::f32, f32(12.75F), f32(12))})},
      {Cause::row_order,
       report_of({lane_of(ScalarType::f32, f32(1.1F), f32(2.2F)), lane_of(ScalarType::f32, f32(2.2F), f32(1.1F), 1)})},
      {Cause::tie, report_of({lane_of(ScalarType::i32, 7, 5), lane_of(ScalarType::i32, 1, 3, 1)})},
      {Cause::thread_order,
       report_of({lane_of(ScalarType::f32, f32(1), f32(std::nextafter(1.0F, 2.0F)))}, Verdict::not_reproducible)},
      {Cause::sum_order, report_of({lane_of(ScalarType::f64, f64(1), f64(std::nextafter(1.0, 2.0)))})},
      {Cause::other_math, report_of({lane_of(ScalarType::f64, f64(1), f64(std::nextafter(1.0, 2.0)))})},
      {Cause::random_numbers, report_of({lane_of(ScalarType::u32, 17, 91)}, Verdict::not_reproducible)},
  };
}

TEST_CASE("every cause of the table has a mark that names it", "[verifier][causes][analytic]") {
  const std::map<Cause, Report> reports = reports_with_marks();
  for (const verifier::CauseInfo& info : verifier::causes) {
    CAPTURE(info.name);
    REQUIRE(reports.count(info.cause) == 1);
    const Report& report = reports.at(info.cause);
    const std::vector<Cause> found = verifier::likely_causes(report);
    CHECK(found.size() <= 2);
    CHECK(std::find(found.begin(), found.end(), info.cause) != found.end());
    const std::string text = verifier::report_text(report);
    CAPTURE(text);
    CHECK(contains(text, std::string(info.text) + "\n"));
    CHECK(contains(verifier::report_json({&report, 1}, false), "\"cause\": \"" + std::string(info.name) + "\""));
    // The same values in a trace of our own engine. There, a divergence is a fault of the engine.
    Report own = report;
    own.simulation = "ticktrue.engine";
    CHECK(verifier::likely_causes(own).empty());
  }
}

TEST_CASE("values next to a mark name no cause", "[verifier][causes][analytic]") {
  const std::vector<LaneReport> lanes{
      lane_of(ScalarType::u32, 3, 4),                     // an ordinary number
      lane_of(ScalarType::f32, f32(1), f32(1.001F)),      // a difference in more than the last places
      lane_of(ScalarType::u64, 0x7f12'3456'7890, 17),     // only one side looks like an address
      lane_of(ScalarType::u8, 0xcd, 0xa5),                // a single byte is no mark
      lane_of(ScalarType::u32, 0xcdcdcdcd, 0xa5a5a5a5),   // both sides are fill bytes
      lane_of(ScalarType::f32, f32(0), f32(1e-30F)),      // small, but not denormal
      lane_of(ScalarType::i32, 0x80000000, 5),            // the lowest integer and any other
      lane_of(ScalarType::f32, f32(12.75F), f32(13)),     // rounded, not cut
      lane_of(ScalarType::i64, 1'764'000'000'123, 12),    // only one side looks like a time
      lane_of(ScalarType::u32, 0xffffffff, 1),            // not a negative number
      lane_of(ScalarType::f64, f64(1e300), f64(-1e200)),  // other sign, other value
  };
  for (const LaneReport& lane : lanes) {
    const Report report = report_of({lane});
    CAPTURE(verifier::report_text(report));
    CHECK(verifier::likely_causes(report).empty());
  }
  CHECK(verifier::likely_causes(with_builds("caller.simd", "sse2", "avx2")).empty());
  CHECK(verifier::likely_causes(with_marks("hits", 40, 41)).empty());
  CHECK(verifier::likely_causes(with_marks("libc.rand", 40, 40)).empty());
  // Two of three rows are listed. The third row may explain the other two.
  Report cut =
      report_of({lane_of(ScalarType::f32, f32(1.1F), f32(2.2F)), lane_of(ScalarType::f32, f32(2.2F), f32(1.1F), 1)});
  cut.divergence->lane_count = 3;
  CHECK(verifier::likely_causes(cut).empty());
}

}  // namespace
}  // namespace ticktrue::test
