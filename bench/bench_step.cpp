// Time of a tick of a built-in scene, ours and Box2D's in turn in one process, under the same machine load.
// SPDX-License-Identifier: MIT
//
// Each repeat makes both worlds again and steps tick 0 untimed, since it builds what later ticks keep. Then both worlds
// take turns in blocks of ticks. A block's time divided by its ticks is one sample; median, least and quartiles are
// over all samples. Stages are timed in a separate run, so that reading the clock does not slow the compared runs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "base/build_info.h"
#include "base/hash.h"
#include "base/parallel/workers.h"
#include "base/state/state_view.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "tool/box2d/box2d_peer.h"

namespace ticktrue {
namespace {

using Json = nlohmann::ordered_json;

/// Seconds since a fixed time: of the wall clock, or of this thread's processor time, which other programs do not slow.
enum class ClockUsed { wall, thread_cpu };
double seconds_now(ClockUsed clock) {
#if defined(CLOCK_THREAD_CPUTIME_ID)
  if (clock == ClockUsed::thread_cpu) {
    struct timespec now {};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }
#endif
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct BenchOptions {
  std::string scene;
  ClockUsed clock = ClockUsed::wall;
  std::string clock_name = "wall";
  std::uint64_t tick_count = 500;
  std::uint64_t block_size = 10;  // ticks
  std::uint64_t repeat_count = 3;
  unsigned thread_count = 1;
  std::string pipeline = "composed";
  std::string peer;
  int velocity_iterations = tool::Box2dOptions{}.velocity_iterations;
  int position_iterations = tool::Box2dOptions{}.position_iterations;
  bool stages = false;
  bool json = false;
};

struct Times {
  double min_ms = 0;
  double median_ms = 0;
  double iqr_ms = 0;
};

// Requires: samples not empty.
Times times_of(std::vector<double> samples) {
  std::sort(samples.begin(), samples.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(samples.size() - 1);
    const std::size_t below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, samples.size() - 1);
    return samples[below] + (place - static_cast<double>(below)) * (samples[above] - samples[below]);
  };
  return {samples.front(), at(0.5), at(0.75) - at(0.25)};
}

// Milliseconds per tick, from a block of ticks.
template <typename Step>
double time_block(ClockUsed clock, std::uint64_t tick_count, Step step) {
  const double start = seconds_now(clock);
  for (std::uint64_t i = 0; i < tick_count; ++i) step();
  return 1e3 * (seconds_now(clock) - start) / static_cast<double>(tick_count);
}

struct StageTime {
  std::string name;
  double ms_per_tick = 0;  // mean
};

struct Measured {
  Times ours;
  Times peer;                     // zero without a peer
  std::vector<StageTime> stages;  // and the hash of the state; empty unless requested
  std::size_t state_size = 0;     // bytes
  std::size_t heap_size = 0;      // bytes that engine and state hold after the run; 0: unknown
  std::size_t body_count = 0;
  std::size_t contact_count = 0;
  std::size_t peer_contact_count = 0;
  std::uint64_t hash = 0;
};

std::size_t heap_in_use() {
#if defined(__GLIBC__)
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
#else
  return 0;
#endif
}

std::size_t state_size(const StateView& state) {
  std::size_t size = 0;
  for (std::size_t i = 0; i < state.tables.size(); ++i)
    size += state.tables[i].row_count * state.schema->tables[i].row_size;
  return size;
}

class StageClock final : public StageObserver {
 public:
  StageClock(ClockUsed clock, std::size_t stage_count) : clock_(clock), seconds_(stage_count) {}
  void start() { last_ = seconds_now(clock_); }
  void after_stage(std::size_t stage, const StateView&) override {
    seconds_[stage] += seconds_now(clock_) - last_;
    last_ = seconds_now(clock_);
  }
  double ms_per_tick(std::size_t stage, std::uint64_t tick_count) const {
    return 1e3 * seconds_[stage] / static_cast<double>(tick_count);
  }

