// Integrators against closed forms: order of convergence, stability limit, rest on the ground.
// SPDX-License-Identifier: MIT
//
// Verified: the order of every integrator on six problems; its stability limit on an undamped oscillator; rest of a box
// with each integrator that supports constraints.
// Not verified: orders with contacts (1 for every scheme, at the time of impact).
//
// The error is the root mean square of the position over 20 equally spaced sample times. The order is the slope of its
// logarithm over three halvings of the step (accuracy anchors, section 4). Steps are large enough that rounding does
// not matter.
#define TICKTRUE_PRECISION f64
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/engine.h"
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"
#include "engine/islands/solver_sets.h"
#include "engine/math/trig.h"
#include "engine/model/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/scenes.h"
#include "tool/study/closed_forms.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::Force;
using engine::ForceKind;
using engine::IntegratorInfo;
using engine::IntegratorKind;

namespace {

constexpr int sample_count = 20;

/// A coordinate over time, simulated and exact.
struct Problem {
  std::string name;
  double duration;   // s
  int step_count_0;  // steps of the coarsest run, a multiple of sample_count
  Scene scene;
  std::function<Point(double)> exact;
  bool is_pendulum = false;  // the angle of body 0 under theta'' = -g sin theta
};

Scene one_disc(Point position, Point velocity) {
  Scene scene = flight_scene(Precision::f64, body_of(disc_shape(0.1), position));
  scene.bodies[0].velocity = velocity;
  scene.bodies[0].mass = engine::ExplicitMass{1, {}, {}};
  scene.gravity = {0, 0};
  return scene;
}

Force smooth_force(ForceKind kind) {
  Force force;
  force.kind = kind;
  return force;
}

/// A spring of relaxed length 5 m from the origin of the disc to (-5, 0). Its force on the x axis is k x.
Force spring_along_x(double stiffness, double damping) {
  Force force = smooth_force(ForceKind::spring);
  force.body = 0;
  force.point = {-5, 0};
  force.rest_length = 5;
  force.stiffness = stiffness;
  force.damping = damping;
  return force;
}

Problem free_fall() {
  Problem problem{"free fall", 2, 80, one_disc({0, 0}, {3, 7}), [](double t) {
                    return Point{3 * t, 7 * t - 5 * t * t};
                  }};
  problem.scene.gravity = {0, -10};
  return problem;
}

Problem linear_drag() {
  Problem problem{"linear drag", 2, 80, one_disc({0, 0}, {10, 10}), [](double t) {
                    const double gone = 1 - std::exp(-0.5 * t);
                    return Point{20 * gone, -20 * t + 60 * gone};
                  }};
  problem.scene.gravity = {0, -10};
  problem.scene.forces.push_back(smooth_force(ForceKind::linear_drag));
  problem.scene.forces[0].coefficient = 0.5;
  return problem;
}

Problem oscillator() {
  Problem problem{"oscillator", 2, 480, one_disc({1, 0}, {0, 0}), [](double t) { return Point{std::cos(10 * t), 0}; }};
  problem.scene.forces.push_back(spring_along_x(100, 0));
  return problem;
}

Problem damped_oscillator() {
  Problem problem{"damped oscillator", 2, 480, one_disc({1, 0}, {0, 0}), [](double t) {
                    const double w = 10 * std::sqrt(0.99);
                    return Point{std::exp(-t) * (std::cos(w * t) + std::sin(w * t) / w), 0};
                  }};
  problem.scene.forces.push_back(spring_along_x(100, 2));
  return problem;
}

/// theta'' = -10 sin theta from 60 degrees.
Problem pendulum() {
  Problem problem{"pendulum", 2, 240, one_disc({0, 0}, {0, 0}), [](double t) {
                    return Point{tool::pendulum_angle(engine::pi / 3, std::sqrt(10.0), t), 0};
                  }};
  problem.scene.bodies[0].angle = engine::pi / 3;
  problem.is_pendulum = true;
  return problem;
}

Point kepler_at(double t) {
  const double e = 0.3;
  double anomaly = t;
  for (int i = 0; i < 50; ++i) anomaly -= (anomaly - e * std::sin(anomaly) - t) / (1 - e * std::cos(anomaly));
  return {std::cos(anomaly) - e, std::sqrt(1 - e * e) * std::sin(anomaly)};
}

Problem kepler() {
  Problem problem{"kepler", 2 * engine::pi, 480, one_disc({0.7, 0}, {0, std::sqrt(1.3 / 0.7)}), kepler_at};
  problem.scene.forces.push_back(smooth_force(ForceKind::central));
  problem.scene.forces[0].coefficient = 1;
  problem.scene.forces[0].exponent = -2;
  return problem;
}

std::vector<Problem> problems() {
  return {free_fall(), linear_drag(), oscillator(), damped_oscillator(), pendulum(), kepler()};
}

/// The forces of the test's pendulum: theta'' = -10 sin theta of the body's own angle.
void pendulum_forces(const engine::f64::SolvedSet& solved, engine::f64::MotionWorkspace& work) {
  for (std::size_t row = 0; row < solved.state.bodies.size(); ++row) {
    const engine::f64::Rotation turned = solved.bodies.records[row].delta_rotation * solved.state.bodies[row].rotation;
    work.accelerations[row].angular -= 10 * turned.s;
  }
}

/// Runs the engine's schemes with a model of the test, so that forces beyond those of scenes are possible.
class Stepper {
 public:
  Stepper(const Problem& problem, IntegratorKind kind) : scheme_(engine::f64::integrator(kind)) {
    Scene scene = problem.scene;
    scene.settings.integrator = kind;
    const Status status = engine::check_scene(scene, "test");
    INFO((status ? "" : status.error().message));
    REQUIRE(status.has_value());
    model_ = engine::f64::make_model(scene);
    if (problem.is_pendulum) model_.position_forces = pendulum_forces;
    state_ = engine::f64::initial_state(model_);
  }
  void step(double h) {
    engine::f64::prepare_bodies(model_, state_, tick_, bodies_);
    engine::f64::begin_motion(state_, work_);
    engine::f64::put_all_into_one_set(model_, state_, bodies_, tick_);
    const engine::f64::SolvedSet solved = engine::f64::enter_solver_set(model_, state_, tick_, bodies_, 0, h);
    scheme_.begin(solved, work_, h);
    scheme_.predict(solved, work_, h);
    scheme_.drift(solved, work_, h);
    engine::f64::store_bodies(model_, bodies_, tick_, state_);
    engine::f64::store_motion(work_, state_);
  }
  const engine::f64::BodyRow& body() const { return state_.bodies[0]; }
  std::uint32_t unconverged() const { return state_.integrator.unconverged; }

