// Three to six recordings of one match: planted faults are named with trace, tick, table, column and row.
// SPDX-License-Identifier: MIT
#include "verifier/compare/many/diff_many.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "base/random.h"
#include "tests/support/catch.h"
#include "tests/support/forging.h"
#include "tests/verifier/toy_variants.h"

namespace ticktrue::test {
namespace {

using nlohmann::json;
using verifier::DiffManyReport;
using verifier::DiffVerdict;
using verifier::InputChange;
using verifier::TraceGroup;

constexpr std::uint32_t body_count = 6;

/// The mistake of one client.
enum class Planted : std::uint8_t { none, value, missing, extra, other, late, dt };
constexpr std::array<Planted, 6> planted_faults{Planted::value, Planted::missing, Planted::extra,
                                                Planted::other, Planted::late,    Planted::dt};

struct PlantedClient {
  Planted fault = Planted::none;
  std::uint64_t tick = 0;
  std::uint64_t delay = 3;  // of a late input, ticks
  std::uint32_t body = 2;   // whose charge a fault of values changes
  std::int32_t change = 1;  // by so much
  std::uint64_t tick_count = 40;
  bool repeats = false;  // the same push in every tick
  replay::TraceSetup setup = full_toy_setup(body_count, 0, 100);
  replay::BuildFacts facts = toy_facts;
};

/// One push each tick, whose value no other tick has. In odd ticks a second one.
Bytes script(std::uint64_t seed, std::uint64_t tick, const PlantedClient& client) {
  const auto push_of = [&](std::uint64_t of, ToyInputs& to) {
    if (client.repeats) of = 0;
    Random random(seed * 1000 + of);
    to.push(static_cast<std::uint32_t>(random.below(body_count)), 1 + random.unit() + static_cast<double>(of));
  };
  const bool is_fault = client.fault != Planted::none && tick == client.tick;
  ToyInputs inputs;
  if (is_fault && client.fault == Planted::other)
    inputs.push(1, -500);
  else if (!is_fault || (client.fault != Planted::missing && client.fault != Planted::late))
    push_of(tick, inputs);
  if (tick % 2 == 1) inputs.push(0, 0.25);
  if (is_fault && client.fault == Planted::extra) inputs.push(3, 777);
  if (client.fault == Planted::late && tick == client.tick + client.delay) push_of(client.tick, inputs);
  return inputs.take();
}

Bytes recorded(std::uint64_t seed, const PlantedClient& client) {
  const TemporaryFolder folder;
  ByteReader in(client.setup.setup);
  ToySimulation toy(in.u32());
  toy.disturb = [&](ToySimulation& self, std::size_t stage) {
    if (client.fault != Planted::value || stage != ToySimulation::move_stage) return;
    if (self.world.tick_count != client.tick + 1) return;
    self.bodies[client.body].charge += client.change;
  };
  ScriptedInputs source([&](std::uint64_t tick) -> Result<std::optional<std::pair<double, Bytes>>> {
    const double dt = client.fault == Planted::dt && tick == client.tick ? 0.03125 : 0.015625;
    return std::optional(std::pair(dt, script(seed, tick, client)));
  });
  replay::RecordOptions options;
  options.tick_count = client.tick_count;
  options.writer = plain_writer();
  REQUIRE(replay::record(toy, source, folder.file("toy.ttr"), client.setup, client.facts, options));
  return read_file(folder.file("toy.ttr"));
}

std::string file_of(std::size_t client) {
  return "client" + std::to_string(client) + ".ttr";
}

/// Compares the traces in the order of `order`.
DiffManyReport diff_ordered(const std::vector<Bytes>& traces, const std::vector<std::size_t>& order,
                            const SimulationInfo* simulation = &toy_info) {
  std::vector<replay::TraceReader> readers;
  readers.reserve(traces.size());
  std::vector<verifier::OpenedTrace> opened;
  for (const std::size_t client : order) {
    auto reader = replay::TraceReader::open_bytes(traces[client], file_of(client));
    if (!reader) {
      opened.push_back({file_of(client), nullptr, reader.error().message});
      continue;
    }
    readers.push_back(std::move(*reader));
    opened.push_back({file_of(client), &readers.back()});
  }
  verifier::DiffOptions options;
  options.simulation = simulation;
  return verifier::diff_many(opened, options);
}

std::vector<std::size_t> in_order(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

DiffManyReport diff_all(const std::vector<Bytes>& traces, const SimulationInfo* simulation = &toy_info) {
  return diff_ordered(traces, in_order(traces.size()), simulation);
}

DiffManyReport diff_clients(std::uint64_t seed, const std::vector<PlantedClient>& clients) {
  std::vector<Bytes> traces;
  for (const PlantedClient& client : clients) traces.push_back(recorded(seed, client));
  return diff_all(traces);
}

replay::TraceSetup setup_with(replay::Detail detail) {
  const bool is_full = detail == replay::Detail::full;
  replay::TraceSetup setup = is_full ? full_toy_setup(body_count, 0, 100) : toy_setup(body_count);
  setup.detail = detail;
  setup.checkpoint_interval = 8;
  return setup;
}

/// A report as JSON in which traces are called by their files, and lists of traces do not depend on their order.
class ByFiles {
 public:
  explicit ByFiles(const DiffManyReport& report) : report_(json::parse(verifier::diff_many_json(report))) {
    for (const json& trace : report_["traces"]) files_.push_back(trace["file"]);
    // Sentences with labels.
    for (const char* name : {"reason", "again", "notes", "contradictions"}) report_.erase(name);
  }
  json take() { return named(report_, ""); }

 private:
  json named(const json& value, const std::string& name) const {
    if (value.is_object()) {
      json object;
      for (const auto& [key, inner] : value.items())
        if (key != "label") object[key] = named(inner, key);
      return object;
    }
    const bool is_trace = name == "traces" || name == "reference" || name == "trace" || name == "groups";
    if (is_trace && value.is_number()) return files_[value.get<std::size_t>()];
    if (!value.is_array()) return value;
    json list = json::array();
    for (const json& inner : value) list.push_back(named(inner, name));
    const bool is_set = is_trace || name == "odd" || name == "others" || name == "values";
    if (is_set) std::sort(list.begin(), list.end());
    return list;
  }

  json report_;
  std::vector<std::string> files_;
};

bool names_lane(const DiffManyReport& report, const std::string& table, const std::string& column, std::uint64_t row) {
  for (const verifier::OddState& odd : report.state->odd)
    for (const verifier::LaneReport& lane : odd.divergence.rows)
      if (lane.table == table && lane.column == column && lane.row == row) return true;
  return false;
}

InputChange change_of(Planted fault) {
  if (fault == Planted::other) return InputChange::other;
  if (fault == Planted::extra) return InputChange::extra;
  if (fault == Planted::dt) return InputChange::dt;
  return InputChange::missing;
}

TEST_CASE("diff of many: the one client with a planted fault is named, with tick and place",
          "[verifier][diff][many][analytic]") {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    Random random(seed);
    std::vector<PlantedClient> clients(3 + random.below(4));
    const std::size_t guilty = random.below(clients.size());
    PlantedClient& client = clients[guilty];
    client.fault = planted_faults[seed % planted_faults.size()];
    client.tick = 1 + random.below(30);
    client.body = static_cast<std::uint32_t>(random.below(body_count));
    CAPTURE(seed, clients.size(), guilty, static_cast<int>(client.fault), client.tick);
    const DiffManyReport report = diff_clients(seed, clients);

    CHECK(report.verdict == DiffVerdict::different);
    CHECK(report.exit_code() == 1);
    REQUIRE(report.blame);
    CHECK(report.blame->traces == TraceGroup{guilty});
    CHECK(report.blame->tick == client.tick);
    REQUIRE(report.state);
    CHECK(report.state->who.odd() == TraceGroup{guilty});
    CHECK(report.state->odd.size() == 1);
    for (std::size_t i = 0; i < clients.size(); ++i) CHECK(report.traces[i].state_from.has_value() == (i == guilty));
    CHECK(report.traces[guilty].state_from == report.state->tick);
    if (client.fault == Planted::value) {
      CHECK(report.blame->by == "state");
      CHECK(!report.inputs);
      CHECK(report.state->tick == client.tick);
      CHECK(names_lane(report, "bodies", "charge", client.body));
      CHECK(report.state->odd[0].divergence.stage == "move");
      continue;
    }
    CHECK(report.blame->by == "inputs");
    REQUIRE(report.inputs);
    CHECK(report.inputs->tick == client.tick);
    CHECK(report.traces[guilty].inputs_from == client.tick);
    REQUIRE(report.inputs->odd.size() == 1);
    const verifier::OddInputs& odd = report.inputs->odd[0];
    CHECK(odd.trace == guilty);
    CHECK(odd.change == change_of(client.fault));
    CHECK(odd.later.has_value() == (client.fault == Planted::late));
    if (client.fault == Planted::late) CHECK(odd.later == client.tick + client.delay);
    CHECK(!odd.before);
  }
}

TEST_CASE("diff of many: another order of the traces changes labels only", "[verifier][diff][many][equivalence]") {
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    Random random(seed + 100);
    std::vector<PlantedClient> clients(3 + random.below(4));
    std::vector<Bytes> traces;
    for (PlantedClient& client : clients) {
      // Half of them go wrong, some in the same tick: also where no majority is left.
      if (random.below(2) == 0) client.fault = planted_faults[random.below(planted_faults.size())];
      client.tick = 10 + random.below(3);
      client.change = 1 + static_cast<std::int32_t>(random.below(3));
      client.tick_count = 30 + random.below(2) * 10;
      client.setup = setup_with(random.below(3) == 0 ? replay::Detail::cells : replay::Detail::full);
      if (seed % 4 == 0) client.setup.physics_version = 1 + static_cast<std::uint32_t>(random.below(2));
      traces.push_back(recorded(seed, client));
    }
    std::vector<std::size_t> order = in_order(clients.size());
    const DiffManyReport first = diff_ordered(traces, order);
    const json expected = ByFiles(first).take();
    for (int shuffle = 0; shuffle < 4; ++shuffle) {
      for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
      CAPTURE(seed, order);
      const DiffManyReport other = diff_ordered(traces, order);
      CHECK(ByFiles(other).take() == expected);
      CHECK(other.notes.size() == first.notes.size());
      CHECK(other.again.size() == first.again.size());
    }
  }
}

TEST_CASE("diff of many: equal sessions are equal, whatever their detail", "[verifier][diff][many][equivalence]") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(seed + 200);
    std::vector<PlantedClient> clients(3 + random.below(4));
    for (PlantedClient& client : clients) {
      client.setup = setup_with(replay::details[random.below(replay::details.size())].detail);
      client.setup.checkpoint_interval = 1 + static_cast<std::uint32_t>(random.below(12));
    }
    CAPTURE(seed, clients.size());
    const DiffManyReport report = diff_clients(seed, clients);
    CHECK(report.verdict == DiffVerdict::equal);
    CHECK(report.exit_code() == 0);
    CHECK(report.ticks_compared == 40);
    CHECK(report.contradictions.empty());
    CHECK(!report.blame);
  }
}

