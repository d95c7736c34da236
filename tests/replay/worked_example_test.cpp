// docs/trace_format.md says what the code does: its worked example is made and read byte for byte.
// SPDX-License-Identifier: MIT
#include <fstream>
#include <sstream>

#include "base/hash.h"
#include "replay/format/chunk.h"
#include "tests/replay/toy_traces.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

/// The example's state: one table of one row with one column.
class Counter {
 public:
  Counter() {
    Column column;
    column.name = "value";
    column.type = ScalarType::u32;
    column.max = 1000;
    column.min = 0;
    TableSchema table;
    table.name = "counter";
    table.columns = {column};
    table.row_size = 4;
    schema_.tables = {table};
    view_.schema = &schema_;
    view_.tables = {TableRows{reinterpret_cast<const std::uint8_t*>(&value), 1}};
  }
  Counter(const Counter&) = delete;
  Counter& operator=(const Counter&) = delete;
  const StateSchema& schema() const { return schema_; }
  const StateView& view() const { return view_; }
  std::uint32_t value = 0;

 private:
  StateSchema schema_;
  StateView view_;
};

/// Three ticks; the second has inputs and another dt.
Bytes make_example() {
  const TemporaryFolder folder;
  Counter counter;
  replay::TraceSetup setup;
  setup.simulation = "example";
  setup.physics_version = 1;
  setup.title = "count";
  setup.dt = 0.5;
  setup.schema = counter.schema();
  setup.stages = {"add"};
  setup.setup = {0x2a};
  auto writer = replay::TraceWriter::create(folder.file("example.ttr"), setup, {{"os", "any"}}, plain_writer());
  REQUIRE(writer);
  REQUIRE(writer->checkpoint(counter.view(), root_hash(counter.view())));
  for (int tick = 0; tick < 3; ++tick) {
    const Bytes inputs = tick == 1 ? Bytes{0x07, 0x08} : Bytes();
    REQUIRE(writer->begin_tick({tick == 0 ? 0.5 : 0.25, inputs}));
    counter.value += tick == 1 ? 8 : 1;
    REQUIRE(writer->end_tick(root_hash(counter.view()), {}, nullptr));
  }
  REQUIRE(writer->finish(replay::EndReason::complete, "ok"));
  return read_file(folder.file("example.ttr"));
}

std::string document() {
  std::ifstream in(TICKTRUE_SOURCE_DIR "/docs/trace_format.md");
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The bytes of all ```hex blocks: `offset: bytes  comment`, two spaces before the comment.
Bytes bytes_of_document(const std::string& text) {
  Bytes bytes;
  std::istringstream lines(text);
  std::string line;
  bool is_hex = false;
  while (std::getline(lines, line)) {
    if (line == "```hex") {
      is_hex = true;
    } else if (line == "```") {
      is_hex = false;
    } else if (is_hex) {
      const std::size_t colon = line.find(": ");
      REQUIRE(colon != std::string::npos);
      REQUIRE(std::stoul(line.substr(0, colon), nullptr, 16) == bytes.size());
      std::istringstream fields(line.substr(colon + 2, line.find("  ", colon + 2) - colon - 2));
      std::string field;
      while (fields >> field) bytes.push_back(static_cast<std::uint8_t>(std::stoul(field, nullptr, 16)));
    }
  }
  return bytes;
}

}  // namespace

TEST_CASE("the worked example of the format is what the writer writes", "[replay][format][golden]") {
  const Bytes made = make_example();
  const Bytes documented = bytes_of_document(document());
  REQUIRE(made.size() == documented.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    CAPTURE(i);
    REQUIRE(made[i] == documented[i]);
  }
}

TEST_CASE("the worked example of the format is read as described", "[replay][format][golden]") {
  const Bytes bytes = bytes_of_document(document());
  auto reader = replay::TraceReader::open_bytes(bytes, "trace_format.md");
  REQUIRE(reader);
  CHECK(reader->setup().simulation == "example");
  CHECK(reader->setup().title == "count");
  CHECK(reader->setup().setup == Bytes{0x2a});
  CHECK(reader->facts() == replay::BuildFacts{{"os", "any"}});
  const ReadTrace all = read_all(*reader);
  CHECK(all.tail.condition == replay::TraceCondition::complete);
  REQUIRE(all.ticks.size() == 3);
  CHECK(all.ticks[0].dt == 0.5);
  CHECK(all.ticks[1].dt == 0.25);
  CHECK(all.ticks[2].dt == 0.25);
  CHECK(all.ticks[1].inputs == Bytes{0x07, 0x08});
  // The states of the text: 0, 1, 9, 10.
  Counter counter;
  CHECK(all.checkpoints.at(0).root_hash == root_hash(counter.view()));
  for (std::size_t tick = 0; tick < 3; ++tick) {
    counter.value = std::vector<std::uint32_t>{1, 9, 10}[tick];
    CHECK(all.ticks[tick].root_hash == root_hash(counter.view()));
  }
}

TEST_CASE("the root hash is what the format says", "[replay][format][golden]") {
  // Written from the text of "Root hash", over two blocks and a rest.
  ToySimulation simulation(1'000);
  ByteWriter digest;
  Bytes image;
  encode_image(simulation.state(), image);
  const auto tables = split_image(ToySimulation::schema(), image);
  REQUIRE(tables);
  for (std::size_t t = 0; t < tables->size(); ++t) {
    const std::string& name = ToySimulation::schema().tables[t].name;
    digest.u64(hash64(Bytes(name.begin(), name.end())));
    digest.u64((*tables)[t].row_count);
    ByteView rows = (*tables)[t].rows;
    while (!rows.empty()) {
      const std::size_t size = std::min<std::size_t>(rows.size(), 16'384);
      digest.u64(hash64(rows.first(size)));
      rows = rows.subspan(size);
    }
  }
  CHECK(hash64(digest.view()) == root_hash(simulation.state()));
}

TEST_CASE("the constants of the format stand in its document", "[replay][format][golden]") {
  const std::string text = document();
  const auto says = [&](const std::string& part) {
    CAPTURE(part);
    CHECK(text.find(part) != std::string::npos);
  };
  for (const replay::ChunkKindInfo& info : replay::chunk_kinds)
    says("| " + std::to_string(static_cast<int>(info.kind)) + " | " + std::string(info.name) + " |");
  for (const replay::EndReasonInfo& info : replay::end_reasons)
    says(std::to_string(static_cast<int>(info.reason)) + " `" + std::string(info.name) + "`");
  for (const replay::DetailInfo& info : replay::details)
    says(std::to_string(static_cast<int>(info.detail)) + " `" + std::string(info.name) + "`");
  for (std::uint16_t version = replay::format_version_first; version <= replay::format_version; ++version) {
    says("format version " + std::to_string(version));
    says(hex64(replay::chain_start(version)));
  }
}