 private:
  const engine::f64::Integrator& scheme_;
  engine::f64::Model model_;
  engine::f64::State state_;
  engine::f64::TickLists tick_;
  engine::f64::SolverBodies bodies_;
  engine::f64::MotionWorkspace work_;
};

double rms_error(const Problem& problem, IntegratorKind kind, int step_count) {
  Stepper stepper(problem, kind);
  REQUIRE(step_count % sample_count == 0);
  const double h = problem.duration / step_count;
  double sum = 0;
  for (int sample = 1; sample <= sample_count; ++sample) {
    for (int i = 0; i < step_count / sample_count; ++i) stepper.step(h);
    const Point exact = problem.exact(problem.duration * sample / sample_count);
    const engine::f64::BodyRow& body = stepper.body();
    const double dx = problem.is_pendulum ? engine::arc_tangent(body.rotation.s, body.rotation.c) - exact.x
                                          : body.position.x - exact.x;
    const double dy = problem.is_pendulum ? 0 : body.position.y - exact.y;
    sum += dx * dx + dy * dy;
  }
  CHECK(stepper.unconverged() == 0);
  return std::sqrt(sum / sample_count);
}

/// Whether the theory gives the exact path at the sample times: constant forces, and a scheme of order 2 or more.
bool is_exact(const Problem& problem, const IntegratorInfo& info) {
  return problem.name == "free fall" && info.order >= 2;
}

/// Amplitude of an oscillator of w = 1 after many steps of length w h, at most 1e6.
double amplitude_after(IntegratorKind kind, double wh, int step_count) {
  Problem problem{"", 0, 0, one_disc({1, 0}, {0, 0}), {}};
  problem.scene.forces.push_back(spring_along_x(1, 0));
  // The spring has 1 N/m, the body 1 kg. The far end is so distant that the spring never changes its direction.
  problem.scene.forces[0].point = {-1e6, 0};
  problem.scene.forces[0].rest_length = 1e6;
  Stepper stepper(problem, kind);
  double largest = 0;
  for (int i = 0; i < step_count && largest < 1e5; ++i) {
    stepper.step(wh);
    largest = std::fmax(largest, std::fabs(stepper.body().position.x));
  }
  return largest;
}

}  // namespace

