// Parts that all stress cases share: setting up a scene by a method, running it, and measuring displacements.
// SPDX-License-Identifier: MIT
#include "tool/study/stress/stress_parts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace ticktrue::tool {

using engine::BodyType;
using engine::Engine;
using engine::Scene;

std::vector<StressCase> stress_cases() {
  std::vector<StressCase> cases;
  add_contact_cases(cases);
  add_small_and_far_cases(cases);
  add_load_cases(cases);
  add_joint_cases(cases);
  add_arm_cases(cases);
  add_floating_cases(cases);
  add_scheme_cases(cases);
  add_motion_cases(cases);
  add_claims(cases);
  return cases;
}

Scene with_method(Scene scene, const StressMethod& method) {
  scene.settings.solver = method.solver;
  scene.settings.integrator = method.integrator;
  const bool has_substeps = engine::info_of(engine::solvers, method.solver).substeps;
  if (method.automatic)
    engine::choose_substeps(scene.settings);
  else if (scene.settings.auto_substeps || !has_substeps)
    engine::use_fixed_substeps(scene.settings, has_substeps ? engine::Settings{}.substeps : 1);
  if (method.joins_direct) scene.settings.joints = engine::JointSolverKind::direct;
  if (!has_substeps) scene.settings.locate_impacts = false;
  return scene;
}

StressValue run_case(const Scene& scene, double seconds, const std::function<bool(const Bodies&)>& watch,
                     const std::function<double(const Engine&, const Bodies&, const Bodies&)>& finish,
                     const InputsOfTick& inputs) {
  StressValue out;
  out.ran_in = scene.settings.precision;
  Result<Run> run = Run::make(scene);
  if (!run) {
    out.why_not = run.error().message;
    return out;
  }
  const Bodies start = run->bodies();
  const auto tick_count = static_cast<std::uint64_t>(std::lround(seconds / scene.settings.dt));
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    Bytes bytes;
    if (inputs) engine::encode_inputs(inputs(tick), bytes);
    if (const auto did = run->step({scene.settings.dt, bytes}); !did) {
      out.why_undone = did.error().message;
      return out;
    }
    if (!watch && tick + 1 < tick_count && tick % 60 != 59) continue;
    const Bodies bodies = run->bodies();
    if (!all_finite(bodies)) {
      out.is_finite = false;
      out.value = std::nan("");
      return out;
    }
    if (watch && !watch(bodies)) break;
  }
  out.value = finish(run->engine(), start, run->bodies());
  out.is_finite = std::isfinite(out.value);
  return out;
}

StressValue worst_gap(const Scene& scene, double seconds, double settle, double size) {
  double most = 0, time = 0;
  return run_case(
      scene, seconds,
      [&](const Bodies& bodies) {
        time += scene.settings.dt;
        if (time >= settle) most = std::max(most, largest(joint_gaps(scene, bodies)));
        return true;
      },
      [&](const Engine&, const Bodies&, const Bodies&) { return most / size; });
}

StressCase make_case(std::string name, std::string what, std::string unit, double lower, double upper,
                     std::vector<StressMethod> methods) {
  StressCase out;
  out.name = std::move(name);
  out.what = std::move(what);
  out.unit = std::move(unit);
  out.lower = lower;
  out.upper = upper;
  out.methods = std::move(methods);
  return out;
}

double moved_share(const Bodies& start, const Bodies& end, double across_max, double down_max) {
  double share = start.size() == end.size() ? 0 : HUGE_VAL;
  for (std::size_t i = 0; i < std::min(start.size(), end.size()); ++i) {
    if (start[i].type != BodyType::dynamic_body) continue;
    share = std::max(share, std::fabs(end[i].center.x - start[i].center.x) / across_max);
    share = std::max(share, std::fabs(end[i].center.y - start[i].center.y) / down_max);
  }
  return share;
}

std::string plain_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

}  // namespace ticktrue::tool
