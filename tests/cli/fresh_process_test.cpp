// A state that one process saved is loaded by another, which runs on with the same bits: for every golden scene.
// SPDX-License-Identifier: MIT
//
// A recording with a checkpoint at every tick is the saved states; `verify --from N` is a process of its own that
// begins at the checkpoint of tick N and compares what follows.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "engine/math/random.h"
#include "tests/support/catch.h"

namespace fs = std::filesystem;

namespace ticktrue::test {
namespace {

constexpr std::uint64_t ticks_compared = 20;

struct GoldenRow {
  std::string file, scene, inputs, ticks;
};

std::vector<GoldenRow> golden_rows() {
  std::ifstream in(std::string(TICKTRUE_SOURCE_DIR) + "/traces/MANIFEST.tsv");
  std::vector<GoldenRow> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    GoldenRow row;
    std::getline(fields, row.file, '\t');
    std::getline(fields, row.scene, '\t');
    std::getline(fields, row.inputs, '\t');
    std::getline(fields, row.ticks, '\t');
    if (row.file != "file") rows.push_back(row);
  }
  return rows;
}

// Runs the tool in the repository's directory; true if it says 0.
bool run(const std::string& arguments) {
  const std::string command = std::string("cd '") + TICKTRUE_SOURCE_DIR + "' && '" + TICKTRUE_TOOL + "' " + arguments;
  return std::system((command + " > /dev/null 2>&1").c_str()) == 0;
}

// host:NAME:SEED are the frames of a host, anything else is a file.
std::string inputs_of(const GoldenRow& row) {
  const std::string prefix = "host:";
  if (row.inputs == "-") return "";
  if (row.inputs.compare(0, prefix.size(), prefix) != 0) return " --inputs '" + row.inputs + "'";
  const std::size_t colon = row.inputs.find(':', prefix.size());
  return " --host " + row.inputs.substr(prefix.size(), colon - prefix.size()) + " --host-seed " +
         row.inputs.substr(colon + 1);
}

// Every `stride`-th golden, at this many random ticks.
void check_goldens(std::size_t stride, int tick_count) {
  const fs::path place = fs::temp_directory_path() / ("ticktrue_fresh_process_" + std::to_string(stride));
  fs::create_directories(place);
  const std::vector<GoldenRow> rows = golden_rows();
  REQUIRE(rows.size() >= 22);
  engine::Random random(stride);
  for (std::size_t i = 0; i < rows.size(); i += stride) {
    const GoldenRow& row = rows[i];
    CAPTURE(row.file);
    const std::string trace = "'" + (place / row.file).string() + "'";
    std::string recording = "record '" + row.scene + "' --checkpoint-interval 1 --force -o " + trace;
    recording += inputs_of(row);
    if (row.ticks != "-") recording += " --ticks " + row.ticks;
    REQUIRE(run(recording));
    const std::uint64_t end = row.ticks != "-" ? std::stoull(row.ticks) : 120;
    for (int k = 0; k < tick_count; ++k) {
      const std::uint64_t from = random.below(end);
      CAPTURE(from);
      const std::uint64_t to = from + ticks_compared < end ? from + ticks_compared : end;
      CHECK(run("verify " + trace + " --from " + std::to_string(from) + " --to " + std::to_string(to)));
    }
    fs::remove(place / row.file);
  }
  fs::remove_all(place);
}

}  // namespace

TEST_CASE("a state saved by one process runs on with the same bits in another", "[cli][restore][determinism]") {
  check_goldens(9, 2);
}

TEST_CASE("states of every golden scene, at 50 random ticks, run on with the same bits in other processes",
          "[cli][restore][determinism][.slow]") {
  check_goldens(1, 50);
}

}  // namespace ticktrue::test