 private:
  ClockUsed clock_;
  std::vector<double> seconds_;  // [stage]
  double last_ = 0;
};

engine::EngineOptions engine_options(const BenchOptions& options) {
  engine::EngineOptions result;
  result.full_pipeline = options.pipeline == "full";
  result.thread_count = options.thread_count;
  return result;
}

tool::Box2dOptions peer_options(const BenchOptions& options) {
  tool::Box2dOptions result;
  result.velocity_iterations = options.velocity_iterations;
  result.position_iterations = options.position_iterations;
  result.sleep = true;
  result.capsules_as_octagons = true;
  return result;
}

Result<std::vector<StageTime>> measure_stages(const engine::Scene& scene, const BenchOptions& options) {
  auto made = engine::make_engine(scene, engine_options(options));
  if (!made) return made.error();
  engine::Engine& engine = **made;
  const TickInput input{scene.settings.dt, {}};
  const std::uint64_t timed = options.tick_count - 1;
  StageClock clock(options.clock, engine.stage_names().size());
  double hashing = 0;  // s
  if (const Status did = engine.step(input, nullptr); !did) return did.error();
  for (std::uint64_t tick = 1; tick < options.tick_count; ++tick) {
    clock.start();
    if (const Status did = engine.step(input, &clock); !did) return did.error();
    const double before = seconds_now(options.clock);
    (void)root_hash(engine.state());
    hashing += seconds_now(options.clock) - before;
  }
  std::vector<StageTime> times;
  for (std::size_t i = 0; i < engine.stage_names().size(); ++i)
    times.push_back({engine.stage_names()[i], clock.ms_per_tick(i, timed)});
  times.push_back({"(root hash)", 1e3 * hashing / static_cast<double>(timed)});
  return times;
}

/// The opponent that takes turns with our engine.
struct Peer {
  std::unique_ptr<tool::Box2dPeer> box2d;
  std::unique_ptr<engine::Engine> one_thread;
  TickInput input;

