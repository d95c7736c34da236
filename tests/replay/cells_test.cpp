// Detail cells in a trace: written, read back, recovered, and refused where it cannot be.
// SPDX-License-Identifier: MIT
#include "base/state/cells.h"

#include <fstream>
#include <sstream>

#include "replay/format/chunk.h"
#include "replay/format/payload.h"
#include "tests/replay/toy_traces.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

replay::TraceSetup cells_toy_setup(std::uint32_t body_count) {
  replay::TraceSetup setup = toy_setup(body_count);
  setup.detail = replay::Detail::cells;
  return setup;
}

/// The cells of each tick of a trace.
std::vector<StateCells> cells_of_ticks(ByteView bytes) {
  auto reader = replay::TraceReader::open_bytes(bytes, "test.ttr");
  REQUIRE(reader);
  std::vector<StateCells> all;
  for (;;) {
    const auto& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) return all;
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) {
      REQUIRE(tick->cells != nullptr);
      all.push_back(*tick->cells);
    }
  }
}

/// The cells of the states that made it.
std::vector<StateCells> cells_of_run(std::uint32_t body_count, std::uint64_t tick_count) {
  ToySimulation simulation(body_count);
  ScriptedInputs source(lively_script);
  CellHasher hasher(ToySimulation::schema());
  std::vector<StateCells> all(tick_count);
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    const auto input = source.next(tick);
    REQUIRE(input);
    REQUIRE(simulation.step(**input, nullptr));
    hasher.hash(simulation.state(), 0, all[tick]);
  }
  return all;
}

}  // namespace

TEST_CASE("cells are stored of every tick and read back", "[replay][cells][equivalence]") {
  const Bytes trace = toy_trace(cells_toy_setup(12), 40);
  CHECK(cells_of_ticks(trace) == cells_of_run(12, 40));
  const ReadTrace all = read_all(trace);
  CHECK(all.tail.condition == replay::TraceCondition::complete);
  // The rest is what detail root stores.
  const ReadTrace root = read_all(toy_trace(toy_setup(12), 40));
  CHECK(all.ticks == root.ticks);
}

TEST_CASE("a trace with cells has format version 2, others stay readable by readers of version 1",
          "[replay][cells][format]") {
  CHECK(toy_trace(cells_toy_setup(3), 2)[8] == 2);
  CHECK(toy_trace(toy_setup(3), 2)[8] == 1);
  CHECK(toy_trace(full_toy_setup(3, 0, 9), 2)[8] == 1);
}

TEST_CASE("recovery keeps the cells of every tick before a cut", "[replay][cells][recover]") {
  const TemporaryFolder folder;
  const Bytes whole = toy_trace(cells_toy_setup(5), 12);
  const std::vector<StateCells> expected = cells_of_run(5, 12);
  for (std::size_t size = 3 * whole.size() / 4; size < whole.size(); size += 13) {
    write_file(folder.file("cut.ttr"), ByteView(whole).first(size));
    const auto recovered = replay::recover_trace(folder.file("cut.ttr"), folder.file("whole.ttr"), true);
    REQUIRE(recovered);
    const std::vector<StateCells> found = cells_of_ticks(read_file(folder.file("whole.ttr")));
    CAPTURE(size);
    CHECK(found.size() == recovered->ticks_written);
    CHECK(std::equal(found.begin(), found.end(), expected.begin()));
  }
}

TEST_CASE("every changed byte of a trace with cells is refused or reported", "[replay][cells][corruption]") {
  const Bytes whole = toy_trace(cells_toy_setup(3), 3);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Bytes changed = whole;
    changed[i] = static_cast<std::uint8_t>(changed[i] ^ 0x10);
    const auto reader = replay::TraceReader::open_bytes(changed, "flip.ttr");
    if (!reader) continue;
    CAPTURE(i);
    CHECK(read_all(changed).tail.condition != replay::TraceCondition::complete);
  }
}