TEST_CASE("diff of many: an input that all have again is not taken for a late one",
          "[verifier][diff][many][analytic]") {
  std::vector<PlantedClient> clients(3);
  for (PlantedClient& client : clients) client.repeats = true;
  clients[1].fault = Planted::missing;
  clients[1].tick = 12;
  clients[2].fault = Planted::extra;
  clients[2].tick = 15;
  const DiffManyReport report = diff_clients(3, clients);
  REQUIRE(report.inputs);
  REQUIRE(report.inputs->odd.size() == 1);
  CHECK(report.inputs->odd[0].trace == 1);
  CHECK(report.inputs->odd[0].change == InputChange::missing);
  CHECK(report.traces[2].inputs_from == 15);
  CHECK(!report.inputs->odd[0].later);
}

TEST_CASE("diff of many: two clients with two faults are both named, each from its tick",
          "[verifier][diff][many][analytic]") {
  std::vector<PlantedClient> clients(5);
  clients[1] = {Planted::late, 9};
  clients[4] = {Planted::value, 20};
  const DiffManyReport report = diff_clients(7, clients);
  REQUIRE(report.blame);
  CHECK(report.blame->traces == TraceGroup{1});
  CHECK(report.traces[1].inputs_from == 9);
  CHECK(report.traces[1].state_from == 9);
  CHECK(report.traces[4].state_from == 20);
  CHECK(!report.traces[4].inputs_from);
}

