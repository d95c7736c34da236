// A trace verified in parts: the joined report is that of one run, and what is missing or no match joins nothing.
// SPDX-License-Identifier: MIT
#include "verifier/verify/parts.h"

#include <string>
#include <vector>

#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"
#include "verifier/report/report_transfer.h"

namespace ticktrue::test {
namespace {

using verifier::Report;
using verifier::TracePart;
using verifier::Verdict;
using verifier::VerifyOptions;

VerifyOptions part_options(const SimulationInfo& info) {
  VerifyOptions options = verify_options(info);
  options.in_segments = true;
  return options;
}

std::size_t most_parts(ByteView trace, const VerifyOptions& options, std::size_t count_max) {
  replay::TraceReader reader = open_trace(trace);
  return verifier::count_parts(reader, options, count_max);
}

std::vector<Report> verify_parts(ByteView trace, const SimulationInfo& info, std::size_t count) {
  std::vector<Report> reports;
  for (std::size_t p = 0; p < count; ++p) {
    VerifyOptions options = part_options(info);
    options.part = TracePart{p, count};
    reports.push_back(verify_bytes(trace, options));
  }
  return reports;
}

std::vector<const Report*> pointers(const std::vector<Report>& reports) {
  std::vector<const Report*> all;
  for (const Report& report : reports) all.push_back(&report);
  return all;
}

}  // namespace

TEST_CASE("parts: joined, they are the report of one run, byte for byte", "[verifier][parts][equivalence]") {
  for (const bool full : {false, true}) {
    const Bytes trace = toy_trace_with(full ? full_toy_setup(6, 5, 20) : toy_setup(6), 100, 8);
    const Bytes whole = verifier::encode_report(verify_bytes(trace, part_options(toy_info)));
    REQUIRE(most_parts(trace, part_options(toy_info), 1000) == 13);
    for (std::size_t count = 1; count <= 13; ++count) {
      CAPTURE(full, count);
      const std::vector<Report> parts = verify_parts(trace, toy_info, count);
      const std::optional<Report> joined = verifier::join_parts(pointers(parts));
      REQUIRE(joined);
      CHECK(verifier::encode_report(*joined) == whole);
    }
  }
}

TEST_CASE("parts: wherever a trace diverges, a part is no match and nothing is joined",
          "[verifier][parts][equivalence]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 8);
  for (std::uint64_t tick = 0; tick < 60; ++tick) {
    CAPTURE(tick);
    injected = {tick, ToySimulation::move_stage, [](ToySimulation& toy) {
                  toy.bodies[1].velocity[1] = std::nextafter(toy.bodies[1].velocity[1], 1e9F);
                }};
    const std::vector<Report> parts = verify_parts(trace, faulty_info, 4);
    std::size_t red_count = 0;
    for (const Report& part : parts) {
      if (part.verdict == Verdict::match) continue;
      ++red_count;
      CHECK(part.verdict == Verdict::diverged);
      REQUIRE(part.divergence);
      CHECK(part.divergence->tick == tick);
    }
    CHECK(red_count == 1);
    CHECK(!verifier::join_parts(pointers(parts)));
  }
}

TEST_CASE("parts: what is missing, doubled, or in another order joins nothing", "[verifier][parts][corruption]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 8);
  const std::vector<Report> parts = verify_parts(trace, toy_info, 4);
  const std::vector<const Report*> all = pointers(parts);
  REQUIRE(verifier::join_parts(all));
  CHECK(!verifier::join_parts({}));
  for (std::size_t p = 0; p < all.size(); ++p) {
    CAPTURE(p);
    std::vector<const Report*> some = all;
    some.erase(some.begin() + static_cast<std::ptrdiff_t>(p));
    CHECK(!verifier::join_parts(some));
    some = all;
    some[p] = nullptr;
    CHECK(!verifier::join_parts(some));
    some[p] = all[(p + 1) % all.size()];
    CHECK(!verifier::join_parts(some));
  }
}

TEST_CASE("parts: a trace that is cut, damaged or without checkpoints has one part", "[verifier][parts][corruption]") {
  const Bytes trace = toy_trace_with(toy_setup(4), 80, 8);
  CHECK(most_parts(trace, part_options(toy_info), 4) == 4);
  CHECK(most_parts(ByteView(trace).first(trace.size() - 40), part_options(toy_info), 4) == 1);
  Bytes changed = trace;
  changed[changed.size() / 2] ^= 1;
  CHECK(most_parts(changed, part_options(toy_info), 4) == 1);
  CHECK(most_parts(toy_trace_with(toy_setup(4), 80, 0), part_options(toy_info), 4) == 1);
  VerifyOptions in_order = part_options(toy_info);
  in_order.in_segments = false;
  CHECK(most_parts(trace, in_order, 4) == 1);
  VerifyOptions beyond = part_options(toy_info);
  beyond.part = TracePart{3, 1000};
  CHECK(verify_bytes(trace, beyond).verdict == Verdict::incomplete);
}

TEST_CASE("parts: joined, they warn of a state that never changes, and only if no part saw a change",
          "[verifier][parts]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 8);
  std::vector<Report> parts = verify_parts(trace, toy_info, 4);
  for (Report& part : parts) part.state_changed = false;
  const std::optional<Report> unchanged = verifier::join_parts(pointers(parts));
  REQUIRE(unchanged);
  CHECK_FALSE(unchanged->state_changed);
  CHECK(unchanged->warnings == std::vector<std::string>{verifier::unchanged_state_warning(60)});
  for (Report& part : parts) {
    part.state_changed = true;
    const std::optional<Report> changed = verifier::join_parts(pointers(parts));
    REQUIRE(changed);
    CHECK(changed->state_changed);
    CHECK(changed->warnings.empty());
    part.state_changed = false;
  }
}

TEST_CASE("parts: joined, they keep the warnings, notes and counts of every part", "[verifier][parts]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 8);
  std::vector<Report> parts = verify_parts(trace, toy_info, 3);
  std::size_t segments = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    parts[p].warnings = {"warning " + std::to_string(p)};
    parts[p].notes = {"note " + std::to_string(p)};
    parts[p].wall_s = 1;
    segments += parts[p].segments;
  }
  const std::optional<Report> joined = verifier::join_parts(pointers(parts));
  REQUIRE(joined);
  CHECK(joined->warnings == std::vector<std::string>{"warning 0", "warning 1", "warning 2"});
  CHECK(joined->notes == std::vector<std::string>{"note 0", "note 1", "note 2"});
  CHECK(joined->segments == segments);
  CHECK(joined->wall_s == 3);
  CHECK(joined->ticks_compared == 60);
}

}  // namespace ticktrue::test