TEST_CASE("every integrator converges with its order on every smooth problem", "[engine][integrators][analytic]") {
  for (const Problem& problem : problems()) {
    for (const IntegratorInfo& info : engine::integrators) {
      CAPTURE(problem.name, info.name);
      // Schemes of order 4 soon reach rounding, so they start from longer steps.
      const int base = info.order == 4 ? problem.step_count_0 / 2 : problem.step_count_0;
      if (is_exact(problem, info)) {
        CHECK(rms_error(problem, info.kind, base) < 1e-12);
        continue;
      }
      double error = rms_error(problem, info.kind, base);
      for (int halving = 1; halving <= 3; ++halving) {
        const double finer = rms_error(problem, info.kind, base << halving);
        CAPTURE(halving, error, finer);
        CHECK(std::fabs(std::log2(error / finer) - info.order) < 0.15);
        error = finer;
      }
    }
  }
}

TEST_CASE("every integrator is stable exactly up to its limit", "[engine][integrators][analytic]") {
  for (const IntegratorInfo& info : engine::integrators) {
    CAPTURE(info.name);
    if (info.stability_limit == 0) {
      // A step multiplies the amplitude by sqrt(1 + w^2 h^2), and in thesis_rk4 by sqrt(1 + w^2 h^2 / 2): by 12 after
      // 4000 steps.
      CHECK(amplitude_after(info.kind, 0.05, 4000) > 12);
      continue;
    }
    if (info.stability_limit == engine::always_stable) {
      for (const double wh : {1.0, 10.0, 1000.0}) CHECK(amplitude_after(info.kind, wh, 2000) < 1.001);
      continue;
    }
    double stable = 0.5, unstable = 4;
    while (unstable - stable > 0.001) {
      const double middle = (stable + unstable) / 2;
      (amplitude_after(info.kind, middle, 20000) < 1000 ? stable : unstable) = middle;
    }
    CHECK(std::fabs(stable - info.stability_limit) < 0.01 * info.stability_limit);
  }
}

TEST_CASE("under every integrator that carries constraints boxes rest on each other",
          "[engine][integrators][contacts]") {
  for (const IntegratorInfo& info : engine::integrators) {
    for (const int count : {1, 3, 10}) {
      CAPTURE(info.name, count);
      Scene scene = stack_scene(count, 0.02);
      scene.settings.integrator = info.kind;
      const auto made = engine::make_engine(scene);
      CHECK(made.has_value() == info.carries_constraints);
      if (!made) {
        CHECK(made.error().code == ErrorCode::incompatible);
        CHECK(made.error().message.find(std::string(info.why_free)) != std::string::npos);
        CHECK(made.error().hint.find("velocity_verlet") != std::string::npos);
        continue;
      }
      const auto run = [&](int tick_count) {
        for (int tick = 0; tick < tick_count; ++tick) REQUIRE((*made)->step({scene.settings.dt, {}}, nullptr));
        return (*made)->bodies();
      };
      const double h = scene.settings.dt / scene.settings.substeps;
      const auto before = run(900);
      const auto after = run(300);
      for (std::size_t i = 1; i < after.size(); ++i) {
        CAPTURE(i, after[i].velocity.x, after[i].velocity.y, after[i].center.x, after[i].center.y);
        CHECK(std::fabs(after[i].velocity.y) <= 10 * h / 2);
        // Only soft contacts yield. The stack creeps by at most a tenth of the slop in five seconds.
        CHECK(std::fabs(after[i].center.y - before[i].center.y) < 5e-4);
        CHECK(std::fabs(after[i].center.y - (static_cast<double>(i) - 0.5)) < 0.001 * count * count + 0.005);
        if (info.kind != IntegratorKind::explicit_euler || count < 10)
          CHECK(std::fabs(after[i].center.x - before[i].center.x) < 5e-4);
      }
    }
  }
}