TEST_CASE("diff of many: without a majority nobody is blamed, and every group has its values",
          "[verifier][diff][many][analytic]") {
  std::vector<PlantedClient> clients(4);
  clients[2] = {Planted::value, 12, 3, 4, 5};
  clients[3] = {Planted::value, 12, 3, 4, 5};
  const DiffManyReport two = diff_clients(3, clients);
  CHECK(!two.blame);
  REQUIRE(two.state);
  CHECK(two.state->who.groups == std::vector<TraceGroup>{{0, 1}, {2, 3}});
  CHECK(contains(verifier::diff_many_text(two), "who     no majority: a, b; c, d\n"));
  CHECK(names_lane(two, "bodies", "charge", 4));

  clients.resize(3);
  clients[1] = {Planted::value, 12, 3, 4, 1};
  const DiffManyReport three = diff_clients(3, clients);
  CHECK(!three.blame);
  REQUIRE(three.state);
  CHECK(three.state->odd.size() == 2);
}

TEST_CASE("diff of many: what one member of a group stores stands for the group", "[verifier][diff][many][analytic]") {
  std::vector<PlantedClient> clients(4);
  for (PlantedClient& client : clients) client.setup = setup_with(replay::Detail::root);
  clients[2].setup = setup_with(replay::Detail::full);
  clients[3] = {Planted::value, 12, 3, 4, 1};
  DiffManyReport report = diff_clients(3, clients);
  REQUIRE(report.state);
  CHECK(names_lane(report, "bodies", "charge", 4));

  // Cells name columns and rows, and hashes the tick alone.
  for (PlantedClient& client : clients) client.setup = setup_with(replay::Detail::cells);
  clients[3].tick = 13;
  report = diff_clients(3, clients);
  REQUIRE(report.state);
  CHECK(report.state->odd[0].divergence.from_cells);
  CHECK(report.state->odd[0].divergence.tables[0].columns == std::vector<std::string>{"charge"});
  REQUIRE(report.state->odd[0].divergence.candidates.size() == 1);
  CHECK(report.state->odd[0].divergence.candidates[0].name == "toy_4");
  for (PlantedClient& client : clients) client.setup = setup_with(replay::Detail::root);
  report = diff_clients(3, clients);
  REQUIRE(report.state);
  CHECK(report.state->odd[0].divergence.tables.empty());
  CHECK(report.again.size() == 3);
}

