// No cut, flip, splice, swap, mix or bomb gives a complete trace, a wrong tick or a crash.
// SPDX-License-Identifier: MIT
#include <chrono>
#include <string>

#include "base/hash.h"
#include "base/limits.h"
#include "replay/format/chunk.h"
#include "replay/format/payload.h"
#include "tests/replay/toy_traces.h"

using namespace ticktrue;
using namespace ticktrue::test;
using replay::TraceCondition;
using replay::TraceReader;

namespace {

/// Small, with all there is: checkpoints, inputs, changes of dt, ticks in full.
const Bytes& small_trace() {
  static const Bytes made = [] {
    replay::TraceSetup setup = full_toy_setup(2, 3, 4);
    setup.checkpoint_interval = 5;
    return toy_trace(setup, 12);
  }();
  return made;
}

const ReadTrace& small_contents() {
  static const ReadTrace made = read_all(small_trace());
  return made;
}

/// Checks that each part that was read is as recorded, however the trace ends.
void require_true_part(const ReadTrace& part, const ReadTrace& whole) {
  REQUIRE(part.ticks.size() <= whole.ticks.size());
  REQUIRE(part.tail.ticks_intact == part.ticks.size());
  for (std::size_t i = 0; i < part.ticks.size(); ++i) {
    ReadTick expected = whole.ticks[i];
    if (!part.ticks[i].image) expected.image.reset();  // the last one may be cut off
    REQUIRE(part.ticks[i] == expected);
    if (i + 1 < part.ticks.size()) REQUIRE(part.ticks[i].image.has_value() == whole.ticks[i].image.has_value());
  }
  REQUIRE(part.checkpoints.size() <= whole.checkpoints.size());
  for (std::size_t i = 0; i < part.checkpoints.size(); ++i) REQUIRE(part.checkpoints[i] == whole.checkpoints[i]);
  if (part.tail.has_pending_inputs && part.ticks.size() < whole.ticks.size()) {
    const ReadTick& next = whole.ticks[part.ticks.size()];
    REQUIRE(part.tail.pending_dt == next.dt);
    if (!part.tail.pending_inputs.empty()) REQUIRE(part.tail.pending_inputs == next.inputs);
  }
}

ByteView cut(const Bytes& trace, const ChunkPlace& place) {
  return ByteView(trace).subspan(place.offset, place.size);
}

Bytes assemble(const Bytes& trace, const std::vector<ByteView>& chunks) {
  Bytes made(trace.begin(), trace.begin() + replay::file_header_size);
  for (const ByteView chunk : chunks) made.insert(made.end(), chunk.begin(), chunk.end());
  return made;
}

std::vector<ByteView> chunks_of(const Bytes& trace) {
  std::vector<ByteView> chunks;
  for (const ChunkPlace& place : chunk_places(trace)) chunks.push_back(cut(trace, place));
  return chunks;
}

}  // namespace

TEST_CASE("a trace cut anywhere is truncated, and what it gives out is true", "[replay][truncation][corruption]") {
  const Bytes& whole = small_trace();
  const std::size_t setup_end = chunk_places(whole)[1].offset;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CAPTURE(size);
    auto reader = TraceReader::open_bytes(ByteView(whole).first(size), "cut.ttr");
    REQUIRE(reader.has_value() == (size >= setup_end));
    if (!reader) {
      REQUIRE(reader.error().code == ErrorCode::truncated);
      continue;
    }
    const ReadTrace part = read_all(*reader);
    REQUIRE(part.tail.condition == TraceCondition::truncated);
    REQUIRE(part.tail.offset == size);
    REQUIRE_FALSE(part.tail.message.empty());
    REQUIRE(part.tail.intact_after.empty());
    require_true_part(part, small_contents());
    REQUIRE_FALSE(reader->tick_count_hint());
  }
}

