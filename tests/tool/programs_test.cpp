// The command line of --command, reports read back from JSON, and two reports on one trace.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstddef>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/compare/pair_report.h"
#include "verifier/programs/command_words.h"
#include "verifier/programs/elf_file.h"
#include "verifier/programs/linked_libraries.h"
#include "verifier/programs/program_files.h"
#include "verifier/report/report_read.h"

namespace {

using namespace ticktrue;
using namespace ticktrue::verifier;

std::string quoted(const std::string& word, std::mt19937& random) {
  if (random() % 2 == 0) return shell_word(word);
  std::string text = "\"";
  for (const char c : word) text += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
  return text + "\"";
}

TEST_CASE("words that were quoted come back as they were", "[verifier][programs]") {
  std::mt19937 random(20261125);
  constexpr std::string_view characters = "ab \t'\"\\|&;<>()$`{}*?~#\n=";
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::string> words(1 + random() % 4);
    std::string text;
    for (std::string& word : words) {
      for (std::size_t n = random() % 6; n > 0; --n) word += characters[random() % characters.size()];
      text += (random() % 2 == 0 ? " " : "\t ") + quoted(word, random);
    }
    CAPTURE(i, text);
    const auto split = split_command(text);
    REQUIRE(split);
    CHECK(*split == words);
  }
}

TEST_CASE("the trace takes the place of its mark in one word, whatever its name", "[verifier][programs]") {
  const std::string name = "a {} 'b' $c {trace}.ttr";
  CHECK(with_trace({"game", "--file={}", "{trace}", "{x}"}, name) ==
        std::vector<std::string>{"game", "--file=" + name, name, "{x}"});
  CHECK(with_trace({"game"}, name) == std::vector<std::string>{"game", "--verify", name});
}

TEST_CASE("marks are replaced once, and what takes their place is not searched", "[verifier][programs]") {
  std::mt19937 random(3);
  const CommandMark marks[] = {{"{seed}", "{trace}"}, {"{trace}", "{seed}"}};
  for (int i = 0; i < 500; ++i) {
    std::vector<std::string> words(1 + random() % 3), expected(words.size());
    std::vector<bool> found(2);
    for (std::size_t w = 0; w < words.size(); ++w)
      for (std::size_t n = random() % 5; n > 0; --n) {
        const char* parts[] = {"{seed}", "{trace}", "{", "}", "{se", "x"};
        const std::size_t part = random() % 6;
        words[w] += parts[part];
        expected[w] += part < 2 ? parts[1 - part] : parts[part];
        if (part < 2) found[part] = true;
      }
    CAPTURE(i, words);
    CHECK(replace_marks(words, marks) == found);
    CHECK(words == expected);
  }
}

StateSchema schema_of_units() {
  StateSchema schema;
  TableSchema& table = schema.tables.emplace_back();
  table.name = "units";
  table.columns = {{"x", ScalarType::f32, 2, 0}, {"hp", ScalarType::i64, 1, 8}};
  table.row_size = 16;
  return schema;
}

Report red_report() {
  Report report;
  report.file = "a.ttr";
  report.title = report.simulation = "game";
  report.mode = "replay";
  report.verdict = Verdict::diverged;
  report.reason = "why";
  report.ticks_recorded = 9;
  report.ticks_compared = 5;
  report.root_hash = 77;
  report.time_s = 0.25;
  Divergence& divergence = report.divergence.emplace();
  divergence.tick = 4;
  divergence.stage = "move";
  divergence.tables = {{"units", {"x", "hp"}}};
  divergence.rows = {{"units", "x", 3, 7, "unit 7", 1, 2, ScalarType::f32, 0x3f800000, 0x3f800001},
                     {"units", "hp", 4, {}, "", 0, 1, ScalarType::i64, {}, 5}};
  divergence.lane_count = 2;
  divergence.from_cells = true;
  divergence.candidates = {{"units", 3, 7, "unit 7"}};
  divergence.candidate_count = 1;
  divergence.owner_count = 8;
  divergence.expected_root = 1;
  divergence.got_root = 0xffffffffffffffff;
  divergence.inputs = "{\"tick\": 4}\n";
  report.marks = MarksDifference{4, {{"rand", 5, 12}}, 1};
  report.notes = {"a note"};
  report.warnings = {"a warning"};
  report.recorded_build = {{"version", "1"}};
  report.here_build = {{"version", "2"}};
  return report;
}

TEST_CASE("a report that was written as JSON is read as it was", "[verifier][programs]") {
  const Report report = red_report();
  const auto read = read_report(report_json({&report, 1}, false), schema_of_units());
  REQUIRE(read);
  CHECK(report_json({&read->report, 1}, false) == report_json({&report, 1}, false));
  CHECK(report_text(read->report) == report_text(report));
}