TEST_CASE("an impact lets no body in deeper than its slop, under every integrator", "[engine][integrators][contacts]") {
  for (const IntegratorInfo& info : engine::integrators) {
    if (!info.carries_constraints) continue;
    CAPTURE(info.name);
    Scene scene = stack_scene(1, 0.05);  // 1 m/s: less than the speculative margin per tick
    scene.settings.integrator = info.kind;
    const auto made = engine::make_engine(scene);
    REQUIRE(made.has_value());
    double lowest = 10;
    for (int tick = 0; tick < 240; ++tick) {
      REQUIRE((*made)->step({scene.settings.dt, {}}, nullptr));
      lowest = std::fmin(lowest, (*made)->bodies()[1].center.y);
    }
    CHECK(lowest > 0.495);
    CHECK((*made)->bodies()[1].center.y < 0.501);
  }
}

TEST_CASE("a sliding box stops at v^2 / (2 mu g), less what the integrator's order leaves",
          "[engine][integrators][contacts][analytic]") {
  for (const IntegratorInfo& info : engine::integrators) {
    if (!info.carries_constraints) continue;
    CAPTURE(info.name);
    Scene scene = slide_scene(10, 0.5);
    scene.settings.integrator = info.kind;
    const auto made = engine::make_engine(scene);
    REQUIRE(made.has_value());
    for (int tick = 0; tick < 240; ++tick) REQUIRE((*made)->step({scene.settings.dt, {}}, nullptr));
    const double h = scene.settings.dt / scene.settings.substeps;
    // Braking at the start of each step stops v h / 2 too early, braking at its end v h / 2 too late. The mean velocity
    // stops in the right place.
    CHECK(std::fabs((*made)->bodies()[1].center.x - 10) < 1.1 * 10 * h / 2);
  }
}

TEST_CASE("no spin turns a body into something that is no number", "[engine][integrators][property]") {
  for (const engine::Precision precision : {engine::Precision::f32, engine::Precision::f64})
    for (const IntegratorInfo& info : engine::integrators)
      for (const int body_count : {1, 9})  // alone, and in lanes
        for (const double speed : {1e7, 1.95e8, 2.5e8, 1e9, 1e12}) {
          CAPTURE(info.name, body_count, speed);
          Scene scene = empty_scene(precision);
          scene.gravity = {0, 0};
          scene.inputs = {engine::InputKind::torque};
          scene.settings.integrator = info.kind;
          constexpr double inertia = 1e-6;  // kg m^2
          for (int i = 0; i < body_count; ++i) {
            scene.bodies.push_back(body_of(disc_shape(0.5), {4.0 * i, 0}));
            scene.bodies.back().mass = engine::ExplicitMass{1, inertia, {}};
            scene.bodies.back().shapes[0].filter.mask = 0;
          }
          const auto made = engine::make_engine(scene);
          REQUIRE(made.has_value());
          std::vector<engine::Input> inputs;
          for (int i = 0; i < body_count; ++i) {
            engine::Input input;
            input.kind = engine::InputKind::torque;
            input.body = static_cast<std::uint32_t>(i);
            input.sequence = input.body;
            input.values[0] = (i % 2 == 0 ? speed : -speed) * inertia / scene.settings.dt;
            inputs.push_back(input);
          }
          Bytes bytes;
          engine::encode_inputs(inputs, bytes);
          for (int tick = 0; tick < 4; ++tick) {
            const TickInput input{scene.settings.dt, tick == 0 ? ByteView(bytes) : ByteView()};
            const Status accepted = (*made)->accept(input);
            INFO((accepted ? std::string() : accepted.error().message));
            REQUIRE(accepted);
            REQUIRE((*made)->step(input, nullptr));
            CHECK(!find_non_finite((*made)->state()).has_value());
          }
        }
}