TEST_CASE("a cut loses nothing but the tick it lies in", "[replay][truncation][corruption]") {
  // Each byte of the ticks chunks: the parts before it can be read.
  const Bytes& whole = small_trace();
  for (const ChunkPlace& place : chunk_places(whole)) {
    if (place.kind != static_cast<std::uint8_t>(replay::ChunkKind::ticks)) continue;
    std::size_t tick_count = 0;
    std::size_t record_end = replay::chunk_header_size;
    const ByteView chunk = cut(whole, place);
    const auto before = read_all(ByteView(whole).first(place.offset)).ticks.size();
    while (record_end < chunk.size()) {
      const replay::Record record = replay::parse_record(chunk.subspan(record_end), nullptr);
      record_end += record.size;
      if (record.tag == static_cast<std::uint8_t>(replay::RecordTag::root) ||
          record.tag == static_cast<std::uint8_t>(replay::RecordTag::root_image))
        ++tick_count;
      const ReadTrace part = read_all(ByteView(whole).first(place.offset + record_end));
      REQUIRE(part.ticks.size() == before + tick_count);
      if (record.tag == static_cast<std::uint8_t>(replay::RecordTag::inputs)) {
        REQUIRE(part.tail.has_pending_inputs);
        REQUIRE(part.tail.pending_inputs == small_contents().ticks[part.ticks.size()].inputs);
      }
    }
  }
}

TEST_CASE("every changed byte is refused or reported", "[replay][flip][corruption]") {
  const Bytes& whole = small_trace();
  Bytes bytes = whole;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int mask : {0x01, 0x80, 0xff}) {
      CAPTURE(i, mask);
      bytes[i] = static_cast<std::uint8_t>(whole[i] ^ mask);
      auto reader = TraceReader::open_bytes(bytes, "flipped.ttr");
      if (!reader) {
        REQUIRE((reader.error().code == ErrorCode::corrupt || reader.error().code == ErrorCode::truncated ||
                 reader.error().code == ErrorCode::incompatible));
        continue;
      }
      const ReadTrace part = read_all(*reader);
      REQUIRE(part.tail.condition == TraceCondition::damaged);
      REQUIRE_FALSE(part.tail.message.empty());
      require_true_part(part, small_contents());
    }
    bytes[i] = whole[i];
  }
}

TEST_CASE("damaged build facts, index and footer keep no tick from being read", "[replay][flip][corruption]") {
  const Bytes& whole = small_trace();
  const auto places = chunk_places(whole);
  for (const std::size_t chunk : {std::size_t{1}, places.size() - 2, places.size() - 1}) {
    for (std::size_t i = 0; i < places[chunk].size; ++i) {
      CAPTURE(chunk, i);
      Bytes bytes = whole;
      bytes[places[chunk].offset + i] ^= 0x10;
      const ReadTrace all = read_all(bytes);
      REQUIRE(all.tail.condition == TraceCondition::damaged);
      REQUIRE(all.tail.offset == places[chunk].offset);
      REQUIRE(all.ticks.size() == small_contents().ticks.size());
      REQUIRE(all.tail.end);
      REQUIRE(all.tail.end->tick_count == 12);
    }
  }
}

TEST_CASE("damage in the middle is told from what is intact around it", "[replay][flip][corruption]") {
  replay::TraceSetup setup = toy_setup(2);
  setup.checkpoint_interval = 4;
  const Bytes whole = toy_trace(setup, 16);
  const auto places = chunk_places(whole);
  // setup, facts, checkpoint 0, ticks 0..3, checkpoint 4, ticks 4..7, checkpoint 8, ticks 8..11, ...
  Bytes bytes = whole;
  bytes[places[5].offset + 60] ^= 1;
  ReadTrace all = read_all(bytes);
  CHECK(all.tail.condition == TraceCondition::damaged);
  CHECK(all.tail.ticks_intact == 4);
  CHECK(all.tail.offset >= places[5].offset);
  CHECK(all.tail.offset < places[5].offset + places[5].size);
  CHECK(all.tail.message.find("chunk 5 (ticks): ") != std::string::npos);
  REQUIRE(all.tail.intact_after.size() == 1);
  CHECK(all.tail.intact_after[0].first_tick == 8);
  CHECK(all.tail.intact_after[0].last_tick == 15);
  CHECK(all.tail.intact_after[0].has_checkpoint);

  bytes[places[9].offset + 45] ^= 1;  // ticks 12..15
  bytes[places[6].offset + 45] ^= 1;  // checkpoint 8
  all = read_all(bytes);
  REQUIRE(all.tail.intact_after.size() == 1);
  CHECK(all.tail.intact_after[0].first_tick == 8);
  CHECK(all.tail.intact_after[0].last_tick == 11);
  CHECK_FALSE(all.tail.intact_after[0].has_checkpoint);
}

