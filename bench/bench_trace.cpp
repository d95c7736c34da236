// The cost of recording and verifying beside the simulation alone, and the bytes of both: in turn in one process.
// SPDX-License-Identifier: MIT
//
// Every variant steps its own engine through the same ticks. Blocks of ticks take turns, so that each variant has the
// same machine load and the same state. One sample is a block's time divided by that of the plain block before it; the
// output is the median of the samples. Verification is timed as a whole, run against run. Times are processor time of
// the thread, kernel included: neither other programs nor waiting for the disk count.
#include <fmt/format.h>
#include <time.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/build_info.h"
#include "base/state/cells.h"
#include "base/state/state_view.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "replay/recorder.h"
#include "tool/session/session.h"
#include "tool/session/trace_summary.h"
#include "verifier/verify/verify.h"

namespace ticktrue {
namespace {

using Json = nlohmann::ordered_json;
/// Processor time of this thread.
struct Clock {
  using duration = std::chrono::nanoseconds;
  using time_point = duration;
  static time_point now() {
    timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
  }
};

struct BenchOptions {
  std::string scene = "mixed_pile?bodies=1000&substeps=4";
  std::uint64_t warmup = 120;      // untimed ticks at the start: a pile has to form
  std::uint64_t tick_count = 400;  // timed
  std::uint64_t block_size = 10;
  std::uint64_t repeat_count = 3;
  bool is_third = false;
  bool json = false;
};

double median(std::vector<double> samples) {
  if (samples.empty()) return 0;
  std::sort(samples.begin(), samples.end());
  return samples[samples.size() / 2];
}

double microseconds(Clock::duration time) {
  return std::chrono::duration<double, std::micro>(time).count();
}

/// A file that its destructor removes.
class ScratchFile {
 public:
  explicit ScratchFile(const char* name)
      : path_((std::filesystem::temp_directory_path() /
               ("ticktrue_bench_" + std::to_string(::getpid()) + "_" + name + ".ttr"))
                  .string()) {}
  ~ScratchFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// `is_third`: of format version 3, as a trace with notes is.
replay::TraceSetup setup_of(const engine::Engine& engine, replay::Detail detail, std::uint32_t checkpoint_interval,
                            bool is_third) {
  tool::TraceChoices made;
  made.detail = detail;
  made.checkpoint_interval = checkpoint_interval;
  replay::TraceSetup setup = tool::make_trace_setup(engine, made);
  if (is_third) setup.features = static_cast<std::uint32_t>(replay::Feature::notes);
  return setup;
}

/// A way to run a tick, on its own engine.
class Variant {
 public:
  Variant(const engine::Scene& scene, std::optional<replay::Detail> detail, bool is_third)
      : engine_(*engine::make_engine(scene)) {
    input_.dt = scene.settings.dt;
    if (!detail) return;
    file_ = std::make_unique<ScratchFile>(std::string(replay::detail_info(*detail).name).c_str());
    replay::WriterOptions writer;
    writer.overwrite = true;
    writer.allow_third = is_third;
    writer_.emplace(*replay::TraceWriter::create(file_->path(), setup_of(*engine_, *detail, 0, is_third),
                                                 tool::make_build_facts(), writer));
    TICKTRUE_ASSERT(writer_->checkpoint(engine_->state(), root_hash(engine_->state())));
  }

  void tick() {
    TICKTRUE_ASSERT(engine_->accept(input_));
    if (!writer_) {
      TICKTRUE_ASSERT(engine_->step(input_, nullptr));
      return;
    }
    // In the same way as replay::record.
    TICKTRUE_ASSERT(writer_->begin_tick(input_));
    TICKTRUE_ASSERT(engine_->step(input_, nullptr));
    TICKTRUE_ASSERT(!find_non_finite(engine_->state()));
    const std::uint64_t root = root_hash(engine_->state());
    TICKTRUE_ASSERT(writer_->end_tick(root, {}, writer_->wants_state() ? &engine_->state() : nullptr));
  }

  Clock::duration time_block(std::uint64_t count) {
    const Clock::time_point start = Clock::now();
    for (std::uint64_t i = 0; i < count; ++i) tick();
    return Clock::now() - start;
  }

  const engine::Engine& engine() const { return *engine_; }

