// What is written is read back, whatever the detail, codec, size and interval.
// SPDX-License-Identifier: MIT
#include "base/hash.h"
#include "replay/format/chunk.h"
#include "replay/format/payload.h"
#include "tests/replay/toy_traces.h"

using namespace ticktrue;
using namespace ticktrue::test;
using replay::TraceCondition;
using replay::TraceReader;

TEST_CASE("a recording is read back tick for tick", "[replay][round_trip][equivalence]") {
  replay::TraceSetup setup = full_toy_setup(5, 4, 11);
  setup.checkpoint_interval = 6;
  const bool compress = GENERATE(false, true);
  CAPTURE(compress);
  replay::WriterOptions writer = plain_writer();
  writer.compress = compress;
  const Bytes bytes = toy_trace(setup, 20, writer);
  auto reader = TraceReader::open_bytes(bytes, "test.ttr");
  REQUIRE(reader);
  CHECK(reader->setup().simulation == setup.simulation);
  CHECK(reader->setup().physics_version == setup.physics_version);
  CHECK(reader->setup().title == setup.title);
  CHECK(reader->setup().dt == setup.dt);
  CHECK(reader->setup().detail == setup.detail);
  CHECK(reader->setup().full_first == 4);
  CHECK(reader->setup().full_last == 11);
  CHECK(reader->setup().checkpoint_interval == 6);
  CHECK(reader->setup().schema == setup.schema);
  CHECK(reader->setup().stages == setup.stages);
  CHECK(reader->setup().setup == setup.setup);
  CHECK(reader->facts() == toy_facts);
  CHECK(reader->is_compressed() == (compress && replay::has_codec(replay::Codec::zstd)));
  CHECK(reader->size() == bytes.size());
  CHECK(reader->tick_count_hint() == 20U);

  const ReadTrace all = read_all(*reader);
  CHECK(reader->offset() == bytes.size());
  CHECK(all.tail.condition == TraceCondition::complete);
  CHECK(all.tail.message.empty());
  CHECK(all.tail.ticks_intact == 20);
  CHECK_FALSE(all.tail.has_pending_inputs);
  REQUIRE(all.tail.end);
  CHECK(all.tail.end->reason == replay::EndReason::complete);
  CHECK(all.tail.end->tick_count == 20);
  REQUIRE(all.ticks.size() == 20);
  REQUIRE(all.checkpoints.size() == 4);

  ToySimulation again(5);
  struct Stages : StageObserver {
    void after_stage(std::size_t, const StateView& state) override { hashes.push_back(root_hash(state)); }
    std::vector<std::uint64_t> hashes;
  };
  std::size_t checkpoint = 0;
  Bytes image;
  for (std::uint64_t tick = 0; tick < 20; ++tick) {
    CAPTURE(tick);
    if (tick % 6 == 0) {
      encode_image(again.state(), image);
      CHECK(all.checkpoints[checkpoint] == ReadCheckpoint{tick, root_hash(again.state()), image});
      ++checkpoint;
    }
    const ReadTick& got = all.ticks[tick];
    const auto script = lively_script(tick);
    const auto& [dt, inputs] = **script;
    CHECK(got.tick == tick);
    CHECK(got.dt == dt);
    CHECK(got.inputs == inputs);
    Stages stages;
    REQUIRE(again.step({dt, inputs}, &stages));
    CHECK(got.root_hash == root_hash(again.state()));
    const bool is_full = tick >= 4 && tick <= 11;
    CHECK(got.stage_hashes == (is_full ? stages.hashes : std::vector<std::uint64_t>()));
    REQUIRE(got.image.has_value() == is_full);
    encode_image(again.state(), image);
    if (is_full) CHECK(*got.image == image);
  }
}

TEST_CASE("a reader can begin again and gives the same", "[replay][round_trip][equivalence]") {
  replay::TraceSetup setup = toy_setup(3);
  setup.checkpoint_interval = 4;
  const Bytes bytes = toy_trace(setup, 10);
  auto reader = TraceReader::open_bytes(bytes, "test.ttr");
  REQUIRE(reader);
  const ReadTrace first = read_all(*reader);
  reader->rewind();
  const ReadTrace second = read_all(*reader);
  CHECK(first.ticks == second.ticks);
  CHECK(first.checkpoints == second.checkpoints);
  CHECK(second.tail.condition == TraceCondition::complete);
}