TEST_CASE("reports of version 1 are read, those of an unknown version are not", "[verifier][programs]") {
  const Report report = red_report();
  std::string text = report_json({&report, 1}, false);
  const std::size_t at = text.find("ticktrue.verify/2");
  REQUIRE(at != std::string::npos);
  text[at + 16] = '1';
  const auto read = read_report(text, schema_of_units());
  REQUIRE(read);
  CHECK(report_text(read->report) == report_text(report));
  text[at + 16] = '3';
  CHECK_FALSE(read_report(text, schema_of_units()));
}

TEST_CASE("findings of two runs are equal exactly where the runs are", "[verifier][programs]") {
  const StateSchema schema = schema_of_units();
  const auto finding = [&](const Report& report) {
    return read_report(report_json({&report, 1}, false), schema)->finding;
  };
  const std::string first = finding(red_report());
  CHECK(finding(red_report()) == first);
  Report other = red_report();
  other.divergence->got_root = 2;
  CHECK(finding(other) != first);
  other = red_report();
  other.divergence->rows[1].got = 6;
  CHECK(finding(other) != first);
  other = red_report();
  other.wall_s = 3;
  CHECK(finding(other) == first);
}

TEST_CASE("bytes that were changed in a report give a report or none, and no lane that the schema lacks",
          "[verifier][programs]") {
  const Report report = red_report();
  const std::string text = report_json({&report, 1}, false);
  const StateSchema schema = schema_of_units();
  std::mt19937 random(5);
  for (int i = 0; i < 3000; ++i) {
    std::string changed = text;
    for (int n = 0; n < 3; ++n) changed[random() % changed.size()] = static_cast<char>(random() % 256);
    const auto read = read_report(changed, schema);
    if (!read || !read->report.divergence) continue;
    for (const LaneReport& row : read->report.divergence->rows) {
      REQUIRE(row.table == "units");
      REQUIRE(row.lane < row.lane_count);
    }
    report_text(read->report);
  }
  CHECK_FALSE(read_report(std::string(100000, '['), schema));
  CHECK_FALSE(read_report("", schema));
}

/// A program that diverges from the recording at `tick`, in both lanes of x, by these bits. 0: as recorded.
Report report_of_program(std::uint64_t tick, std::uint64_t x0, std::uint64_t x1) {
  Report report;
  report.file = "a.ttr";
  report.verdict = Verdict::diverged;
  report.ticks_compared = tick + 1;
  Divergence& divergence = report.divergence.emplace();
  divergence.tick = tick;
  divergence.tables = {{"units", {"x"}}};
  for (const auto& [lane, bits] : {std::pair{0u, x0}, std::pair{1u, x1}})
    if (bits != 0) divergence.rows.push_back({"units", "x", 3, 7, "", lane, 2, ScalarType::f32, 100 + lane, bits});
  divergence.lane_count = divergence.rows.size();
  divergence.expected_root = 1000;
  divergence.got_root = 1000 + x0 + 10 * x1;
  return report;
}

Report matching_report() {
  Report report;
  report.verdict = Verdict::match;
  report.ticks_compared = 50;
  return report;
}

TEST_CASE("two programs that give the recorded bits are a match", "[verifier][programs]") {
  const Report pair = pair_of_programs(matching_report(), matching_report(), "other");
  CHECK(pair.verdict == Verdict::match);
  REQUIRE(pair.notes.size() == 1);
  CHECK(pair.notes[0] == "other gives the recorded bits too, in all 50 ticks");
}

TEST_CASE("the side that leaves the recording first has its value, the other one the recorded value",
          "[verifier][programs]") {
  const Report here = pair_of_programs(report_of_program(5, 1, 0), matching_report(), "other");
  REQUIRE(here.divergence);
  CHECK(here.divergence->tick == 5);
  CHECK(here.divergence->rows[0].expected == 100u);
  CHECK(here.divergence->rows[0].got == 1u);
  const Report there = pair_of_programs(matching_report(), report_of_program(5, 1, 0), "other");
  REQUIRE(there.divergence);
  CHECK(there.verdict == Verdict::diverged);
  CHECK(there.divergence->rows[0].expected == 1u);
  CHECK(there.divergence->rows[0].got == 100u);
  CHECK(there.divergence->expected_root == 1001);
  const Report later = pair_of_programs(report_of_program(9, 2, 0), report_of_program(5, 1, 0), "other");
  CHECK(later.divergence->tick == 5);
  CHECK(later.divergence->rows[0].expected == 1u);
  CHECK(later.divergence->rows[0].got == 100u);
}

