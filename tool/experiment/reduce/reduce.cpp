// The steps of a reduction.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/reduce.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "engine/engine.h"
#include "tool/experiment/ddmin.h"
#include "tool/experiment/reduce/neighbourhood.h"
#include "tool/experiment/reduce/start_state.h"
#include "tool/experiment/shrink.h"

namespace ticktrue::reduce {
namespace {

using engine::Engine;
using engine::Point;
using soak::CaseInputs;
using soak::ddmin;
using Indices = std::vector<std::size_t>;

constexpr int round_count_max = 4;
// Extra ticks: a world with a later start or fewer bodies may fail a little later.
constexpr std::uint64_t spare_ticks = 8;
// The numbers of single bodies are only simplified in small worlds.
constexpr std::size_t simple_body_count_max = 16;

class Reducer {
 public:
  Reducer(const SoakCase& session, Predicate& predicate, const ReduceOptions& options)
      : session_(session), predicate_(predicate), options_(options) {}

  Result<ReduceResult> run() {
    ++run_count_;
    auto first = predicate_.examine(session_);
    if (!first) return first.error();
    if (!*first)
      return Error{ErrorCode::usage,
                   "reduce: the session does not fail: found nothing in " + std::to_string(session_.tick_count) +
                       " ticks, expected a failure",
                   "the session, the option and the build must be those of the failure"};
    first_ = last_ = **first;
    end_at_failure(session_);
    std::size_t size = 0;
    for (int round = 0; round < round_count_max && size != size_of(session_) && !is_over(); ++round) {
      size = size_of(session_);
      begin_later();
      keep_neighbours();
      keep_groups();
      shrink_rest();
      remove_shapes();
      close_gaps();
    }
    simplify_numbers();
    return ReduceResult{std::move(session_), std::move(first_), std::move(last_), cut_tick_, run_count_, ended_early_};
  }

 private:
  static std::size_t size_of(const SoakCase& session) {
    const engine::Scene& scene = session.scene;
    std::size_t size = session.inputs.size() + scene.joints.size() + scene.forces.size() + scene.prototypes.size() +
                       static_cast<std::size_t>(session.tick_count);
    for (const engine::Body& body : scene.bodies) size += 1 + body.shapes.size();
    return size;
  }

  bool is_over() {
    if (options_.run_count_max != 0 && run_count_ >= options_.run_count_max) ended_early_ = true;
    if (!ended_early_ && options_.stops && options_.stops()) ended_early_ = true;
    return ended_early_;
  }

  /// The failure of a candidate, if it is the same failure.
  std::optional<Failure> same_failure(const SoakCase& candidate) {
    if (is_over() || candidate.tick_count == 0 || !engine::check_scene(candidate.scene, "reduce")) return std::nullopt;
    ++run_count_;
    if (options_.progress) options_.progress(run_count_, session_);
    auto found = predicate_.examine(candidate);
    if (!found || !*found || !is_same(first_, **found, options_.is_loose)) return std::nullopt;
    return *std::move(*found);
  }

  bool take_if_same(SoakCase candidate) {
    const std::optional<Failure> found = same_failure(candidate);
    if (!found) return false;
    last_ = *found;
    session_ = std::move(candidate);
    end_at_failure(session_);
    return true;
  }

  /// Removes the ticks and inputs after the failure.
  void end_at_failure(SoakCase& session) const {
    session.tick_count = std::min(session.tick_count, last_.tick + 1);
    std::erase_if(session.inputs, [&](const engine::Input& input) { return input.tick >= session.tick_count; });
  }

  /// Calls `look` with the engine before each tick, up to the tick of the failure.
  void walk(const std::function<void(const Engine& engine)>& look) const {
    const auto made = options_.make(session_.scene, {});
    if (!made) return;
    const CaseInputs inputs(session_);
    for (std::uint64_t tick = 0; tick <= last_.tick; ++tick) {
      look(**made);
      const TickInput input = inputs.at(tick);
      if (!(*made)->accept(input) || !(*made)->step(input, nullptr)) return;
    }
  }

  /// Tries the states 0, 1, 3, 7, ... ticks before the failure as a later start.
  void begin_later() {
    if (predicate_.is_of_outcome()) return;
    const std::uint64_t failed = last_.tick;
    std::vector<std::pair<std::uint64_t, SoakCase>> later;
    walk([&](const Engine& engine) {
      const std::uint64_t before = failed - engine.tick() + 1;
      if (engine.tick() > 0 && (before & (before - 1)) == 0)
        later.emplace_back(engine.tick(), begin_at_state(session_, engine));
    });
    for (auto at = later.rbegin(); at != later.rend(); ++at) {
      at->second.tick_count += spare_ticks;
      if (!take_if_same(std::move(at->second))) continue;
      cut_tick_ += at->first;
      return;
    }
  }

  /// Keeps the affected bodies and 0, 1, 3, 7, ... of their nearest bodies.
  void keep_neighbours() {
    Indices order;
    walk([&](const Engine& engine) {
      if (engine.tick() == last_.tick) order = by_nearness(engine, last_.bodies);
    });
    for (std::size_t count = 1; count < order.size(); count *= 2)
      if (take_if_same(with_only(Indices(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count))))) return;
  }

  SoakCase with_only(Indices bodies) const {
    std::sort(bodies.begin(), bodies.end());
    SoakCase some = soak::with_bodies(session_, bodies);
    if (!predicate_.is_of_outcome()) some.tick_count += spare_ticks;
    return some;
  }

