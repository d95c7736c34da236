// The tables that studies write: values of one's own against those of `replay`, and run times.
// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/cli/tool_run.h"

namespace ticktrue::test {
namespace {

using Rows = std::vector<std::vector<std::string>>;

Rows rows_of_csv(const std::string& path) {
  Rows rows;
  std::istringstream lines(text_of(path));
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

/// The number in the column of this name.
double value_in(const Rows& rows, std::size_t row, const std::string& name) {
  const auto column = std::find(rows[0].begin(), rows[0].end(), name) - rows[0].begin();
  REQUIRE(static_cast<std::size_t>(column) < rows[row].size());
  return std::strtod(rows[row][static_cast<std::size_t>(column)].c_str(), nullptr);
}

/// A box and a disc slide on a floor with friction.
std::string sliders(const std::string& friction) {
  return R"({"name":"sliders","settings":{"precision":"f64"},"bodies":[
{"type":"static","position":[0,-1],"shapes":[{"type":"box","half_size":[50,1]}]},
{"position":[0,0.5],"velocity":[3,0],"shapes":[{"type":"box","half_size":[0.5,0.5],"friction":)" +
         friction + R"(}]},
{"position":[-5,0.25],"velocity":[-2,0],"shapes":[{"type":"circle","radius":0.25}]}]})";
}

void run_tool(const std::vector<std::string>& words, const std::string& messages) {
  const int code = ToolRun(words, messages, {}).wait();
  INFO(text_of(messages));
  REQUIRE(code == 0);
}

}  // namespace

TEST_CASE("compare shows the values at the end that replay shows of the same run", "[cli][study][analytic]") {
  const TemporaryFolder folder;
  const std::string scene = folder.file("scene.json"), trace = folder.file("run.ttr");
  const std::string table = folder.file("table"), csv = folder.file("compare.csv"), json = folder.file("compare.json");
  std::ofstream(scene) << sliders("0.3");
  const std::vector<std::string> names{"bodies.1.x", "bodies.2.w", "speed_max"};
  const std::string columns = names[0] + "," + names[1] + "," + names[2];
  const std::vector<std::string> common{"compare",   scene,  "--vary",  "bodies.1.shapes.0.friction=0.2,0.9",
                                        "--ticks",   "60",   "--twins", "1",
                                        "--columns", columns};
  std::vector<std::string> words = common;
  words.insert(words.end(), {"--csv", csv});
  run_tool(words, table);
  words = common;
  words.emplace_back("--json");
  run_tool(words, json);

  const Rows compared = rows_of_csv(csv);
  double last_end = 0;
  for (const std::string friction : {"0.2", "0.9"}) {
    CAPTURE(friction);
    std::ofstream(scene) << sliders(friction);
    run_tool({"record", scene, "--ticks", "60", "-o", trace, "--force"}, folder.file("messages"));
    run_tool({"replay", trace, "--format", "csv", "--columns", columns, "-o", folder.file("replay.csv"), "--force"},
             folder.file("messages"));
    const Rows replayed = rows_of_csv(folder.file("replay.csv"));
    REQUIRE(replayed.size() == 61);
    std::size_t end = 0, first = 0;
    for (std::size_t row = 1; row < compared.size(); ++row)
      if (compared[row][0] == "friction " + friction) {
        if (first == 0) first = row;
        end = row;
      }
    REQUIRE(end - first == 119);
    const std::string texts = text_of(table).substr(text_of(table).find("at the end"));
    const std::string line = texts.substr(texts.find("friction " + friction));
    for (const std::string& name : names) {
      CAPTURE(name);
      CHECK(value_in(compared, end, name) == value_in(replayed, 60, name));
      CHECK(value_in(compared, first, name) == value_in(replayed, 1, name));  // two samples a tick
      char shown[32];
      std::snprintf(shown, sizeof shown, "%.6g", value_in(replayed, 60, name));
      CHECK(line.substr(0, line.find('\n')).find(shown) != std::string::npos);
      CHECK(text_of(json).find("\"" + name + "\"") != std::string::npos);
    }
    CHECK(value_in(compared, end, names[0]) != last_end);
    last_end = value_in(compared, end, names[0]);
  }
}

TEST_CASE("run times of stress go to a CSV file", "[cli][study]") {
  const TemporaryFolder folder;
  const std::string csv = folder.file("times.csv");
  run_tool({"stress", "--run-time", "stack_10", "--precision", "f32", "--csv", csv}, folder.file("messages"));
  const Rows rows = rows_of_csv(csv);
  REQUIRE(rows.size() == 2);
  CHECK(rows[1][0] == "stack_10");
  CHECK(value_in(rows, 1, "automatic_s") > 0);
  CHECK(value_in(rows, 1, "ratio") == Approx(value_in(rows, 1, "automatic_s") / value_in(rows, 1, "fixed_s")));
}

TEST_CASE("compare refuses tick and time as values, which are the same at each end", "[cli][study]") {
  const TemporaryFolder folder;
  const std::string messages = folder.file("messages");
  for (const std::string name : {"tick", "time"}) {
    CAPTURE(name);
    const std::vector<std::string> words{"compare", "slide", "--substeps", "4,8",
                                         "--ticks", "10",    "--columns",  "energy," + name};
    CHECK(ToolRun(words, messages, {}).wait() == 2);
    CHECK(text_of(messages).find("--columns: found " + name + ", expected a value of the world") != std::string::npos);
  }
}

}  // namespace ticktrue::test