TEST_CASE("diff of many: setups and builds that differ are told with who has what",
          "[verifier][diff][many][analytic]") {
  std::vector<PlantedClient> clients(3);
  clients[1].setup.title = "another";
  for (PlantedClient& client : clients) client.facts = {{"caller.fused", "no"}, {"caller.compiler", "gcc"}};
  clients[2].facts[0].second = "yes";
  DiffManyReport report = diff_clients(3, clients);
  CHECK(report.verdict == DiffVerdict::different);
  CHECK(report.reason == "states equal; the setups differ");
  REQUIRE(report.setup.size() == 1);
  CHECK(report.setup[0].what == "title");
  CHECK(report.setup[0].values[0].traces == TraceGroup{0, 2});
  CHECK(report.setup[0].values[1].traces == TraceGroup{1});
  REQUIRE(report.build.size() == 1);
  CHECK(report.build[0].changes_bits);
  CHECK(contains(verifier::diff_many_text(report), "differs fused: a, b no.  c yes (changes bits)\n"));

  // The build explains a difference of its own state only, and only if no trace of the majority has it, too.
  clients[1].setup.title = clients[0].setup.title;
  clients[2].fault = Planted::value;
  clients[2].tick = 5;
  report = diff_clients(3, clients);
  REQUIRE(report.state);
  CHECK(report.state->odd[0].why == std::vector{verifier::Cause::contraction});
  clients[1].facts[0].second = "yes";
  report = diff_clients(3, clients);
  REQUIRE(report.state);
  CHECK(std::count(report.state->odd[0].why.begin(), report.state->odd[0].why.end(), verifier::Cause::contraction) ==
        0);
}