TEST_CASE("ticks go over many chunks and images over many parts", "[replay][round_trip][equivalence]") {
  // 60,000 bodies of 40 bytes: an image of more than two parts. 3,000 ticks of two bodies: three chunks.
  replay::TraceSetup large = full_toy_setup(60'000, 1, 1);
  const bool compress = GENERATE(false, true);
  replay::WriterOptions writer = plain_writer();
  writer.compress = compress;
  const TemporaryFolder folder;
  {
    auto created = replay::TraceWriter::create(folder.file("large.ttr"), large, toy_facts, writer);
    REQUIRE(created);
    const ToySimulation simulation(60'000);
    const std::uint64_t hash = root_hash(simulation.state());
    REQUIRE(created->checkpoint(simulation.state(), hash));
    for (int tick = 0; tick < 3; ++tick) {
      REQUIRE(created->begin_tick({large.dt, {}}));
      const std::vector<std::uint64_t> stages(3, hash);
      REQUIRE(created->end_tick(hash, stages, &simulation.state()));
    }
    REQUIRE(created->finish(replay::EndReason::complete, ""));
    const Bytes bytes = read_file(folder.file("large.ttr"));
    const ReadTrace all = read_all(bytes);
    CHECK(all.tail.condition == TraceCondition::complete);
    Bytes image;
    encode_image(simulation.state(), image);
    REQUIRE(image.size() > 2 * replay::image_part_size);
    REQUIRE(all.checkpoints.size() == 1);
    CHECK((all.checkpoints[0].image == image));
    REQUIRE(all.ticks.size() == 3);
    CHECK_FALSE(all.ticks[0].image);
    REQUIRE(all.ticks[1].image);
    CHECK((*all.ticks[1].image == image));
    CHECK_FALSE(all.ticks[2].image);
  }
  const Bytes bytes = toy_trace(toy_setup(2), 3'000, writer);
  const ReadTrace all = read_all(bytes);
  CHECK(all.tail.condition == TraceCondition::complete);
  REQUIRE(all.ticks.size() == 3'000);
  for (std::uint64_t tick = 0; tick < 3'000; ++tick) REQUIRE(all.ticks[tick].dt == (**lively_script(tick)).first);
}

TEST_CASE("large inputs are kept, larger ones refused before anything is written",
          "[replay][round_trip][equivalence]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("inputs.ttr");
  auto writer = replay::TraceWriter::create(path, toy_setup(1), {}, plain_writer());
  REQUIRE(writer);
  const ToySimulation simulation(1);
  REQUIRE(writer->checkpoint(simulation.state(), 1));
  Bytes inputs(replay::input_size_max);
  for (std::size_t i = 0; i < inputs.size(); ++i) inputs[i] = static_cast<std::uint8_t>(i * 7);
  REQUIRE(writer->begin_tick({0.5, inputs}));
  REQUIRE(writer->end_tick(2, {}, nullptr));
  const std::uint64_t size = writer->size();
  const Status refused = writer->begin_tick({0.5, Bytes(replay::input_size_max + 1)});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::limit);
  CHECK(refused.error().message.find("tick 1: bytes of inputs: found 8388609, expected at most 8388608") !=
        std::string::npos);
  CHECK(writer->size() == size);
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  const ReadTrace all = read_all(read_file(path));
  CHECK(all.tail.condition == TraceCondition::complete);
  REQUIRE(all.ticks.size() == 1);
  CHECK((all.ticks[0].inputs == inputs));
}

TEST_CASE("seeking by the index and by scanning find the same checkpoint", "[replay][seek][equivalence]") {
  replay::TraceSetup setup = full_toy_setup(30'000, 9, 10);  // images of two parts
  setup.checkpoint_interval = 3;
  const Bytes whole = toy_trace(setup, 14);
  const auto places = chunk_places(whole);
  Bytes no_index = whole;
  no_index.resize(places[places.size() - 2].offset);
  Bytes bad_index = whole;
  bad_index[places[places.size() - 2].offset + replay::chunk_header_size + 9] ^= 1;
  Bytes bad_footer = whole;
  bad_footer.back() ^= 1;
  auto expected = TraceReader::open_bytes(whole, "whole.ttr");
  REQUIRE(expected);
  CHECK(expected->tick_count_hint() == 14U);
  const ReadTrace all = read_all(*expected);
  for (const Bytes* bytes : std::initializer_list<const Bytes*>{&whole, &no_index, &bad_index, &bad_footer}) {
    auto reader = TraceReader::open_bytes(*bytes, "other.ttr");
    REQUIRE(reader);
    if (bytes == &no_index || bytes == &bad_footer) CHECK_FALSE(reader->tick_count_hint());
    for (std::uint64_t tick : {0, 1, 2, 3, 5, 8, 9, 11, 12, 13, 14, 1000}) {
      CAPTURE(tick);
      REQUIRE(reader->seek(tick));
      const ReadTrace part = read_all(*reader);
      const std::uint64_t first = std::min<std::uint64_t>(tick / 3 * 3, 12);
      REQUIRE(part.checkpoints.size() == (12 - first) / 3 + 1);
      CHECK(part.checkpoints[0].tick == first);
      CHECK((part.checkpoints[0].image == all.checkpoints[first / 3].image));
      REQUIRE(part.ticks.size() == 14 - first);
      CHECK((part.ticks[0] == all.ticks[first]));
      CHECK((part.ticks.back() == all.ticks.back()));
      CHECK((part.tail.condition == TraceCondition::complete) == (bytes == &whole));
    }
  }
}

TEST_CASE("a seek does not pass a cut or damage, and reading can begin anew", "[replay][seek][corruption]") {
  replay::TraceSetup setup = toy_setup(3);
  setup.checkpoint_interval = 5;
  Bytes bytes = toy_trace(setup, 12);
  const auto places = chunk_places(bytes);
  bytes.resize(places[2].offset + 50);  // inside the checkpoint at tick 0
  auto reader = TraceReader::open_bytes(bytes, "cut.ttr");
  REQUIRE(reader);
  CHECK_FALSE(reader->seek(7));
  const ReadTrace all = read_all(*reader);
  CHECK(all.tail.condition == TraceCondition::truncated);
  CHECK(all.tail.ticks_intact == 0);
}

TEST_CASE("the index stays bounded and is thinned evenly", "[replay][seek][analytic]") {
  replay::CheckpointIndex index;
  for (std::uint64_t i = 0; i < 300'000; ++i) index.add({i, 100 * i});
  CHECK(index.stride == 8);
  CHECK(index.entries.size() == 300'000 / 8);
  for (std::size_t i = 0; i < index.entries.size(); ++i) REQUIRE(index.entries[i].tick == 8 * i);
}

TEST_CASE("seeking between the entries of a thinned index finds the nearest checkpoint",
          "[replay][seek][equivalence]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("many.ttr");
  replay::TraceSetup setup = toy_setup(0);
  setup.checkpoint_interval = 1;
  auto writer = replay::TraceWriter::create(path, setup, {}, plain_writer());
  REQUIRE(writer);
  const ToySimulation simulation(0);
  const std::uint64_t tick_count = replay::index_entry_count_max + 1'000;
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    REQUIRE(writer->wants_checkpoint());
    REQUIRE(writer->checkpoint(simulation.state(), tick));
    REQUIRE(writer->begin_tick({setup.dt, {}}));
    REQUIRE(writer->end_tick(tick, {}, nullptr));
  }
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  auto reader = TraceReader::open(path);
  REQUIRE(reader);
  for (const std::uint64_t tick : {std::uint64_t{0}, std::uint64_t{40'001}, std::uint64_t{40'002}, tick_count - 1}) {
    REQUIRE(reader->seek(tick));
    const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&reader->next());
    REQUIRE(checkpoint);
    CHECK(checkpoint->tick == tick);
    CHECK(checkpoint->root_hash == tick);
  }
  reader->rewind();
  std::uint64_t tick_seen = 0;
  while (!std::holds_alternative<std::monostate>(reader->next())) ++tick_seen;
  CHECK(tick_seen == 2 * tick_count);
  CHECK(reader->tail().condition == TraceCondition::complete);
}

TEST_CASE("a tick at detail root takes at most 12 bytes beside its inputs", "[replay][size][analytic]") {
  replay::TraceSetup setup = toy_setup(2);
  setup.checkpoint_interval = 600;
  const TemporaryFolder folder;
  const std::string path = folder.file("size.ttr");
  auto writer = replay::TraceWriter::create(path, setup, toy_facts, plain_writer());
  REQUIRE(writer);
  const ToySimulation simulation(2);
  std::uint64_t checkpoint_size = 0;
  const std::uint64_t size_before = writer->size();
  for (std::uint64_t tick = 0; tick < 6'000; ++tick) {
    if (writer->wants_checkpoint()) {
      const std::uint64_t before = writer->size();
      REQUIRE(writer->checkpoint(simulation.state(), tick));
      checkpoint_size += writer->size() - before;
    }
    REQUIRE(writer->begin_tick({setup.dt, {}}));
    REQUIRE(writer->end_tick(tick, {}, nullptr));
  }
  const double size_per_tick = static_cast<double>(writer->size() - size_before - checkpoint_size) / 6'000;
  CHECK(size_per_tick <= 11.2);
}

TEST_CASE("the same recording has the same content whatever the build facts", "[replay][chain][determinism]") {
  replay::TraceSetup setup = full_toy_setup(4, 2, 5);
  setup.checkpoint_interval = 4;
  const Bytes one = toy_trace(setup, 12);
  CHECK(one == toy_trace(setup, 12));
  const Bytes other = toy_trace(setup, 12, plain_writer(), {{"compiler", "clang, with a longer name"}});
  replay::WriterOptions compressing = plain_writer();
  compressing.compress = true;
  const Bytes packed = toy_trace(setup, 12, compressing);
  const auto places = chunk_places(one);
  for (const Bytes* bytes : std::initializer_list<const Bytes*>{&other, &packed}) {
    if (bytes == &other || replay::has_codec(replay::Codec::zstd)) CHECK(one.size() != bytes->size());
    const auto other_places = chunk_places(*bytes);
    REQUIRE(places.size() == other_places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      CAPTURE(i);
      // Chain value before each chunk: bytes 24..31 of its header.
      const auto chain = [](const Bytes& trace, const ChunkPlace& place) {
        return ByteReader(ByteView(trace).subspan(place.offset + 24, 8)).u64();
      };
      CHECK(chain(one, places[i]) == chain(*bytes, other_places[i]));
    }
  }
  // All bytes except build facts, index and footer are the same.
  const auto other_places = chunk_places(other);
  for (std::size_t i = 0; i + 2 < places.size(); ++i) {
    if (i == 1) continue;
    const auto cut = [&](const Bytes& trace, const ChunkPlace& place) {
      return Bytes(trace.begin() + static_cast<std::ptrdiff_t>(place.offset),
                   trace.begin() + static_cast<std::ptrdiff_t>(place.offset + place.size));
    };
    CHECK(cut(one, places[i]) == cut(other, other_places[i]));
  }
}

TEST_CASE("private chunks and records are skipped but bound into the chain", "[replay][private][equivalence]") {
  // Writes by hand a trace that the writer never writes.
  const Bytes whole = toy_trace(toy_setup(1), 1);
  const auto places = chunk_places(whole);
  ByteWriter out;
  out.bytes(ByteView(whole).first(places[3].offset));  // setup, facts, checkpoint
  const std::uint64_t seed = [&] {
    const auto facts = ByteView(whole).subspan(places[1].offset);
    return ByteReader(facts.subspan(24)).u64();
  }();
  const auto ticks_header = replay::decode_chunk_header(ByteView(whole).subspan(places[3].offset), seed);
  REQUIRE(ticks_header);
  replay::ChunkHeader header = *ticks_header;
  const Bytes secret{1, 2, 3};
  header.kind = 0x90;
  header.size = 3;
  const std::uint64_t check = replay::encode_chunk_header(header, seed, out);
  out.bytes(secret);
  out.u64(hash64(secret, check));
  const std::uint64_t chain = replay::extend_chain(header, {}, secret);
  header = *ticks_header;
  header.sequence += 1;
  header.chain = chain;
  std::uint64_t running = replay::encode_chunk_header(header, seed, out);
  replay::append_record(static_cast<replay::RecordTag>(0xa0), secret, running, out);
  replay::append_record(static_cast<replay::RecordTag>(0x80), {}, running, out);
  ByteWriter root;
  root.u64(77);
  replay::append_record(replay::RecordTag::root, root.view(), running, out);
  replay::append_record(static_cast<replay::RecordTag>(0xff), secret, running, out);
  replay::append_close(1, running, out);
  Bytes bytes = out.take();
  const ReadTrace all = read_all(bytes);
  CHECK(all.tail.condition == TraceCondition::truncated);  // it has no end
  REQUIRE(all.ticks.size() == 1);
  CHECK(all.ticks[0].root_hash == 77);
  bytes[places[3].offset + replay::chunk_header_size + 1] ^= 4;
  CHECK(read_all(bytes).tail.condition == TraceCondition::damaged);
  CHECK(read_all(bytes).ticks.empty());
}