TEST_CASE("removed, doubled, swapped and added chunks are damage", "[replay][splice][corruption]") {
  const Bytes& whole = small_trace();
  const std::vector<ByteView> chunks = chunks_of(whole);
  REQUIRE(read_all(assemble(whole, chunks)).tail.condition == TraceCondition::complete);
  const auto require_refused = [&](const std::vector<ByteView>& changed) {
    const Bytes bytes = assemble(whole, changed);
    auto reader = TraceReader::open_bytes(bytes, "spliced.ttr");
    if (!reader) {
      REQUIRE(reader.error().code == ErrorCode::corrupt);
      return;
    }
    const ReadTrace part = read_all(*reader);
    REQUIRE(part.tail.condition == TraceCondition::damaged);
    require_true_part(part, small_contents());
  };
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    CAPTURE(i);
    std::vector<ByteView> changed = chunks;
    changed.erase(changed.begin() + static_cast<std::ptrdiff_t>(i));
    if (i + 1 < chunks.size()) require_refused(changed);  // without the last it is a cut
    changed = chunks;
    changed.insert(changed.begin() + static_cast<std::ptrdiff_t>(i), chunks[i]);
    require_refused(changed);
    for (std::size_t other = 0; other < i; ++other) {
      changed = chunks;
      std::swap(changed[i], changed[other]);
      require_refused(changed);
    }
  }
  for (const std::size_t size : {1, 40, 1000}) {
    Bytes bytes = whole;
    bytes.resize(whole.size() + size);
    CHECK(read_all(bytes).tail.condition == TraceCondition::damaged);
    CHECK(read_all(bytes).ticks.size() == 12);
  }
  Bytes twice = whole;
  twice.insert(twice.end(), whole.begin(), whole.end());
  CHECK(read_all(twice).tail.condition == TraceCondition::damaged);
}

TEST_CASE("two recordings of one setup cannot be mixed", "[replay][splice][corruption]") {
  replay::TraceSetup setup = toy_setup(2);
  setup.checkpoint_interval = 3;
  const TemporaryFolder folder;
  const auto record_with = [&](const std::string& name, double push, const replay::BuildFacts& facts) {
    ToySimulation simulation(2);
    ScriptedInputs source([&](std::uint64_t tick) -> Result<std::optional<std::pair<double, Bytes>>> {
      ToyInputs inputs;
      if (tick == 1) inputs.push(0, push);
      return std::optional(std::pair(0.015625, inputs.take()));
    });
    replay::RecordOptions options;
    options.tick_count = 9;
    options.writer = plain_writer();
    REQUIRE(replay::record(simulation, source, folder.file(name), setup, facts, options));
    return read_file(folder.file(name));
  };
  const Bytes one = record_with("one.ttr", 1.0, toy_facts);
  const Bytes two = record_with("two.ttr", 2.0, {{"compiler", "gc2"}, {"target", "x86_64"}});
  REQUIRE(one.size() == two.size());
  const std::vector<ByteView> chunks_one = chunks_of(one);
  const std::vector<ByteView> chunks_two = chunks_of(two);
  for (std::size_t mask = 1; mask + 1 < (1u << chunks_one.size()); ++mask) {
    std::vector<ByteView> mixed;
    bool is_one = true, is_two = true;
    for (std::size_t i = 0; i < chunks_one.size(); ++i) {
      mixed.push_back((mask >> i & 1) != 0 ? chunks_two[i] : chunks_one[i]);
      is_one &= std::equal(mixed[i].begin(), mixed[i].end(), chunks_one[i].begin(), chunks_one[i].end());
      is_two &= std::equal(mixed[i].begin(), mixed[i].end(), chunks_two[i].begin(), chunks_two[i].end());
    }
    if (is_one || is_two) continue;
    CAPTURE(mask);
    const Bytes bytes = assemble(one, mixed);
    REQUIRE(read_all(bytes).tail.condition == TraceCondition::damaged);
  }
}

TEST_CASE("facts of the same content from another build are reported", "[replay][splice][corruption]") {
  const Bytes one = toy_trace(toy_setup(2), 5);
  const Bytes two = toy_trace(toy_setup(2), 5, plain_writer(), {{"compiler", "gc2"}, {"target", "x86_64"}});
  REQUIRE(one.size() == two.size());
  std::vector<ByteView> chunks = chunks_of(one);
  const std::vector<ByteView> others = chunks_of(two);
  chunks[1] = others[1];
  const Bytes bytes = assemble(one, chunks);
  const ReadTrace all = read_all(bytes);
  CHECK(all.tail.condition == TraceCondition::damaged);
  CHECK(all.tail.message.find("build facts") != std::string::npos);
  CHECK(all.ticks.size() == 5);
}