TEST_CASE("diff of many: another setup begins in another state, before any input", "[verifier][diff][many][analytic]") {
  std::vector<PlantedClient> clients(3);
  clients[0].setup.setup = ToySimulation::setup(body_count + 1);
  const DiffManyReport report = diff_clients(3, clients);
  REQUIRE(report.setup.size() == 1);
  CHECK(report.setup[0].what == "setup");
  REQUIRE(report.state);
  CHECK(report.state->is_start);
  REQUIRE(report.blame);
  CHECK(report.blame->traces == TraceGroup{0});
  CHECK(report.state->odd[0].divergence.stage == "setup");
  CHECK(contains(verifier::diff_many_text(report), "up to there, and another setup\n"));
  CHECK(report.state->odd[0].why.empty());
}

TEST_CASE("diff of many: a trace of other physics is left out, and the others are compared",
          "[verifier][diff][many][analytic]") {
  std::vector<PlantedClient> clients(4);
  clients[1].setup.physics_version = 2;
  DiffManyReport report = diff_clients(3, clients);
  CHECK(report.verdict == DiffVerdict::not_comparable);
  CHECK(report.exit_code() == 5);
  CHECK(report.ticks_compared == 40);
  CHECK(report.traces[1].side.ticks == 40);
  CHECK(!report.traces[1].is_compared);
  clients[3] = {Planted::value, 12};
  report = diff_clients(3, clients);
  CHECK(report.exit_code() == 1);
  REQUIRE(report.blame);
  CHECK(report.blame->traces == TraceGroup{3});
}

TEST_CASE("diff of many: of two halves that cannot be compared the same one is compared in every order",
          "[verifier][diff][many][equivalence]") {
  std::vector<Bytes> traces;
  for (std::uint32_t i = 0; i < 4; ++i) {
    PlantedClient client;
    client.setup.physics_version = 1 + i % 2;
    traces.push_back(recorded(3, client));
  }
  for (const std::vector<std::size_t>& order :
       {std::vector<std::size_t>{0, 1, 2, 3}, std::vector<std::size_t>{1, 0, 3, 2}}) {
    const DiffManyReport report = diff_ordered(traces, order);
    CHECK(report.verdict == DiffVerdict::not_comparable);
    for (std::size_t i = 0; i < order.size(); ++i) CHECK(report.traces[i].is_compared == (order[i] % 2 == 0));
  }
}

TEST_CASE("diff of many: lengths, cuts and damage are told apart, and hide no difference",
          "[verifier][diff][many][corruption]") {
  const PlantedClient whole;
  PlantedClient shorter;
  shorter.tick_count = 25;
  const Bytes a = recorded(3, whole), b = recorded(3, shorter), odd = recorded(3, {Planted::value, 30});
  DiffManyReport report = diff_all({a, b, a});
  CHECK(report.verdict == DiffVerdict::different);
  CHECK(contains(report.reason, "lengths: b ended first"));
  CHECK(report.ticks_compared == 40);

  const Bytes cut(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(a.size() * 3 / 4));
  report = diff_all({a, a, cut});
  CHECK(report.exit_code() == 3);
  CHECK(report.exit_code(true) == 0);
  CHECK(report.ticks_compared == 40);
  Bytes damaged = a;
  damaged[a.size() / 2] ^= 1;
  report = diff_all({a, damaged, a});
  CHECK(report.exit_code() == 4);

  // A file of which nothing can be read, and one that is damaged: the fault of the fifth is named all the same.
  Bytes no_trace = a;
  no_trace[0] ^= 1;
  report = diff_all({no_trace, a, damaged, a, odd});
  CHECK(report.exit_code() == 1);
  CHECK(!report.traces[0].error.empty());
  CHECK(contains(verifier::diff_many_text(report), "client0.ttr  not opened: "));
  CHECK(contains(verifier::diff_many_text(report), "end     c "));
  REQUIRE(report.blame);
  CHECK(report.blame->traces == TraceGroup{4});
  CHECK(report.blame->tick == 30);
}