  explicit operator bool() const { return box2d != nullptr || one_thread != nullptr; }
  Status step() {
    if (box2d != nullptr) box2d->step();
    return one_thread != nullptr ? one_thread->step(input, nullptr) : Status();
  }
  std::size_t contact_count() const {
    return box2d != nullptr ? box2d->contact_count() : one_thread->contacts().size();
  }
};

constexpr const char* one_thread_peer = "one_thread";

Result<Peer> make_peer(const engine::Scene& scene, const BenchOptions& options) {
  Peer peer{nullptr, nullptr, {scene.settings.dt, {}}};
  if (options.peer == one_thread_peer) {
    engine::EngineOptions own = engine_options(options);
    own.thread_count = 1;
    auto made = engine::make_engine(scene, own);
    if (!made) return made.error();
    peer.one_thread = std::move(*made);
  } else if (!options.peer.empty()) {
    auto made = tool::make_box2d_peer(scene, peer_options(options));
    if (!made) return made.error();
    peer.box2d = std::move(*made);
  }
  return peer;
}

Result<Measured> measure(const engine::Scene& scene, const BenchOptions& options) {
  Measured measured;
  std::vector<double> ours;
  std::vector<double> peers;
  const TickInput input{scene.settings.dt, {}};
  for (std::uint64_t repeat = 0; repeat < options.repeat_count; ++repeat) {
    Result<Peer> peer_made = make_peer(scene, options);
    if (!peer_made) return peer_made.error();
    Peer& peer = *peer_made;
    const std::size_t heap_before = heap_in_use();
    auto made = engine::make_engine(scene, engine_options(options));
    if (!made) return made.error();
    engine::Engine& engine = **made;
    if (Status accepted = engine.accept(input); !accepted) return accepted.error();
    Status did = engine.step(input, nullptr);
    Status peer_did = peer.step();
    for (std::uint64_t tick = 1; tick < options.tick_count && did && peer_did;) {
      const std::uint64_t block = std::min(options.block_size, options.tick_count - tick);
      ours.push_back(time_block(options.clock, block, [&] { did = engine.step(input, nullptr); }));
      if (peer) peers.push_back(time_block(options.clock, block, [&] { peer_did = peer.step(); }));
      tick += block;
    }
    // Failed ticks cost no time. After an error, each further step returns the same error.
    if (!did) return did.error();
    if (!peer_did) return peer_did.error();
    const std::uint64_t hash = root_hash(engine.state());
    if (peer.one_thread != nullptr && root_hash(peer.one_thread->state()) != hash)
      return Error{ErrorCode::incompatible, scene.name + ": one thread and several give different states",
                   "verify a trace of the scene with --mode threads"};
    if (repeat > 0 && hash != measured.hash)
      return Error{
          ErrorCode::incompatible,
          fmt::format("{}: two runs differ: found hash {}, expected {}", scene.name, hex64(hash), hex64(measured.hash)),
          "record and verify the scene with --mode twice"};
    measured.hash = hash;
    measured.state_size = state_size(engine.state());
    // The peer allocates, too. Without a peer, the difference is the engine's memory.
    if (!peer) measured.heap_size = heap_in_use() - heap_before;
    measured.body_count = engine.bodies().size();
    measured.contact_count = engine.contacts().size();
    if (peer) measured.peer_contact_count = peer.contact_count();
  }
  measured.ours = times_of(std::move(ours));
  if (!peers.empty()) measured.peer = times_of(std::move(peers));
  if (options.stages) {
    Result<std::vector<StageTime>> stages = measure_stages(scene, options);
    if (!stages) return stages.error();
    measured.stages = std::move(*stages);
  }
  return measured;
}

Json times_json(const Times& times) {
  return {{"min", times.min_ms}, {"median", times.median_ms}, {"iqr", times.iqr_ms}};
}

std::string peer_settings(const engine::Scene& scene, const BenchOptions& options) {
  bool has_capsules = false;
  for (const engine::Body& body : scene.bodies)
    for (const engine::Shape& shape : body.shapes)
      has_capsules = has_capsules || shape.kind == engine::ShapeKind::capsule;
  return fmt::format("{}/{} iterations, dt {:g} s, warm starting, {}{}{}", options.velocity_iterations,
                     options.position_iterations, scene.settings.dt, scene.settings.sleep ? "sleeping" : "no sleeping",
                     scene.settings.continuous ? "" : ", no continuous collision",
                     has_capsules ? ", capsules as octagons" : "");
}

double per_body(std::size_t size, const Measured& measured) {
  return static_cast<double>(size) / static_cast<double>(std::max<std::size_t>(measured.body_count, 1));
}

Json report_json(const engine::Scene& scene, const BenchOptions& options, const Measured& measured) {
  Json object;
  object["schema"] = "ticktrue.bench_step/1";
  object["scene"] = options.scene;
  object["ticks"] = options.tick_count;
  object["repeats"] = options.repeat_count;
  object["threads"] = options.thread_count;
  object["pipeline"] = options.pipeline;
  object["clock"] = options.clock_name;
  object["precision"] = engine::info_of(engine::precisions, scene.settings.precision).name;
  object["solver"] = engine::info_of(engine::solvers, scene.settings.solver).name;
  object["substeps"] = scene.settings.substeps;
  object["ms_per_tick"] = times_json(measured.ours);
  if (options.peer.empty()) {
    object["peer"] = nullptr;
    object["ratio"] = nullptr;
  } else if (options.peer == one_thread_peer) {
    object["peer"] = {{"name", "one thread"}, {"ms_per_tick", times_json(measured.peer)}};
    object["ratio"] = measured.peer.median_ms / measured.ours.median_ms;
  } else {
    object["peer"] = {{"name", "Box2D"},
                      {"version", tool::box2d_version()},
                      {"settings", peer_settings(scene, options)},
                      {"ms_per_tick", times_json(measured.peer)},
                      {"contacts", measured.peer_contact_count}};
    object["ratio"] = measured.peer.median_ms / measured.ours.median_ms;
  }
  object["bodies"] = measured.body_count;
  object["contacts"] = measured.contact_count;
  object["ns_per_body"] = 1e6 * measured.ours.median_ms * per_body(1, measured);
  object["state_bytes"] = measured.state_size;
  object["heap_bytes"] = measured.heap_size > 0 ? Json(measured.heap_size) : Json(nullptr);
  if (!measured.stages.empty()) {
    object["stages"] = Json::array();
    for (const StageTime& stage : measured.stages)
      object["stages"].push_back({{"name", stage.name}, {"ms_per_tick", stage.ms_per_tick}});
  }
  object["hash"] = hex64(measured.hash);
  object["build"] = build_line();
  return object;
}

std::string report_text(const engine::Scene& scene, const BenchOptions& options, const Measured& measured) {
  std::string text =
      fmt::format("{}  {} ticks, {} repeats, {} bodies, {} contacts, {} {}, {} substeps, {} pipeline, hash {}\n",
                  options.scene, options.tick_count, options.repeat_count, measured.body_count, measured.contact_count,
                  engine::info_of(engine::precisions, scene.settings.precision).name,
                  engine::info_of(engine::solvers, scene.settings.solver).name, scene.settings.substeps,
                  options.pipeline, hex64(measured.hash));
  const auto line = [](const std::string& name, const Times& times) {
    return fmt::format("  {:<14}{:>10.4f}{:>10.4f}{:>10.4f}\n", name, times.min_ms, times.median_ms, times.iqr_ms);
  };
  text += fmt::format("  {:<14}{:>10}{:>10}{:>10}\n", "ms per tick", "min", "median", "iqr");
  text += line("ticktrue", measured.ours);
  for (const StageTime& stage : measured.stages)
    text += fmt::format("    {:<22}{:>10.4f} mean\n", stage.name, stage.ms_per_tick);
  text += fmt::format("  {:.1f} ns per body; state {:.0f} B per body",
                      1e6 * measured.ours.median_ms * per_body(1, measured), per_body(measured.state_size, measured));
  if (measured.heap_size > 0) text += fmt::format(", heap {:.0f} B per body", per_body(measured.heap_size, measured));
  text += "\n";
  if (options.peer == one_thread_peer) {
    text += line("one thread", measured.peer);
    text += fmt::format("  {:.2f} times as fast as one thread (least times: {:.2f})\n",
                        measured.peer.median_ms / measured.ours.median_ms, measured.peer.min_ms / measured.ours.min_ms);
  } else if (!options.peer.empty()) {
    text += line("Box2D " + tool::box2d_version(), measured.peer);
    text += fmt::format("  {:.2f} times as fast as Box2D {} ({})\n", measured.peer.median_ms / measured.ours.median_ms,
                        tool::box2d_version(), peer_settings(scene, options));
  }
  return text;
}

int fail(const Error& error) {
  std::fprintf(stderr, "bench_step: error: %s\n", error.message.c_str());
  if (!error.hint.empty()) std::fprintf(stderr, "  %s\n", error.hint.c_str());
  return 2;
}

int run(const BenchOptions& options) {
  Result<engine::Scene> scene = engine::make_builtin_scene(options.scene);
  if (!scene) return fail(scene.error());
  const Result<Measured> measured = measure(*scene, options);
  if (!measured) return fail(measured.error());
  const std::string text =
      options.json ? report_json(*scene, options, *measured).dump(2) + "\n" : report_text(*scene, options, *measured);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return 0;
}

}  // namespace
}  // namespace ticktrue

