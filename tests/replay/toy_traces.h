// Traces of the toy simulation, and what a test reads back from one.
// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "replay/recorder.h"
#include "replay/trace_reader.h"
#include "replay/trace_writer.h"
#include "tests/support/catch.h"
#include "tests/support/toy_simulation.h"

namespace ticktrue::test {

/// A temporary folder. Its destructor removes it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    static std::atomic<int> count{0};
    path_ = std::filesystem::temp_directory_path() /
            ("ticktrue_replay_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

inline Bytes read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), {});
}
inline void write_file(const std::string& path, ByteView bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

inline replay::TraceSetup toy_setup(std::uint32_t body_count) {
  replay::TraceSetup setup;
  setup.simulation = "ticktrue.toy";
  setup.physics_version = 1;
  setup.title = "toy of " + std::to_string(body_count);
  setup.dt = 0.015625;
  setup.schema = ToySimulation::schema();
  setup.stages = ToySimulation::stages();
  setup.setup = ToySimulation::setup(body_count);
  return setup;
}
inline replay::TraceSetup full_toy_setup(std::uint32_t body_count, std::uint64_t first, std::uint64_t last) {
  replay::TraceSetup setup = toy_setup(body_count);
  setup.detail = replay::Detail::full;
  setup.full_first = first;
  setup.full_last = last;
  return setup;
}

inline const replay::BuildFacts toy_facts{{"compiler", "gcc"}, {"target", "x86_64"}};

/// Inputs made by a function of the tick; repeatable() returns `repeats`.
class ScriptedInputs : public replay::InputSource {
 public:
  using Script = std::function<Result<std::optional<std::pair<double, Bytes>>>(std::uint64_t tick)>;
  explicit ScriptedInputs(Script script, bool repeats = true) : script_(std::move(script)), repeats_(repeats) {}
  Result<std::optional<TickInput>> next(std::uint64_t tick) override {
    auto made = script_(tick);
    if (!made) return made.error();
    if (!made->has_value()) return std::optional<TickInput>();
    current_ = std::move((*made)->second);
    return std::optional<TickInput>(TickInput{(*made)->first, current_});
  }
  bool repeatable() const override { return repeats_; }

 private:
  Script script_;
  bool repeats_;
  Bytes current_;
};

/// A session with pushes, spawns, removals, changes of gravity and of dt.
inline Result<std::optional<std::pair<double, Bytes>>> lively_script(std::uint64_t tick) {
  ToyInputs inputs;
  if (tick % 3 == 1) inputs.push(0, 0.5 + static_cast<double>(tick));
  if (tick % 7 == 2) inputs.spawn(static_cast<double>(tick)).push(1, -1);
  if (tick == 5) inputs.remove(1);
  if (tick == 9) inputs.gravity(-3.5);
  const double dt = tick % 5 == 4 ? 0.0078125 : 0.015625;
  return std::optional(std::pair(dt, inputs.take()));
}

inline replay::WriterOptions plain_writer() {
  replay::WriterOptions options;
  options.compress = false;
  options.sync = false;
  return options;
}

inline Result<replay::RecordResult> record_toy(const std::string& path, const replay::TraceSetup& setup,
                                               std::uint64_t tick_count,
                                               const replay::WriterOptions& writer = plain_writer(),
                                               const replay::BuildFacts& facts = toy_facts) {
  ByteReader in(setup.setup);
  ToySimulation simulation(in.u32());
  ScriptedInputs source(lively_script);
  replay::RecordOptions options;
  options.tick_count = tick_count;
  options.writer = writer;
  return replay::record(simulation, source, path, setup, facts, options);
}

inline Bytes toy_trace(const replay::TraceSetup& setup, std::uint64_t tick_count,
                       const replay::WriterOptions& writer = plain_writer(),
                       const replay::BuildFacts& facts = toy_facts) {
  const TemporaryFolder folder;
  const auto result = record_toy(folder.file("toy.ttr"), setup, tick_count, writer, facts);
  if (!result) FAIL(result.error().message);
  return read_file(folder.file("toy.ttr"));
}

struct ReadTick {
  std::uint64_t tick = 0;
  double dt = 0;
  Bytes inputs;
  std::uint64_t root_hash = 0;
  std::vector<std::uint64_t> stage_hashes;
  std::optional<Bytes> image;
  bool operator==(const ReadTick&) const = default;
};
struct ReadCheckpoint {
  std::uint64_t tick = 0;
  std::uint64_t root_hash = 0;
  Bytes image;
  bool operator==(const ReadCheckpoint&) const = default;
};
struct ReadTrace {
  std::vector<ReadTick> ticks;
  std::vector<ReadCheckpoint> checkpoints;
  replay::TraceTail tail;
};

/// Reads on to the end.
inline ReadTrace read_all(replay::TraceReader& reader) {
  ReadTrace all;
  for (;;) {
    const auto& item = reader.next();
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) {
      ReadTick copy{tick->tick,      tick->dt,           Bytes(tick->inputs.begin(), tick->inputs.end()),
                    tick->root_hash, tick->stage_hashes, {}};
      if (tick->image) copy.image = tick->image->joined();
      all.ticks.push_back(std::move(copy));
    } else if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
      all.checkpoints.push_back(
          {checkpoint->tick, checkpoint->root_hash, Bytes(checkpoint->image.begin(), checkpoint->image.end())});
    } else {
      all.tail = reader.tail();
      return all;
    }
  }
}
inline ReadTrace read_all(ByteView bytes) {
  auto reader = replay::TraceReader::open_bytes(bytes, "test.ttr");
  if (!reader) FAIL(reader.error().message);
  return read_all(*reader);
}

/// The offsets of the chunks of a whole trace.
struct ChunkPlace {
  std::uint8_t kind = 0;
  std::size_t offset = 0;
  std::size_t size = 0;  // with header and trailer
};
std::vector<ChunkPlace> chunk_places(ByteView trace);

}  // namespace ticktrue::test