  /// Delta debugging over connected groups of moving bodies. Static bodies are always kept.
  void keep_groups() {
    constexpr std::size_t few = 16;
    if (session_.scene.bodies.size() <= few) return;
    std::vector<Indices> groups;
    walk([&](const Engine& engine) {
      if (engine.tick() == last_.tick) groups = connected_groups(engine);
    });
    if (groups.size() < 2) return;
    const SoakCase before = session_;
    const auto bodies_of = [&](const Indices& some) {
      Indices bodies;
      for (std::size_t i = 0; i < before.scene.bodies.size(); ++i)
        if (before.scene.bodies[i].type == engine::BodyType::static_body) bodies.push_back(i);
      for (const std::size_t group : some) bodies.insert(bodies.end(), groups[group].begin(), groups[group].end());
      std::sort(bodies.begin(), bodies.end());
      return bodies;
    };
    const Indices left = ddmin(groups.size(), [&](const Indices& some) {
      return same_failure(soak::with_bodies(before, bodies_of(some))).has_value();
    });
    if (left.size() < groups.size()) take_if_same(soak::with_bodies(before, bodies_of(left)));
  }

  void shrink_rest() {
    soak::ShrinkOptions options;
    options.test_count_max = std::numeric_limits<std::size_t>::max();
    options.is_over = [&] { return is_over(); };
    options.keeps_method = !options_.any_method;
    options.keeps_course = predicate_.is_of_outcome();
    SoakCase smallest =
        shrink(
            session_, [&](const SoakCase& candidate) { return same_failure(candidate).has_value(); }, options)
            .smallest;
    const bool was_over = std::exchange(ended_early_, false);  // the result found before the end is kept
    take_found(std::move(smallest));
    ended_early_ = ended_early_ || was_over;
  }

  /// Takes a session that fails in the same way, and reads the tick of its failure.
  void take_found(SoakCase found) {
    ++run_count_;
    auto failure = predicate_.examine(found);
    if (!failure || !*failure || !is_same(first_, **failure, options_.is_loose)) return;
    last_ = **failure;
    session_ = std::move(found);
    end_at_failure(session_);
  }

  void remove_shapes() {
    for (std::size_t body = 0; body < session_.scene.bodies.size(); ++body) {
      const SoakCase before = session_;
      const auto with_shapes = [&](const Indices& some) {
        SoakCase fewer = before;
        std::vector<engine::Shape>& shapes = fewer.scene.bodies[body].shapes;
        shapes.clear();
        for (const std::size_t shape : some) shapes.push_back(before.scene.bodies[body].shapes[shape]);
        return fewer;
      };
      const std::size_t count = before.scene.bodies[body].shapes.size();
      if (count < 2) continue;
      const Indices left =
          ddmin(count, [&](const Indices& some) { return same_failure(with_shapes(some)).has_value(); });
      if (left.size() < count) take_if_same(with_shapes(left));
    }
  }

  /// Moves inputs to earlier ticks. For each input, the input and all later ones move by the gap before it, or by half
  /// of the gap, and so on.
  void close_gaps() {
    for (std::size_t i = 0; i < session_.inputs.size(); ++i) {
      const std::uint64_t before = i == 0 ? 0 : session_.inputs[i - 1].tick + 1;
      if (session_.inputs[i].tick <= before) continue;
      for (std::uint64_t step = session_.inputs[i].tick - before; step > 0; step /= 2)
        if (take_if_same(moved_earlier(i, step))) break;
    }
  }

  SoakCase moved_earlier(std::size_t first, std::uint64_t step) const {
    SoakCase moved = session_;
    for (std::size_t i = first; i < moved.inputs.size(); ++i) moved.inputs[i].tick -= step;
    return moved;
  }

  void simplify_numbers() {
    if (session_.scene.bodies.size() > simple_body_count_max) return;
    for (std::size_t i = 0; i < session_.scene.bodies.size(); ++i)
      for (const auto change : simplifications) {
        SoakCase simpler = session_;
        change(simpler.scene.bodies[i]);
        if (!(simpler.scene == session_.scene)) take_if_same(std::move(simpler));
      }
  }

  static double rounded(double value) {
    constexpr double parts = 64;  // multiples of 1/64 are exact in f32
    return std::round(value * parts) / parts;
  }
  static Point rounded(const Point& point) { return {rounded(point.x), rounded(point.y)}; }
  using Simplification = void (*)(engine::Body& body);
  static constexpr Simplification simplifications[] = {
      [](engine::Body& body) { body.angular_velocity = 0; },
      [](engine::Body& body) { body.velocity = {}; },
      [](engine::Body& body) { body.angle = 0; },
      [](engine::Body& body) { body.position = rounded(body.position); },
      [](engine::Body& body) { body.velocity = rounded(body.velocity); },
      [](engine::Body& body) { body.angle = rounded(body.angle); },
      [](engine::Body& body) { body.angular_velocity = rounded(body.angular_velocity); },
  };

  SoakCase session_;
  Predicate& predicate_;
  const ReduceOptions& options_;
  Failure first_;
  Failure last_;
  std::uint64_t cut_tick_ = 0;
  std::size_t run_count_ = 0;
  bool ended_early_ = false;
};

}  // namespace

Result<ReduceResult> reduce(const SoakCase& session, Predicate& predicate, const ReduceOptions& options) {
  return Reducer(session, predicate, options).run();
}

}  // namespace ticktrue::reduce