namespace {

/// Writes chunks with right checks around any content, as only a forger or a bug does.
class Forge {
 public:
  explicit Forge(const Bytes& model) {
    const auto places = chunk_places(model);
    const ByteView facts = cut(model, places[1]);
    seed_ = chain_ = ByteReader(facts.subspan(24)).u64();
    out_.bytes(ByteView(model).first(places[2].offset));
    sequence_ = 2;
  }
  Forge& chunk(std::uint8_t kind, ByteView payload, std::uint64_t tick, std::optional<std::uint32_t> size = {}) {
    replay::ChunkHeader header = next(kind, size.value_or(static_cast<std::uint32_t>(payload.size())), tick);
    header.check = replay::encode_chunk_header(header, seed_, out_);
    out_.bytes(payload);
    out_.u64(hash64(payload, header.check));
    chain_ = replay::extend_chain(header, {}, payload);
    return *this;
  }
  Forge& image(std::uint8_t kind, std::uint64_t tick, std::uint64_t image_size, std::uint64_t offset,
               std::uint32_t size, std::uint8_t codec, ByteView stored, ByteView raw) {
    ByteWriter payload;
    payload.u64(1);
    payload.u64(image_size);
    payload.u64(offset);
    payload.u32(size);
    payload.u8(codec);
    payload.bytes(stored);
    const std::uint64_t before = chain_;
    chunk(kind, payload.view(), tick);
    replay::ChunkHeader header = last_;
    header.chain = before;
    chain_ = replay::extend_chain(header, payload.view().first(replay::image_part_fields_size), raw);
    return *this;
  }
  /// A ticks chunk: records, then close with the given count.
  Forge& ticks(const std::vector<std::pair<std::uint8_t, Bytes>>& records, std::uint32_t count, std::uint64_t tick) {
    std::uint64_t running = replay::encode_chunk_header(
        next(static_cast<std::uint8_t>(replay::ChunkKind::ticks), replay::streamed_size, tick), seed_, out_);
    for (const auto& [tag, body] : records)
      replay::append_record(static_cast<replay::RecordTag>(tag), body, running, out_);
    replay::append_close(count, running, out_);
    chain_ = running;
    return *this;
  }
  Forge& raw(ByteView bytes) {
    out_.bytes(bytes);
    return *this;
  }
  Bytes take() { return out_.take(); }

 private:
  replay::ChunkHeader next(std::uint8_t kind, std::uint32_t size, std::uint64_t tick) {
    replay::ChunkHeader header;
    header.kind = kind;
    header.sequence = sequence_++;
    header.size = size;
    header.tick = tick;
    header.chain = chain_;
    last_ = header;
    return header;
  }
  ByteWriter out_;
  std::uint64_t seed_ = 0;
  std::uint64_t chain_ = 0;
  std::uint32_t sequence_ = 0;
  replay::ChunkHeader last_;
};

Bytes hash_bytes(std::uint64_t value) {
  ByteWriter out;
  out.u64(value);
  return out.take();
}

std::string fault_of(const Bytes& bytes) {
  const ReadTrace all = read_all(bytes);
  REQUIRE(all.tail.condition == TraceCondition::damaged);
  return all.tail.message;
}

constexpr std::uint8_t checkpoint_kind = 3, image_kind = 5;
constexpr std::uint8_t dt_tag = 1, inputs_tag = 2, stages_tag = 3, cells_tag = 4, root_tag = 5, root_image_tag = 6;

}  // namespace