TEST_CASE("a cells record whose counts do not add up is refused", "[replay][cells][corruption]") {
  const StateSchema& schema = ToySimulation::schema();
  ToySimulation toy(4);
  StateCells cells;
  CellHasher(schema).hash(toy.state(), 0, cells);
  ByteWriter out;
  replay::encode_cells(cells, schema, out);
  const Bytes body = out.take();
  REQUIRE(replay::check_cells(schema, body));
  CHECK(replay::decode_cells(schema, body) == cells);
  for (std::size_t size = 0; size < body.size(); ++size)
    CHECK(!replay::check_cells(schema, ByteView(body).first(size)));
  Bytes longer = body;
  longer.push_back(0);
  CHECK(!replay::check_cells(schema, longer));
  ByteWriter huge;
  for (std::size_t t = 0; t < schema.tables.size(); ++t) huge.varint(0);
  huge.varint(partition_cells_max + 1);
  CHECK(!replay::check_cells(schema, huge.view()));
  ByteWriter many;
  many.varint(std::uint64_t{1} << 32);
  CHECK(!replay::check_cells(schema, many.view()));
}

TEST_CASE("detail cells is refused in a file that says format version 1", "[replay][cells][corruption]") {
  ByteWriter payload;
  replay::encode_setup(cells_toy_setup(2), payload);
  CHECK(replay::decode_setup(payload.view(), 2));
  const auto old = replay::decode_setup(payload.view(), 1);
  REQUIRE(!old);
  CHECK(old.error().message.find("detail: found 2, expected 1 or 3 in format version 1") != std::string::npos);
}

TEST_CASE("1,000 bodies take at most 320 bytes a tick, their cells 192", "[replay][cells][size][analytic]") {
  const Bytes short_trace = toy_trace(cells_toy_setup(1'000), 10);
  const Bytes long_trace = toy_trace(cells_toy_setup(1'000), 60);
  std::size_t input_size = 0;
  for (std::uint64_t tick = 10; tick < 60; ++tick) input_size += (*lively_script(tick))->second.size();
  CHECK((long_trace.size() - short_trace.size() - input_size) / 50 <= 320);
  CHECK(cells_of_ticks(short_trace).at(0).cells.size() * 2 == 192);
}

TEST_CASE("the cells of the document are those of its state", "[replay][cells][format][golden]") {
  // The state of docs/trace_format.md, "Cells of a small state": two bodies and a contact between them.
  struct Body {
    std::uint32_t id;
    float x;
  };
  struct Contact {
    std::uint32_t body_a, body_b;
    float force;
  };
  const auto column = [](const char* name, ScalarType type, std::uint16_t offset, std::int16_t target = -1) {
    Column made;
    made.name = name;
    made.type = type;
    made.offset = offset;
    made.target = target;
    return made;
  };
  StateSchema schema;
  schema.tables.push_back({"bodies", {column("id", ScalarType::u32, 0), column("x", ScalarType::f32, 4)}, 8, 1});
  schema.tables.push_back({"contacts",
                           {column("body_a", ScalarType::u32, 0, 0), column("body_b", ScalarType::u32, 4, 0),
                            column("force", ScalarType::f32, 8)},
                           12,
                           2});
  REQUIRE(check_schema(schema));
  const Body bodies[] = {{0, 1.0F}, {7, -2.5F}};
  const Contact contacts[] = {{0, 7, 9.0F}};
  StateView view;
  view.schema = &schema;
  view.tables = {{reinterpret_cast<const std::uint8_t*>(bodies), 2},
                 {reinterpret_cast<const std::uint8_t*>(contacts), 1}};
  StateCells cells;
  CellHasher(schema).hash(view, 0, cells);
  ByteWriter record;
  replay::encode_cells(cells, schema, record);
  std::string hex;
  for (const std::uint8_t byte : record.view()) {
    hex += "0123456789abcdef"[byte >> 4];
    hex += "0123456789abcdef"[byte & 15];
  }
  std::ifstream in(TICKTRUE_SOURCE_DIR "/docs/trace_format.md");
  std::stringstream text;
  text << in.rdbuf();
  const std::string document = text.str();
  const std::string begin = "```cells\n";
  const std::size_t at = document.find(begin);
  REQUIRE(at != std::string::npos);
  std::string documented;
  std::istringstream lines(
      document.substr(at + begin.size(), document.find("```", at + begin.size()) - at - begin.size()));
  for (std::string line; std::getline(lines, line);)
    for (const char c : line.substr(0, line.find("  ")))
      if (c != ' ') documented += c;
  CHECK(documented == hex);
}