int main(int argc, char** argv) {
  ticktrue::BenchOptions options;
  CLI::App app("Time of a tick of a built-in scene, ours and Box2D's in turns");
  app.add_option("--scene", options.scene, "Built-in scene, with parameters: large_pyramid, stack?boxes=20")
      ->required();
  app.add_option("--ticks", options.tick_count, "Ticks of a run; the first is not timed")
      ->check(CLI::Range(2, 1'000'000))
      ->capture_default_str();
  app.add_option("--block", options.block_size, "Ticks between changes of turn")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--repeats", options.repeat_count, "Runs from the start")
      ->check(CLI::Range(1, 1'000))
      ->capture_default_str();
  app.add_option("--threads", options.thread_count, "Threads of a tick; of the peer one")
      ->check(CLI::Range(1u, ticktrue::thread_count_max))
      ->capture_default_str();
  app.add_option("--clock", options.clock_name, "Time that passes, or that this thread has a core for: one thread only")
      ->check(CLI::IsMember({"wall", "cpu"}))
      ->capture_default_str();
  app.add_option("--pipeline", options.pipeline, "Only the stages the scene needs, or all")
      ->check(CLI::IsMember({"composed", "full"}))
      ->capture_default_str();
  app.add_option("--peer", options.peer, "Compare with another engine, or with this one on one thread")
      ->check(CLI::IsMember({"box2d", ticktrue::one_thread_peer}));
  app.add_option("--velocity-iterations", options.velocity_iterations, "Of the peer")
      ->check(CLI::Range(1, 1'000))
      ->capture_default_str();
  app.add_option("--position-iterations", options.position_iterations, "Of the peer")
      ->check(CLI::Range(1, 1'000))
      ->capture_default_str();
  app.add_flag("--stages", options.stages, "Time the stages too, in one more run");
  app.add_flag("--json", options.json, "One JSON object");
  std::string instruction_set;
  app.add_option("--isa", instruction_set, "Instruction set of the kernels: baseline, avx2");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (!instruction_set.empty())
    if (const ticktrue::Status status = ticktrue::engine::use_instruction_set(instruction_set); !status)
      return ticktrue::fail(status.error());
  if (options.clock_name == "cpu") options.clock = ticktrue::ClockUsed::thread_cpu;
  return ticktrue::run(options);
}