TEST_CASE("what is checked right but means nonsense is refused", "[replay][forgery][corruption]") {
  const Bytes model = toy_trace(toy_setup(1), 1);
  const Bytes full_model = toy_trace(full_toy_setup(1, 0, 9), 1);
  const Bytes image(12);  // three tables without rows
  const auto begin = [&](const Bytes& of) { return Forge(of).image(checkpoint_kind, 0, 12, 0, 12, 0, image, image); };
  using Records = std::vector<std::pair<std::uint8_t, Bytes>>;
  const auto ticks = [&](const Records& records, std::uint32_t count) {
    return fault_of(begin(full_model).ticks(records, count, 0).take());
  };
  const auto has = [](const std::string& text, const std::string& part) {
    CAPTURE(text);
    CHECK(text.find(part) != std::string::npos);
  };
  const Bytes root = hash_bytes(1);
  has(ticks({{root_tag, root}}, 2), "tick count: found 2, expected 1");
  has(ticks({{inputs_tag, {1}}, {inputs_tag, {1}}, {root_tag, root}}, 1), "record order: found tag 2 after 2");
  has(ticks({{inputs_tag, {1}}, {dt_tag, root}, {root_tag, root}}, 1), "record order: found tag 1 after 2");
  has(ticks({{dt_tag, hash_bytes(bits_of(-1.0))}, {root_tag, root}}, 1), "dt: found no finite length");
  has(ticks({{dt_tag, hash_bytes(0x7ff8000000000000)}, {root_tag, root}}, 1), "dt: found no finite length");
  has(ticks({{stages_tag, Bytes(16)}, {root_tag, root}}, 1), "stage hashes: found 2");
  has(ticks({{stages_tag, Bytes(23)}, {root_tag, root}}, 1), "stage hashes: found 2");
  has(ticks({{stages_tag, Bytes(24)}}, 0), "stage hashes without a root hash");
  has(ticks({{inputs_tag, {}}, {root_tag, root}}, 1), "record size");
  has(ticks({{cells_tag, root}, {root_tag, root}}, 1), "cells: found");
  has(ticks({{0, root}, {root_tag, root}}, 1), "record tag: found 0");
  has(ticks({{root_image_tag, root}, {root_tag, root}}, 2), "behind a tick with image");
  has(fault_of(begin(model).ticks({{stages_tag, Bytes(24)}, {root_tag, root}}, 1, 0).take()), "stage hashes");
  has(fault_of(begin(model).ticks({{root_image_tag, root}}, 1, 0).take()), "not stored in full");
  has(fault_of(begin(full_model).ticks({{root_image_tag, root}}, 1, 0).ticks({{root_tag, root}}, 1, 1).take()),
      "expected the image of the last tick");
  has(fault_of(begin(model).image(image_kind, 0, 12, 0, 12, 0, image, image).take()), "kind: found 5");
  has(fault_of(begin(model).image(checkpoint_kind, 0, 12, 0, 12, 0, image, image).take()), "at most one checkpoint");
  has(fault_of(Forge(model).ticks({{root_tag, root}}, 1, 0).take()), "checkpoint at tick 0 first");
  has(fault_of(begin(model).ticks({{inputs_tag, {1}}}, 0, 0).ticks({{root_tag, root}}, 1, 0).take()),
      "expected the end, since inputs");
  has(fault_of(begin(model).ticks({{root_tag, root}}, 1, 7).take()), "first tick: found 7, expected 0");
  has(fault_of(begin(model).chunk(0x42, image, 0).take()), "(unknown): kind: found 66");
  has(fault_of(begin(model).chunk(1, image, 0).take()), "(setup): kind");
  has(fault_of(begin(model).chunk(7, image, 0).take()), "(index): kind");
  has(fault_of(begin(model).chunk(6, Bytes{9, 0, 0, 0, 0}, 0).take()), "end: reason: found 9");
  has(fault_of(begin(model).chunk(6, Bytes{1, 5, 0, 0, 0}, 0).take()), "end: sizes");
  // An index that is checked right and lists a place where no checkpoint is.
  ByteWriter index;
  index.u32(1);
  index.u32(1);
  index.u64(0);
  index.u64(99);
  has(fault_of(begin(model).chunk(6, Bytes{1, 0, 0, 0, 0}, 0).chunk(7, index.view(), 0).take()), "index: found other");
}