TEST_CASE("diff of many: a trace whose recorder was stopped ends early, and does not differ",
          "[verifier][diff][many][equivalence]") {
  const Bytes a = recorded(3, {});
  const TemporaryFolder folder;
  write_file(folder.file("cut.ttr"), ByteView(a).first(a.size() * 3 / 4));
  REQUIRE(replay::recover_trace(folder.file("cut.ttr"), folder.file("saved.ttr"), false));
  const DiffManyReport report = diff_all({a, read_file(folder.file("saved.ttr")), a});
  CHECK(report.verdict == DiffVerdict::incomplete);
  CHECK(contains(report.reason, "b ended early"));
  CHECK(report.ticks_compared == 40);
}

TEST_CASE("diff of many: a forged record is told with its trace, and the fault of another one is named",
          "[verifier][diff][many][corruption]") {
  const TemporaryFolder folder;
  PlantedClient plain;
  plain.setup.checkpoint_interval = 8;
  const Bytes a = recorded(3, plain);
  PlantedClient guilty = plain;
  guilty.fault = Planted::value;
  guilty.tick = 30;
  const Bytes odd = recorded(3, guilty);
  write_file(folder.file("a.ttr"), a);
  Forgery forgery;
  SECTION("a checkpoint is another state") {
    forgery.checkpoint = [](verifier::StoredCheckpoint& checkpoint) {
      if (checkpoint.tick == 16) checkpoint.image[checkpoint.image.size() - 5] ^= 1;
    };
  }
  SECTION("a state that is stored is another one") {
    forgery.tick = [](verifier::StoredTick& tick) {
      if (tick.tick == 11) tick.image->at(tick.image->size() - 5) ^= 1;
    };
  }
  SECTION("the state of the tick that differs is another one") {
    forgery.tick = [](verifier::StoredTick& tick) {
      if (tick.tick == 30) tick.image->at(tick.image->size() - 5) ^= 1;
    };
  }
  forge_trace(folder.file("a.ttr"), folder.file("forged.ttr"), forgery);
  const DiffManyReport report = diff_all({a, read_file(folder.file("forged.ttr")), a, odd});
  REQUIRE(report.contradictions.size() == 1);
  CHECK(contains(report.contradictions[0], " b "));
  REQUIRE(report.blame);
  CHECK(report.blame->traces == TraceGroup{3});
  CHECK(report.state->tick == 30);
  CHECK(names_lane(report, "bodies", "charge", 2));
  CHECK(report.state->odd[0].divergence.lane_count == 1);
}

TEST_CASE("diff of many: inputs of a simulation that prints none are compared as bytes",
          "[verifier][diff][many][analytic]") {
  std::vector<Bytes> traces(3, recorded(3, {}));
  traces[1] = recorded(3, {Planted::late, 12});
  const DiffManyReport report = diff_all(traces, nullptr);
  REQUIRE(report.inputs);
  CHECK(report.inputs->tick == 12);
  CHECK(report.inputs->odd[0].trace == 1);
  CHECK(report.inputs->odd[0].change == InputChange::missing);
  CHECK(contains(verifier::diff_many_text(report), "\n  b       none\n"));
  CHECK(report.again.empty());
}

/// The part of a trace of full detail that begins with `first` ticks done, as a black box leaves it.
Bytes late_part(ByteView trace, std::uint64_t first) {
  replay::TraceReader reader = open_trace(trace);
  const ReadTrace all = read_all(reader);
  replay::TraceSetup setup = reader.setup();
  setup.features = static_cast<std::uint32_t>(replay::Feature::tail);
  replay::WriterOptions options = plain_writer();
  options.allow_third = true;
  const TemporaryFolder folder;
  auto writer = replay::TraceWriter::create(folder.file("late.ttr"), setup, toy_facts, options);
  REQUIRE(writer);
  writer->begin_at(first, 0.015625 * static_cast<double>(first));
  REQUIRE(writer->checkpoint_encoded(*all.ticks[first - 1].image, all.ticks[first - 1].root_hash));
  for (std::uint64_t tick = first; tick < all.ticks.size(); ++tick) {
    const ReadTick& one = all.ticks[tick];
    REQUIRE(writer->begin_tick({one.dt, one.inputs}));
    REQUIRE(writer->end_tick_encoded(one.root_hash, one.stage_hashes, ByteView(*one.image)));
  }
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  return read_file(folder.file("late.ttr"));
}