TEST_CASE("of two that leave the recording at one tick, the lanes that differ between them are told",
          "[verifier][programs]") {
  const Report pair = pair_of_programs(report_of_program(5, 1, 3), report_of_program(5, 1, 0), "other");
  REQUIRE(pair.divergence);
  CHECK(pair.divergence->tick == 5);
  REQUIRE(pair.divergence->rows.size() == 1);
  CHECK(pair.divergence->rows[0].lane == 1);
  CHECK(pair.divergence->rows[0].expected == 101u);  // as recorded
  CHECK(pair.divergence->rows[0].got == 3u);
  const Report alike = pair_of_programs(report_of_program(5, 1, 3), report_of_program(5, 1, 3), "other");
  CHECK(alike.verdict == Verdict::diverged);
  REQUIRE(alike.divergence);
  CHECK(alike.divergence->rows.size() == 2);
  CHECK(alike.divergence->rows[0].expected == 100u);
  REQUIRE(alike.notes.size() == 2);
  CHECK(alike.notes[0].compare(0, 45, "both builds give the same other bits at tick ") == 0);
}

TEST_CASE("a program that was not judged decides the verdict of the pair", "[verifier][programs]") {
  Report cut = matching_report();
  cut.verdict = Verdict::incomplete;
  cut.reason = "ended";
  CHECK(pair_of_programs(matching_report(), cut, "other").verdict == Verdict::incomplete);
  CHECK(pair_of_programs(cut, matching_report(), "other").verdict == Verdict::incomplete);
  CHECK(pair_of_programs(report_of_program(5, 1, 0), cut, "other").verdict == Verdict::incomplete);
  cut.verdict = Verdict::error;
  CHECK(pair_of_programs(matching_report(), cut, "other").verdict == Verdict::error);
}

TEST_CASE("the dynamic linker of a program is found, and damaged headers name none outside of the bounds",
          "[verifier][programs][corruption]") {
  Bytes begin = test::read_file("/proc/self/exe");
  begin.resize(std::min<std::size_t>(begin.size(), 16u << 10));
  const auto linker_of = [](const Bytes& bytes) {
    std::istringstream in(std::string(bytes.begin(), bytes.end()));
    return elf_linker_name(in);
  };
  const std::string name = linker_of(begin);
  CHECK((name.empty() || name.front() == '/'));
  CHECK(linker_of({'#', '!', '/', 'b', 'i', 'n'}).empty());
  std::mt19937 random(7);
  for (int i = 0; i < 5000; ++i) {
    Bytes changed = begin;
    changed[random() % 1024] = static_cast<std::uint8_t>(random() % 256);
    if (random() % 3 == 0) changed.resize(random() % 1024);
    CHECK(linker_of(changed).size() <= 4096);
  }
}

TEST_CASE("libraries are taken from the list of a dynamic linker, and a missing one is an error",
          "[verifier][programs][analytic]") {
  const std::string text =
      "\tlinux-vdso.so.1 (0x00007ffd)\n\tlibm.so.6 => /lib/x86 64/libm.so.6 "
      "(0x00007f3a)\n\t/lib64/ld-linux-x86-64.so.2 "
      "(0x00007f3b)\n";
  const auto libraries = listed_libraries("game", text);
  REQUIRE(libraries);
  CHECK(*libraries == std::vector<std::string>{"/lib/x86 64/libm.so.6", "/lib64/ld-linux-x86-64.so.2"});
  const auto missing = listed_libraries("game", text + "\tlibrules.so => not found\n");
  REQUIRE_FALSE(missing);
  CHECK(missing.error().message == "game: its library librules.so was not found, expected one");
}

TEST_CASE("the files of a command are its program, its libraries and what its words name", "[verifier][programs]") {
  const test::TemporaryFolder folder;
  for (const char* name : {"level", "settings"}) test::write_file(folder.file(name), Bytes{1});
  const auto files =
      program_files({"sh", folder.file("level"), "--with=" + folder.file("settings"), "{}", "nothing"}, {});
  REQUIRE(files);
  const auto has = [&](const std::string& end) {
    return std::any_of(files->begin(), files->end(), [&](const ProgramFile& file) {
      return file.path.size() >= end.size() && file.path.compare(file.path.size() - end.size(), end.size(), end) == 0;
    });
  };
  CHECK(has("sh"));
  CHECK(has("/level"));
  CHECK(has("/settings"));
  CHECK_FALSE(has("nothing"));
  CHECK(std::any_of(files->begin(), files->end(),
                    [](const ProgramFile& file) { return file.name.find("libc") != std::string::npos; }));
  CHECK_FALSE(program_files({"no_such_program_anywhere"}, {}));
  CHECK_FALSE(program_files({"sh"}, {folder.file("nothing")}));
}

}  // namespace