TEST_CASE("stated sizes are bounded before anything is allocated", "[replay][bomb][corruption]") {
  const Bytes model = toy_trace(toy_setup(1), 1);
  const auto start = std::chrono::steady_clock::now();
  const Bytes image(12);  // three tables without rows
  const auto begin = [&] { return Forge(model).image(checkpoint_kind, 0, 12, 0, 12, 0, image, image); };
  const auto has = [](const std::string& text, const std::string& part) {
    CAPTURE(text);
    CHECK(text.find(part) != std::string::npos);
  };
  // A state image of 2^60 bytes; a first part that claims more than a part may have; parts that do not add up.
  has(fault_of(Forge(model).image(checkpoint_kind, 0, 1ull << 60, 0, 1u << 20, 0, image, image).take()),
      "state image: size: found 1152921504606846976");
  has(fault_of(Forge(model).image(checkpoint_kind, 0, 1u << 30, 0, 0xffffffffu, 1, image, image).take()),
      "parts do not add up");
  has(fault_of(Forge(model).image(checkpoint_kind, 0, 3, 4, 0, 0, image, image).take()), "parts do not add up");
  has(fault_of(Forge(model).image(checkpoint_kind, 0, 4, 0, 4, 0, image, image).take()), "stored size");
  has(fault_of(Forge(model).image(checkpoint_kind, 0, 3, 0, 3, 9, image, image).take()), "codec: found 9");
  has(fault_of(Forge(model).image(checkpoint_kind, 0, 3, 0, 3, 1, image, image).take()), "zstd");
  // Chunks and records that claim to be huge.
  has(fault_of(begin().chunk(6, image, 0, 0x7fffffffu).take()), "size: found 2147483647");
  has(fault_of(begin().chunk(0x80, image, 0, 0xfffffffeu).take()), "size: found 4294967294");
  for (const std::uint8_t tag : {std::uint8_t{2}, std::uint8_t{3}, std::uint8_t{0x80}}) {
    Bytes record{tag, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1};
    Forge forge = begin();
    forge.ticks({}, 0, 0);
    Bytes bytes = forge.take();
    bytes.resize(bytes.size() - 13);  // without its close record
    bytes.insert(bytes.end(), record.begin(), record.end());
    bytes.resize(bytes.size() + 100);
    has(fault_of(bytes), "record size");
  }
  // Setups with counts far beyond the bytes that follow.
  ByteWriter setup_payload;
  replay::encode_setup(toy_setup(1), setup_payload);
  // The sizes of the simulation's name, of the title and of the simulation's own setup.
  for (const std::size_t place : {std::size_t{0}, std::size_t{20}, setup_payload.size() - 8}) {
    Bytes payload(setup_payload.view().begin(), setup_payload.view().end());
    for (std::size_t i = 0; i < 4; ++i) payload[place + i] = 0xff;
    ByteWriter file;
    replay::encode_file_header(file);
    replay::ChunkHeader header;
    header.kind = 1;
    header.size = static_cast<std::uint32_t>(payload.size());
    header.chain = replay::chain_start();
    const std::uint64_t check = replay::encode_chunk_header(header, replay::chain_start(), file);
    file.bytes(payload);
    file.u64(hash64(payload, check));
    const auto reader = TraceReader::open_bytes(file.view(), "bomb.ttr");
    CAPTURE(place);
    REQUIRE_FALSE(reader);
    CHECK(reader.error().code == ErrorCode::corrupt);
  }
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(5));
}

TEST_CASE("many forged headers behind damage do not stop the reader", "[replay][bomb][corruption]") {
  const Bytes model = toy_trace(toy_setup(1), 1);
  Forge forge = Forge(model);
  forge.image(checkpoint_kind, 0, 3, 0, 3, 0, Bytes{1, 2, 3}, Bytes{1, 2, 3});
  forge.raw(Bytes(1));  // the damage
  for (int i = 0; i < 200'000; ++i) forge.ticks({{inputs_tag, {1}}}, 5, 0);
  const auto start = std::chrono::steady_clock::now();
  const ReadTrace all = read_all(forge.take());
  CHECK(all.tail.condition == TraceCondition::damaged);
  CHECK(all.tail.intact_after.empty());
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(10));
}

TEST_CASE("what is no trace says so", "[replay][open][corruption]") {
  const auto error_of = [](ByteView bytes) {
    const auto reader = TraceReader::open_bytes(bytes, "x.ttr");
    REQUIRE_FALSE(reader);
    return reader.error();
  };
  CHECK(error_of({}).code == ErrorCode::truncated);
  const Bytes text{'{', '"', 'a', '"'};
  CHECK(error_of(text).code == ErrorCode::corrupt);
  CHECK(error_of(text).message == "x.ttr: offset 0: no trace: it does not begin with the mark of one");
  const Bytes& whole = small_trace();
  // Line ends changed by a transfer in text mode.
  Bytes changed = whole;
  changed.erase(changed.begin() + 4);
  CHECK(error_of(changed).code == ErrorCode::corrupt);
  // A newer version whose file header is right.
  ByteWriter newer;
  newer.bytes(replay::magic);
  newer.u16(4);
  newer.u16(0);
  newer.u32(static_cast<std::uint32_t>(hash64(newer.view())));
  CHECK(error_of(newer.view()).code == ErrorCode::incompatible);
  CHECK(error_of(newer.view()).message == "x.ttr: format version: found 4 with flags 0, expected 1..3 with flags 0");
  CHECK(error_of(newer.view()).hint == "use a newer ticktrue");
}
