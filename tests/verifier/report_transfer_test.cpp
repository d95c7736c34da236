// A report comes out of a child process as it went in.
// SPDX-License-Identifier: MIT
#include "verifier/report/report_transfer.h"

#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "tests/verifier/toy_variants.h"
#include "verifier/report/report_ci.h"
#include "verifier/report/report_read.h"

namespace ticktrue::test {
namespace {

using verifier::Report;

/// All that is ever said of a report.
std::string everything(const Report& report) {
  const std::span<const Report> one(&report, 1);
  return verifier::report_text(report) + verifier::report_json(one, false) + verifier::report_junit(one, false) +
         verifier::report_github(one, true) + verifier::report_markdown(one, false) + std::to_string(report.wall_s);
}

/// With something in every field that has a place in it.
Report full_report() {
  Report report;
  report.file = "a \"b\".ttr";
  report.title = "t";
  report.simulation = "s";
  report.mode = "replay";
  report.verdict = verifier::Verdict::diverged;
  report.reason = "r";
  report.hint = "h";
  report.ticks_recorded = 1234567890123u;
  report.ticks_compared = 3;
  report.first_tick = 4;
  report.time_s = 0.1;
  report.root_hash = ~std::uint64_t{0};
  report.checkpoints_compared = 5;
  report.segments = 6;
  report.wall_s = 7.5;
  verifier::Divergence divergence;
  divergence.tick = 8;
  divergence.time_s = 9.25;
  divergence.stage = "solve";
  divergence.stage_note = "note";
  divergence.tables = {{"bodies", {"x", "y"}}, {"links", {}}, {"bodies.name", {"bytes"}, true}};
  divergence.rows = {{"bodies", "x", 1, 2u, "n", 3, 4, ScalarType::f32, 0x3f800000u, std::nullopt},
                     {"bodies", "y", 1, std::nullopt, "", 0, 1, ScalarType::i64, 5u, 6u, "bodies[1].path[2]"}};
  divergence.contents = {{"bodies[1].name", "bodies.name", 1, 2u, "n", true, "bop\x1b", "bob", 0, 4, 3, 2, 2u},
                         {"bodies[3].blob", "bodies.blob", 3, std::nullopt, "", false, std::string("\0\xff", 2),
                          std::nullopt, 7, 9, 0, 8, std::nullopt}};
  divergence.content_count = 5;
  divergence.lane_count = 10;
  divergence.from_cells = true;
  divergence.row_counts = {{"links", 2, 3}};
  divergence.candidates = {{"bodies", 1, 2u, "n"}, {"bodies", 2, std::nullopt, "", "bodies[1].path[0]"}};
  divergence.candidate_count = 11;
  divergence.owner_count = 12;
  divergence.healed = true;
  divergence.unexplained_cells = 13;
  divergence.spread = {{9, 1, 12, true}};
  divergence.expected_root = 14;
  divergence.got_root = 15;
  divergence.inputs = "{\"tick\":8}\n";
  report.divergence = divergence;
  report.non_finite = NonFinite{8, "bodies", 1, "n", "x", 2, "nan"};
  verifier::TraceEnd end;
  end.tail.condition = replay::TraceCondition::damaged;
  end.tail.ticks_intact = 16;
  end.tail.offset = 17;
  end.tail.message = "offset 17";
  end.tail.end = replay::EndRecord{replay::EndReason::interrupted, 18, "stop"};
  end.tail.has_pending_inputs = true;
  end.tail.pending_dt = 0.5;
  end.tail.pending_inputs = {1, 2, 3};
  end.tail.intact_after = {{20, 30, true}};
  end.pending_inputs = "{}\n";
  report.end = end;
  report.warnings = {"w"};
  report.notes = {"n1", "n2"};
  report.recorded_build = {{"compiler", "c"}};
  report.against = verifier::OtherBuild{"b", "match", "", 2, 3u, {{"os", "x"}}, true};
  report.again = {"ticktrue verify"};
  return report;
}

TEST_CASE("a report that went through bytes says the same", "[verifier][report][equivalence]") {
  const Report full = full_report();
  const Bytes bytes = verifier::encode_report(full);
  const auto back = verifier::decode_report(bytes);
  REQUIRE(back);
  CHECK(everything(*back) == everything(full));
  CHECK(verifier::encode_report(*back) == bytes);
  const Report real = verify_bytes(toy_trace(toy_setup(3), 12), toy_info);
  CHECK(everything(*verifier::decode_report(verifier::encode_report(real))) == everything(real));
}

TEST_CASE("the texts of a report come back from its JSON", "[verifier][report][children][equivalence]") {
  const Report full = full_report();
  const auto read = verifier::read_report(verifier::report_json({&full, 1}, false), StateSchema());
  REQUIRE(read);
  REQUIRE(read->report.divergence);
  Report expected = full, back = read->report;
  // Values of columns need the schema of the trace.
  expected.divergence->rows.clear();
  back.divergence->rows.clear();
  expected.divergence->spread.clear();  // not read
  CHECK(verifier::divergence_text(*back.divergence) == verifier::divergence_text(*expected.divergence));
  CHECK(back.divergence->contents[1].expected == full.divergence->contents[1].expected);
  const std::string text = verifier::divergence_text(*back.divergence);
  CHECK(contains(text, "text    bodies[1].name  (id 2, name \"n\")"));
  CHECK(contains(text, "expected \"bop\\x1b\".  got \"bob\".  differs at character 2; 4 and 3 bytes"));
  CHECK(contains(text, "bytes   bodies[3].blob"));
  CHECK(contains(text, "expected ff.  got no such row."));
  CHECK(contains(text, "and 3 more texts"));
}

TEST_CASE("a report that is cut or longer is refused", "[verifier][report][corruption]") {
  const Bytes bytes = verifier::encode_report(full_report());
  for (std::size_t size = 0; size < bytes.size(); ++size) CHECK(!verifier::decode_report(ByteView(bytes).first(size)));
  Bytes longer = bytes;
  longer.push_back(0);
  CHECK(!verifier::decode_report(longer));
}

}  // namespace
TEST_CASE("a number that is no verdict is refused", "[verifier][report][corruption]") {
  Bytes bytes = verifier::encode_report(Report{});
  constexpr std::size_t verdict_at = 16;  // behind four empty texts
  bytes[verdict_at] = static_cast<std::uint8_t>(verifier::Verdict::error);
  REQUIRE(verifier::decode_report(bytes));
  CHECK(verifier::decode_report(bytes)->verdict == verifier::Verdict::error);
  ++bytes[verdict_at];
  CHECK_FALSE(verifier::decode_report(bytes));
  bytes[verdict_at] = 0;
  REQUIRE(verifier::decode_report(bytes));
  bytes[verdict_at + 1] = 1;  // 256
  CHECK_FALSE(verifier::decode_report(bytes));
}

}  // namespace ticktrue::test
