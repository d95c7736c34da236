// Runs a scene in this engine and answers as peer.mjs does: engine_run SCENE.json TICKS INTERVAL WARM_UP.
// SPDX-License-Identifier: MIT
//
// `ticktrue accuracy --engine` runs it as WebAssembly beside Box2D 3 (docs/study.md, "Beside Box2D"). INTERVAL: bodies
// are reported after each tick that is a multiple. WARM_UP 1: the scene runs once before, so that node has compiled all
// that is timed. Exit code 2: a wrong argument or scene; 1: the run failed.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <string>

#ifdef __EMSCRIPTEN__
#include <emscripten.h>
#endif

#include "base/build_info.h"
#include "engine/engine.h"
#include "engine/math/trig.h"
#include "engine/scene/scene_json.h"

namespace ticktrue {
namespace {

struct EngineRun {
  std::uint64_t tick_count = 0;
  std::uint64_t interval = 1;
};

int complain(const Error& error, int code) {
  std::fprintf(stderr, "engine_run: error: %s\n", error.message.c_str());
  return code;
}

// Velocities as the lines have them: of a kinematic body that of its origin.
void print_bodies(std::uint64_t tick, const std::vector<engine::BodyReport>& bodies) {
  std::printf("{\"tick\":%llu,\"bodies\":[", static_cast<unsigned long long>(tick));
  const char* comma = "";
  for (const engine::BodyReport& body : bodies) {
    if (body.type == engine::BodyType::static_body) continue;
    const engine::SinCos turn = engine::sin_cos(body.angle);
    engine::Point velocity = body.velocity;
    if (body.type == engine::BodyType::kinematic_body) {
      velocity.x += body.angular_velocity * (body.center.y - body.origin.y);
      velocity.y -= body.angular_velocity * (body.center.x - body.origin.x);
    }
    std::printf("%s%u,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", comma, body.id, body.origin.x, body.origin.y, turn.cos,
                turn.sin, velocity.x, velocity.y, body.angular_velocity);
    comma = ",";
  }
  std::printf("]}\n");
}

// Processor time of this process, as peer.mjs takes it. In WebAssembly clock() is that on the wall.
double processor_ms() {
#ifdef __EMSCRIPTEN__
  return EM_ASM_DOUBLE({
    const used = process.cpuUsage();
    return (used.user + used.system) / 1000;
  });
#else
  return static_cast<double>(std::clock()) * 1e3 / CLOCKS_PER_SEC;
#endif
}

// Returns the milliseconds of the steps alone.
Result<double> run_scene(const engine::Scene& scene, const EngineRun& run, bool report) {
  auto engine = engine::make_engine(scene);
  if (!engine) return engine.error();
  const TickInput input{scene.settings.dt, {}};
  double time_ms = 0;
  for (std::uint64_t tick = 1; tick <= run.tick_count; ++tick) {
    const double start = processor_ms();
    const Status did = (*engine)->step(input, nullptr);
    time_ms += processor_ms() - start;
    if (!did) return did.error();
    if (report && tick % run.interval == 0) print_bodies(tick, (*engine)->bodies());
  }
  return time_ms;
}

int engine_run(int argc, char** argv) {
  EngineRun run;
  if (argc == 5) {
    run.tick_count = std::strtoull(argv[2], nullptr, 10);
    run.interval = std::strtoull(argv[3], nullptr, 10);
  }
  if (run.tick_count == 0 || run.interval == 0) {
    std::fprintf(stderr, "usage: engine_run SCENE.json TICKS INTERVAL WARM_UP\n");
    return 2;
  }
  std::ifstream file(argv[1], std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const Result<engine::Scene> scene = engine::parse_scene(text, argv[1]);
  if (!scene) return complain(scene.error(), 2);
  if (std::string(argv[4]) == "1")
    if (const Result<double> warmed = run_scene(*scene, run, false); !warmed) return complain(warmed.error(), 1);
  std::printf("{\"schema\":\"ticktrue.box2d3/1\",\"package\":\"ticktrue %s\"}\n", build_info().version.c_str());
  const Result<double> time_ms = run_scene(*scene, run, true);
  if (!time_ms) return complain(time_ms.error(), 1);
  std::printf("{\"done\":true,\"clamped_tick\":0,\"ms_per_tick\":%.9g}\n",
              *time_ms / static_cast<double>(run.tick_count));
  return 0;
}

}  // namespace
}  // namespace ticktrue

int main(int argc, char** argv) {
  return ticktrue::engine_run(argc, argv);
}