 private:
  std::unique_ptr<engine::Engine> engine_;
  std::unique_ptr<ScratchFile> file_;
  std::optional<replay::TraceWriter> writer_;
  TickInput input_;
};

struct Measured {
  double tick_us = 0;
  double root_hash_us = 0, cells_us = 0, non_finite_us = 0;  // of the state, alone
  double root_ratio = 0, cells_ratio = 0, verify_ratio = 0;  // to the plain run
  double root_bytes = 0, cells_bytes = 0;                    // per tick
  double checkpoint_bytes = 0;                               // per body
  std::size_t body_count = 0, contact_count = 0;
};

/// Median time of one call, in microseconds.
template <typename Call>
double time_call(Call call) {
  std::vector<double> samples;
  for (int i = 0; i < 200; ++i) {
    const Clock::time_point start = Clock::now();
    call();
    samples.push_back(microseconds(Clock::now() - start));
  }
  return median(std::move(samples));
}

void measure_ticks(const engine::Scene& scene, const BenchOptions& options, Measured& measured) {
  std::vector<double> plain_us, root_ratios, cells_ratios;
  for (std::uint64_t repeat = 0; repeat < options.repeat_count; ++repeat) {
    Variant plain(scene, {}, false), root(scene, replay::Detail::root, options.is_third),
        cells(scene, replay::Detail::cells, options.is_third);
    for (Variant* variant : {&plain, &root, &cells}) variant->time_block(options.warmup);
    for (std::uint64_t done = 0; done < options.tick_count; done += options.block_size) {
      const double base = microseconds(plain.time_block(options.block_size));
      plain_us.push_back(base / static_cast<double>(options.block_size));
      root_ratios.push_back(microseconds(root.time_block(options.block_size)) / base);
      cells_ratios.push_back(microseconds(cells.time_block(options.block_size)) / base);
    }
    if (repeat + 1 < options.repeat_count) continue;
    const StateView& state = plain.engine().state();
    std::uint64_t sink = 0;
    CellHasher hasher(*state.schema);
    StateCells out;
    measured.root_hash_us = time_call([&] { sink += root_hash(state); });
    measured.cells_us = time_call([&] { hasher.hash(state, 0, out); });
    measured.non_finite_us = time_call([&] { sink += find_non_finite(state).has_value(); });
    TICKTRUE_ASSERT(sink != 0);
    measured.body_count = plain.engine().bodies().size();
    measured.contact_count = plain.engine().contacts().size();
  }
  measured.tick_us = median(std::move(plain_us));
  measured.root_ratio = median(std::move(root_ratios));
  measured.cells_ratio = median(std::move(cells_ratios));
}

std::uint64_t trace_size(const engine::Scene& scene, replay::Detail detail, std::uint64_t tick_count,
                         const std::string& path, std::uint32_t checkpoint_interval, bool is_third) {
  auto engine = *engine::make_engine(scene);
  replay::NoInputs inputs(scene.settings.dt);
  replay::RecordOptions options;
  options.tick_count = tick_count;
  options.writer.overwrite = true;
  options.writer.allow_third = is_third;
  const auto result = replay::record(*engine, inputs, path, setup_of(*engine, detail, checkpoint_interval, is_third),
                                     tool::make_build_facts(), options);
  TICKTRUE_ASSERT(result);
  return result->size;
}

void measure_sizes(const engine::Scene& scene, const BenchOptions& options, Measured& measured) {
  const ScratchFile file("size");
  const std::uint64_t few = options.warmup, many = options.warmup + options.tick_count;
  const auto per_tick = [&](replay::Detail detail) {
    return static_cast<double>(trace_size(scene, detail, many, file.path(), 0, options.is_third) -
                               trace_size(scene, detail, few, file.path(), 0, options.is_third)) /
           static_cast<double>(options.tick_count);
  };
  measured.root_bytes = per_tick(replay::Detail::root);
  measured.cells_bytes = per_tick(replay::Detail::cells);
  trace_size(scene, replay::Detail::root, many, file.path(), static_cast<std::uint32_t>(many - 1), options.is_third);
  auto reader = replay::TraceReader::open(file.path());
  TICKTRUE_ASSERT(reader);
  const tool::TraceSummary summary = tool::summarize(*reader, {});
  measured.checkpoint_bytes =
      static_cast<double>(summary.checkpoints.back().stored_size) / static_cast<double>(measured.body_count);
}

void measure_verify(const engine::Scene& scene, const BenchOptions& options, Measured& measured) {
  const ScratchFile file("verify");
  const std::uint64_t tick_count = options.warmup + options.tick_count;
  trace_size(scene, replay::Detail::cells, tick_count, file.path(), 600, options.is_third);
  std::vector<double> ratios;
  for (std::uint64_t repeat = 0; repeat < 2 * options.repeat_count + 1; ++repeat) {
    Clock::time_point start = Clock::now();
    Variant plain(scene, {}, false);
    plain.time_block(tick_count);
    const double base = microseconds(Clock::now() - start);
    start = Clock::now();
    auto reader = replay::TraceReader::open(file.path());
    verifier::VerifyOptions verify_options;
    verify_options.simulation = &engine::engine_info();
    const verifier::Report report = verifier::verify(*reader, verify_options);
    ratios.push_back(microseconds(Clock::now() - start) / base);
    TICKTRUE_ASSERT(report.verdict == verifier::Verdict::match);
  }
  measured.verify_ratio = median(std::move(ratios));
}

/// A measure, its bound, and the format of its output.
struct Line {
  const char* name;
  double value;
  double bar;
  const char* unit;
};

int run(const BenchOptions& options) {
  const Result<engine::Scene> scene = engine::make_builtin_scene(options.scene);
  if (!scene) {
    std::fprintf(stderr, "bench_trace: error: %s\n", scene.error().message.c_str());
    return 2;
  }
  Measured measured;
  measure_ticks(*scene, options, measured);
  measure_sizes(*scene, options, measured);
  measure_verify(*scene, options, measured);
  const Line lines[] = {
      {"root_hash_share", measured.root_hash_us / measured.tick_us, 0.025, "of the tick"},
      {"record_root", measured.root_ratio, 1.03, "times the plain run"},
      {"record_cells", measured.cells_ratio, 1.08, "times the plain run"},
      {"verify", measured.verify_ratio, 1.10, "times the plain run"},
      {"root_bytes", measured.root_bytes, 12, "bytes per tick"},
      {"cells_bytes", measured.cells_bytes, 320, "bytes per tick"},
      {"checkpoint_bytes", measured.checkpoint_bytes, 250, "bytes per body"},
  };
  if (options.json) {
    Json object = {{"schema", "ticktrue.bench_trace/1"}, {"scene", options.scene},
                   {"bodies", measured.body_count},      {"contacts", measured.contact_count},
                   {"tick_us", measured.tick_us},        {"root_hash_us", measured.root_hash_us},
                   {"cells_us", measured.cells_us},      {"non_finite_us", measured.non_finite_us}};
    for (const Line& line : lines) object[line.name] = {{"value", line.value}, {"bar", line.bar}};
    object["build"] = build_line();
    fmt::print("{}\n", object.dump(2));
    return 0;
  }
  fmt::print(
      "{}  {} bodies, {} contacts, {:.1f} us a tick; root hash {:.2f} us, cells {:.2f} us, finite check {:.2f} us\n",
      options.scene, measured.body_count, measured.contact_count, measured.tick_us, measured.root_hash_us,
      measured.cells_us, measured.non_finite_us);
  for (const Line& line : lines)
    fmt::print("  {:<18}{:>10.4f}  {} (at most {:g})\n", line.name, line.value, line.unit, line.bar);
  return 0;
}

}  // namespace
}  // namespace ticktrue

int main(int argc, char** argv) {
  ticktrue::BenchOptions options;
  CLI::App app("What recording and verifying cost, and the bytes of a trace");
  app.add_option("--scene", options.scene, "Built-in scene, with parameters")->capture_default_str();
  app.add_option("--warmup", options.warmup, "Ticks before the first that is timed")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--ticks", options.tick_count, "Ticks that are timed")
      ->check(CLI::Range(10, 1'000'000))
      ->capture_default_str();
  app.add_option("--block", options.block_size, "Ticks between changes of turn")
      ->check(CLI::Range(1, 1'000))
      ->capture_default_str();
  app.add_option("--repeats", options.repeat_count, "Runs from the start")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_flag("--third", options.is_third, "Traces of format version 3");
  app.add_flag("--json", options.json, "One JSON object");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return ticktrue::run(options);
}
