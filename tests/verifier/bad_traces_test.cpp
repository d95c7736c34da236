// Every damaged trace of traces/bad gives the exit code and the message that EXPECTED.tsv promises.
// SPDX-License-Identifier: MIT
//
// Verified: exit code, a piece of the message, that the tool ends by itself. Not verified: the whole text of a message;
// damage of every single byte (tests/replay and tests/properties do that in memory).
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "tests/support/catch.h"

namespace {

namespace fs = std::filesystem;

struct BadTrace {
  std::string file;
  std::string source;
  std::string recipe;
  int exit_code = 0;
  std::string message;
};

const fs::path source_root = TICKTRUE_SOURCE_DIR;

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == '\t')
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

std::vector<BadTrace> expected_rows() {
  std::vector<BadTrace> rows;
  std::ifstream in(source_root / "traces/bad/EXPECTED.tsv");
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#' || line.compare(0, 5, "file\t") == 0) continue;
    const std::vector<std::string> fields = fields_of(line);
    CAPTURE(line);
    REQUIRE(fields.size() == 6);  // file, source, recipe, exit code, message, why
    rows.push_back({fields[0], fields[1], fields[2], std::stoi(fields[3]), fields[4]});
  }
  return rows;
}

struct ToolOutcome {
  int exit_code = -1;  // -1: killed by a signal
  std::string output;  // stdout and stderr
};

ToolOutcome run_tool(const std::string& arguments) {
  const std::string command = std::string("'") + TICKTRUE_TOOL + "' " + arguments + " 2>&1 </dev/null";
  ToolOutcome outcome;
  std::FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::array<char, 4096> buffer{};
  for (std::size_t size = 0; (size = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    outcome.output.append(buffer.data(), size);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
  return outcome;
}

TEST_CASE("each damaged trace gives its exit code and message", "[verifier][bad_traces][corruption]") {
  const std::vector<BadTrace> rows = expected_rows();
  CHECK(rows.size() >= 15);
  for (const BadTrace& row : rows) {
    const ToolOutcome outcome = run_tool("verify '" + (source_root / "traces/bad" / row.file).string() + "'");
    CAPTURE(row.file, row.recipe, outcome.output);
    CHECK(outcome.exit_code == row.exit_code);
    CHECK(outcome.output.find(row.message) != std::string::npos);
    CHECK(outcome.exit_code != 0);
  }
}

TEST_CASE("a damaged trace among good ones decides the exit code", "[verifier][bad_traces][corruption]") {
  std::string good;
  for (const fs::directory_entry& entry : fs::directory_iterator(source_root / "traces"))
    if (entry.path().extension() == ".ttr" && (good.empty() || entry.path().string() < good))
      good = entry.path().string();
  REQUIRE_FALSE(good.empty());
  CHECK(run_tool("verify '" + good + "'").exit_code == 0);
  for (const BadTrace& row : expected_rows()) {
    CAPTURE(row.file);
    const std::string bad = (source_root / "traces/bad" / row.file).string();
    CHECK(run_tool("verify '" + good + "' '" + bad + "'").exit_code == row.exit_code);
  }
}

TEST_CASE("EXPECTED.tsv and traces/bad hold the same files", "[verifier][bad_traces]") {
  std::set<std::string> listed, found;
  for (const BadTrace& row : expected_rows()) listed.insert(row.file);
  for (const fs::directory_entry& entry : fs::directory_iterator(source_root / "traces/bad"))
    if (entry.path().filename() != "EXPECTED.tsv") found.insert(entry.path().filename().string());
  CHECK(listed == found);
}

}  // namespace