TEST_CASE("diff of many: traces that begin late join the others", "[verifier][diff][many][equivalence]") {
  const Bytes whole = recorded(3, {});
  const Bytes late = late_part(whole, 12);
  DiffManyReport report = diff_all({late_part(whole, 20), whole, late});
  CHECK(report.verdict == DiffVerdict::equal);
  CHECK(report.contradictions.empty());
  CHECK(report.ticks_compared == 28);
  CHECK(report.traces[2].first_tick == 12);

  report = diff_all({late, whole, late_part(recorded(3, {Planted::value, 25}), 12)});
  REQUIRE(report.blame);
  CHECK(report.blame->traces == TraceGroup{2});
  CHECK(report.blame->tick == 25);
  CHECK(report.state->odd[0].divergence.time_s == 25 * 0.015625);

  // The client had diverged before its trace begins.
  report = diff_all({whole, late_part(recorded(3, {Planted::value, 5}), 12), whole});
  REQUIRE(report.blame);
  CHECK(report.blame->traces == TraceGroup{1});
  CHECK(report.blame->tick == 12);
  CHECK(report.contradictions.empty());
}

TEST_CASE("diff of many: traces are read side by side, not one after the other",
          "[verifier][diff][many][equivalence]") {
  PlantedClient client;
  client.tick_count = 4000;
  client.setup = toy_setup(body_count);
  client.setup.checkpoint_interval = 100;
  const Bytes trace = recorded(3, client);
  std::vector<replay::TraceReader> readers;
  for (int i = 0; i < 4; ++i) {
    auto reader = replay::TraceReader::open_bytes(trace, file_of(static_cast<std::size_t>(i)));
    REQUIRE(reader);
    readers.push_back(std::move(*reader));
  }
  std::vector<verifier::OpenedTrace> opened;
  for (replay::TraceReader& reader : readers) opened.push_back({reader.name(), &reader});
  verifier::DiffOptions options;
  std::uint64_t asked = 0;
  options.progress = [&](std::uint64_t ticks_done) {
    if (ticks_done != 1000 && ticks_done != 3000) return;
    ++asked;
    for (const replay::TraceReader& reader : readers) {
      CHECK(reader.offset() == readers[0].offset());
      CHECK(reader.offset() * 4000 < trace.size() * (ticks_done + 600));
    }
  };
  CHECK(verifier::diff_many(opened, options).verdict == DiffVerdict::equal);
  CHECK(asked == 2);
}

TEST_CASE("diff of many: text and JSON name traces, groups and values", "[verifier][diff][many][analytic]") {
  std::vector<PlantedClient> clients(3);
  clients[2] = {Planted::late, 12, 2};
  const DiffManyReport report = diff_clients(3, clients);
  const std::string text = verifier::diff_many_text(report);
  CHECK(contains(text, "different  3 traces  40 ticks compared\n"));
  CHECK(contains(text, "who     c (client2.ttr): other inputs than the majority from tick 12 on\n"));
  CHECK(contains(text, "  inputs  differ first at tick 12: a, b agree; c is the odd one out\n"));
  CHECK(contains(text, "  a, b    {\"tick\":12,\"type\":\"push\""));
  CHECK(contains(text, "  c       none\n"));
  CHECK(contains(text, "c: an input is missing; c has what the majority has here in tick 14, 2 ticks later\n"));
  const json object = json::parse(verifier::diff_many_json(report));
  CHECK(object["schema"] == "ticktrue.diff_many/2");
  CHECK(object["blame"] == json{{"traces", {2}}, {"by", "inputs"}, {"tick", 12}});
  CHECK(object["inputs"]["odd"][0]["change"] == "missing");
  CHECK(object["inputs"]["odd"][0]["later"] == 14);
  CHECK(object["state"]["others"][0]["traces"] == json{2});
  CHECK(object["traces"][2]["state_from"] == 12);
}

}  // namespace
}  // namespace ticktrue::test
