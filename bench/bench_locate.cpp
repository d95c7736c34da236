// A long recording with one flipped bit, and the time from the file to the named tick, column and body.
// SPDX-License-Identifier: MIT
//
//   bench_locate record SCENE TICKS FLIP_TICK DETAIL OUT.ttr
//     Records the scene. At the end of FLIP_TICK one bit of a velocity flips.
//   bench_locate find FILE [THREADS]
//     Verifies the file; prints the wall time and the findings.
//
// The flip has the effect of a memory error or a race in a recorder. The bit stays in the state, and all later states
// follow from it, so that every later hash and checkpoint agrees with the flipped run. DETAIL is root or full (ticks
// around the flip).
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "base/parallel/jobs.h"
#include "base/state/state_view.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "replay/recorder.h"
#include "tool/session/session.h"
#include "tool/session/simulations.h"
#include "verifier/verify/verify.h"

namespace ticktrue {
namespace {

/// The engine with one flipped bit in its state at the end of a tick.
class FlippedEngine : public Simulation {
 public:
  FlippedEngine(engine::Engine& real, std::uint64_t flip_tick) : real_(real), flip_tick_(flip_tick) {}
  Status accept(const TickInput& input) const override { return real_.accept(input); }
  Status step(const TickInput& input, StageObserver* observer) override {
    if (Status did = real_.step(input, observer); !did) return did;
    if (tick_++ == flip_tick_) flip();
    return {};
  }
  const StateView& state() const override { return real_.state(); }
  Status load(ByteView image) override { return real_.load(image); }
  std::span<const std::string> stage_names() const override { return real_.stage_names(); }
  std::string row_name(std::size_t table, std::size_t row) const override { return real_.row_name(table, row); }
  std::string inputs_text(std::uint64_t tick, ByteView inputs) const override {
    return real_.inputs_text(tick, inputs);
  }

 private:
  /// Flips the lowest bit of the first velocity lane in the middle row of the table bodies.
  void flip() {
    const StateSchema& schema = *real_.state().schema;
    Bytes image;
    encode_image(real_.state(), image);
    const auto tables = split_image(schema, image);
    const std::size_t table = *schema.find_table("bodies");
    const TableSchema& bodies = schema.tables[table];
    std::size_t offset = 0;
    for (const Column& column : bodies.columns)
      if (column.name == "velocity") offset = column.offset;
    const ByteView rows = (*tables)[table].rows;
    const std::size_t row = (*tables)[table].row_count / 2;
    image[static_cast<std::size_t>(rows.data() - image.data()) + row * bodies.row_size + offset] ^= 1;
    const Status loaded = real_.load(image);
    std::printf("flipped  tick %llu, bodies.velocity row %zu lane 0, lowest bit%s\n",
                static_cast<unsigned long long>(flip_tick_), row, loaded ? "" : ": REFUSED");
  }

  engine::Engine& real_;
  std::uint64_t flip_tick_;
  std::uint64_t tick_ = 0;
};

int complain(const std::string& what) {
  std::fprintf(stderr, "bench_locate: error: %s\n", what.c_str());
  return 2;
}

bool read_number(const char* text, std::uint64_t& value) {
  const auto [end, failure] = std::from_chars(text, text + std::strlen(text), value);
  return failure == std::errc() && *end == '\0';
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

int record(const std::string& word, std::uint64_t tick_count, std::uint64_t flip_tick, const std::string& detail,
           const std::string& path) {
  const auto scene = engine::make_builtin_scene(word);
  if (!scene) return complain(scene.error().message);
  const auto made = engine::make_engine(*scene);
  if (!made) return complain(made.error().message);
  tool::TraceChoices choices;
  if (detail == "full") {
    choices.detail = replay::Detail::full;
    choices.full_first = choices.full_last = flip_tick;
  }
  FlippedEngine simulation(**made, flip_tick);
  replay::NoInputs inputs(scene->settings.dt);
  replay::RecordOptions options;
  options.tick_count = tick_count;
  options.writer.overwrite = true;
  const auto result = replay::record(simulation, inputs, path, tool::make_trace_setup(**made, choices),
                                     tool::make_build_facts(), options);
  if (!result) return complain(result.error().message);
  std::printf("recorded %s  %llu ticks, %zu bodies, %llu bytes, %.4f ms/tick\n", path.c_str(),
              static_cast<unsigned long long>(result->tick_count), (*made)->bodies().size(),
              static_cast<unsigned long long>(result->size),
              result->simulate_s * 1e3 / static_cast<double>(result->tick_count));
  return 0;
}

int find(const std::string& path, unsigned thread_count) {
  const auto start = std::chrono::steady_clock::now();
  auto reader = replay::TraceReader::open(path);
  if (!reader) return complain(reader.error().message);
  verifier::VerifyOptions options;
  options.simulation = tool::find_simulation(reader->setup().simulation);
  options.thread_count = thread_count;
  options.search_single_bit = true;
  options.reopen = [&]() -> std::unique_ptr<verifier::TraceSource> {
    auto again = replay::TraceReader::open(path);
    if (!again) return nullptr;
    return std::make_unique<verifier::OwnedReaderSource>(std::move(*again));
  };
  const verifier::Report report = verifier::verify(*reader, options);
  const double wall_s = seconds_since(start);
  std::printf("%s%s: %.2f s on %u threads, %llu ticks compared, %llu stretches\n",
              verifier::report_text(report).c_str(), path.c_str(), wall_s, thread_count,
              static_cast<unsigned long long>(report.ticks_compared), static_cast<unsigned long long>(report.segments));
  return report.divergence ? 0 : 1;
}

int run(int argc, char** argv) {
  std::uint64_t tick_count = 0, flip_tick = 0, thread_count = core_count();
  const std::string command = argc > 1 ? argv[1] : "";
  if (command == "record" && argc == 7 && read_number(argv[3], tick_count) && read_number(argv[4], flip_tick))
    return record(argv[2], tick_count, flip_tick, argv[5], argv[6]);
  if (command == "find" && (argc == 3 || (argc == 4 && read_number(argv[3], thread_count))))
    return find(argv[2], static_cast<unsigned>(thread_count));
  return complain("usage: bench_locate record SCENE TICKS FLIP_TICK root|full OUT.ttr | find FILE [THREADS]");
}

}  // namespace
}  // namespace ticktrue

int main(int argc, char** argv) {
  return ticktrue::run(argc, argv);
}
