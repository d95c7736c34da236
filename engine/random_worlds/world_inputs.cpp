// Inputs of random worlds: waking, pushing, aiming, teleporting, spawning, removing.
// SPDX-License-Identifier: MIT
#include "engine/math/trig.h"
#include "engine/random_worlds/world_builder.h"
#include "engine/scene/hull.h"
#include "engine/scene/scene_rules.h"

namespace ticktrue::engine {
namespace {

/// The values from which the values of an input are drawn.
struct InputContext {
  double size = 1;  // m
  double mass = 1;  // kg, of the body
  Point at;         // a place in the world
  Point velocity;   // towards another body, or zero
  Point gravity;
};

struct ValueMaker {
  std::string_view name;
  double (*make)(Draw& draw, const InputContext& context);
};
// Names of values in input_kinds. A value with another name is drawn from -2 to 2.
constexpr std::array<ValueMaker, 17> value_makers{{
    {"x", [](Draw&, const InputContext& c) { return c.at.x; }},
    {"y", [](Draw&, const InputContext& c) { return c.at.y; }},
    {"px", [](Draw& d, const InputContext& c) { return d.half() ? 0 : c.size * d.part(-2, 2, 4); }},
    {"py", [](Draw& d, const InputContext& c) { return d.half() ? 0 : c.size * d.part(-2, 2, 4); }},
    {"angle",
     [](Draw& d, const InputContext&) {
       return d.one_of({0, 0, 0, pi / 2, -pi / 2, pi, 0.25, 1});
     }},
    {"vx", [](Draw&, const InputContext& c) { return c.velocity.x; }},
    {"vy", [](Draw&, const InputContext& c) { return c.velocity.y; }},
    {"angular_velocity",
     [](Draw& d, const InputContext&) {
       return d.one_of({0, 0, 0, 0, 0.5, -4});
     }},
    {"gx", [](Draw&, const InputContext& c) { return c.gravity.x; }},
    {"gy", [](Draw&, const InputContext& c) { return c.gravity.y; }},
    {"ix", [](Draw&, const InputContext& c) { return c.mass * c.velocity.x; }},
    {"iy", [](Draw&, const InputContext& c) { return c.mass * c.velocity.y; }},
    {"fx", [](Draw& d, const InputContext& c) { return c.mass * c.velocity.x * d.between(1, 60); }},
    {"fy", [](Draw& d, const InputContext& c) { return c.mass * c.velocity.y * d.between(1, 60); }},
    {"torque", [](Draw& d, const InputContext& c) { return c.mass * c.size * c.size * d.part(-32, 32, 8); }},
    {"speed", [](Draw& d, const InputContext&) { return d.part(-16, 16, 4); }},
    {"force_max",
     [](Draw& d, const InputContext& c) {
       return c.mass * d.one_of({0, 1, 8, 64});
     }},
}};

double draw_value(Draw& draw, const InputContext& context, std::string_view name) {
  for (const ValueMaker& maker : value_makers)
    if (maker.name == name) return maker.make(draw, context);
  return draw.part(-8, 8, 4);
}

class InputMaker {
 public:
  InputMaker(Draw& draw, const WorldPlan& plan, Scene& scene) : draw_(draw), plan_(plan), scene_(scene) {
    for (std::uint32_t i = 0; i < scene.bodies.size(); ++i)
      if (const Body& body = scene.bodies[i]; body.type != BodyType::static_body) {
        movable_.push_back(i);
        if (body.velocity == Point{} && body.angular_velocity == 0) resting_.push_back(i);
      }
    for (std::uint32_t i = 0; i < scene.joints.size(); ++i)
      if (scene.joints[i].motor) motors_.push_back(i);
    next_id_ = static_cast<std::uint32_t>(scene.bodies.size());
    player_ = static_cast<std::uint8_t>(draw.chance(80) ? 0 : draw.between(1, 7));
  }

  std::vector<Input> run() {
    declare();
    for (const InputKind kind : scene_.inputs) add_script(kind);
    // From a few to many inputs: long quiet times, and bursts.
    const std::uint32_t more = draw_.below(1u << draw_.below(6)) + (plan_.is_quiet ? 3 : 0);
    if (!scene_.inputs.empty())
      for (std::uint32_t i = 0; i < more; ++i) add_script(draw_.any(scene_.inputs));
    if (plan_.shot_count > 0) add_shots();
    sort();
    name_issued_ids();
    if (plan_.has_end) {
      Input end;
      end.tick = plan_.tick_count;
      inputs_.push_back(end);
    }
    return std::move(inputs_);
  }

 private:
  bool takes(InputKind kind) const { return declares(scene_, kind); }

  void declare() {
    bool has_pointer = false;
    for (const InputKind kind : plan_.inputs) has_pointer = has_pointer || info_of(input_kinds, kind).is_of_pointer;
    for (const InputInfo& info : input_kinds) {
      bool wanted = info.is_of_pointer && has_pointer;
      for (const InputKind kind : plan_.inputs) wanted = wanted || kind == info.kind;
      if (info.has_joint && motors_.empty()) wanted = false;
      if (info.has_prototype && scene_.prototypes.empty()) wanted = false;
      if (wanted) scene_.inputs.push_back(info.kind);
    }
    if (!has_pointer) return;
    scene_.pointer.emplace();
    scene_.pointer->hertz = draw_.one_of({2, 5, 5, 15});
    if (draw_.half())
      for (const Body& prototype : scene_.prototypes) scene_.pointer->spawns.push_back(prototype.name);
  }

  /// Adds an input of a kind and its sequel: moved bodies stop, gravity is restored, pointers release.
  void add_script(InputKind kind) {
    const auto ticks = static_cast<std::uint32_t>(plan_.tick_count);
    tick_ = draw_.chance(10) ? 0 : draw_.below(ticks);
    if (plan_.has(WorldFeature::several_players)) player_ = static_cast<std::uint8_t>(draw_.below(4));
    body_ = draw_body();
    draw_context();
    if (kind == InputKind::remove && takes(InputKind::spawn) && plan_.has(WorldFeature::teleports) && draw_.chance(80))
      return teleport();
    if (info_of(input_kinds, kind).is_of_pointer) return use_pointer();
    const Body& body = scene_.bodies[body_ % scene_.bodies.size()];
    if (kind == InputKind::set_velocity && body.type == BodyType::static_body) return;  // refused
    add(kind);
    if (kind == InputKind::set_gravity && draw_.chance(60)) return restore_gravity();
    if (kind == InputKind::set_velocity && draw_.half()) return stop_and_return();
    if (kind == InputKind::force && draw_.half())
      for (int more = draw_.between(1, 10); more > 0; --more) {
        ++tick_;
        add(kind);
      }
  }

  std::uint32_t draw_body() {
    if (next_id_ > scene_.bodies.size() && draw_.chance(25))
      return static_cast<std::uint32_t>(scene_.bodies.size()) +
             draw_.below(next_id_ - static_cast<std::uint32_t>(scene_.bodies.size()));
    if (movable_.empty() || draw_.chance(3)) return draw_.below(static_cast<std::uint32_t>(scene_.bodies.size()));
    return !resting_.empty() && draw_.chance(plan_.is_quiet ? 80 : 40) ? draw_.any(resting_) : draw_.any(movable_);
  }

  static double distance_squared(Point a, Point b) { return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y); }

  /// A neighbour in the list, most often the nearer one. Neighbours in the list are neighbours in the world.
  const Body& neighbour_of(std::uint32_t body) {
    const auto count = static_cast<std::uint32_t>(scene_.bodies.size());
    const Body& before = scene_.bodies[(body + count - 1) % count];
    const Body& after = scene_.bodies[(body + 1) % count];
    const Point p = scene_.bodies[body].position;
    if (draw_.chance(60))
      return distance_squared(before.position, p) < distance_squared(after.position, p) ? before : after;
    const std::uint32_t step = draw_.chance(75) ? 1 : 1 + draw_.below(count);
    return scene_.bodies[(draw_.half() ? body + step : body + count - step % count) % count];
  }

  void draw_context() {
    const Body& body = scene_.bodies[body_ % scene_.bodies.size()];
    const Point p = body.position;
    const Point q = neighbour_of(body_ % static_cast<std::uint32_t>(scene_.bodies.size())).position;
    context_ = {};
    const double mass = body_mass(body).mass;
    if (mass > 0) context_.mass = mass;
    context_.size = (body.shapes[0].radius + body.shapes[0].half_size.x) * 2;
    if (context_.size == 0) context_.size = 0.5;
    context_.at = draw_.chance(30)
                      ? p
                      : Point{p.x + context_.size * draw_.part(-8, 8, 4), p.y + context_.size * draw_.part(-4, 16, 4)};
    if (draw_.chance(90)) context_.velocity = aim(p, q);
    context_.gravity = draw_gravity();
  }

  /// The velocity from p to q in a fraction of a second up to a few seconds.
  Point aim(Point p, Point q) {
    const double rate = draw_.one_of({0.0625, 0.5, 1, 2, 4, 8});
    Point v{(q.x - p.x) * rate, (q.y - p.y) * rate};
    if (v == Point{}) v = {draw_.half() ? 1.0 : -1.0, 0};
    const double most = draw_.chance(10) ? 200 : 20;
    while (v.x > most || v.x < -most || v.y > most || v.y < -most) v = {v.x / 4, v.y / 4};
    return v;
  }

  Point draw_gravity() {
    const Point own = plan_.gravity;
    switch (draw_.below(4)) {
      case 0:
        return {};
      case 1:
        return {-own.x, -own.y};
      case 2:
        return {own.y, own.x};
      default:
        return {draw_.part(-10, 10, 1), draw_.part(-10, 10, 1)};
    }
  }

  void add(InputKind kind) {
    if (tick_ >= plan_.tick_count) return;
    const InputInfo& info = info_of(input_kinds, kind);
    Input input;
    input.tick = tick_;
    input.player = player_;
    input.kind = kind;
    if (info.has_body) input.body = body_;
    if (info.has_prototype) {
      input.prototype = static_cast<std::uint16_t>(draw_.below(static_cast<std::uint32_t>(scene_.prototypes.size())));
      ++next_id_;
    }
    if (info.has_joint) {
      input.joint = draw_.any(motors_);
      context_.mass = body_mass(scene_.bodies[scene_.joints[input.joint].body_b]).mass;
    }
    for (std::size_t i = 0; i < info.value_count; ++i)
      input.values[i] = draw_value(draw_, context_, info.value_names[i]);
    inputs_.push_back(input);
  }

  void wait(int ticks_max) { tick_ += static_cast<std::uint64_t>(draw_.between(1, ticks_max)); }

  void teleport() {
    add(InputKind::remove);
    // Aims at another body's place, or beside it.
    const Body& other = neighbour_of(body_ % static_cast<std::uint32_t>(scene_.bodies.size()));
    context_.at = {other.position.x, other.position.y + context_.size * draw_.one_of({0, 1, 1.015625, 4})};
    if (draw_.half()) context_.velocity = {};
    add(InputKind::spawn);
  }

  void use_pointer() {
    const Body& body = scene_.bodies[body_ % scene_.bodies.size()];
    if (draw_.chance(80)) context_.at = body.position;
    add(InputKind::press);
    for (int steps = draw_.between(1, 6); steps > 0; --steps) {
      wait(8);
      context_.at.x += context_.size * draw_.part(-4, 4, 4);
      context_.at.y += context_.size * draw_.part(-2, 4, 4);
      add(InputKind::drag);
    }
    if (draw_.chance(20)) return;  // held to the end
    wait(20);
    add(InputKind::release);
  }

  void restore_gravity() {
    wait(40);
    context_.gravity = plan_.gravity;
    add(InputKind::set_gravity);
  }

  /// Stops the body, so that it rests again, and may send it back.
  void stop_and_return() {
    const Point there = context_.velocity;
    wait(20);
    context_.velocity = {};
    add(InputKind::set_velocity);
    if (draw_.half()) return;
    wait(40);
    context_.velocity = {-there.x, -there.y};
    add(InputKind::set_velocity);
  }

  /// Shoots each body of add_shots at its wall, or through it, within a few ticks.
  void add_shots() {
    const InputKind kind = takes(InputKind::set_velocity) ? InputKind::set_velocity : InputKind::impulse;
    for (std::uint32_t i = 0; i < scene_.bodies.size(); ++i) {
      const Body& body = scene_.bodies[i];
      if (body.name.rfind(shot_prefix, 0) != 0) continue;
      body_ = i;
      tick_ = 2 + draw_.below(static_cast<std::uint32_t>(plan_.tick_count));
      const double radius = body.shapes[0].radius;
      context_ = {};
      context_.size = 2 * radius;
      context_.mass = body_mass(body).mass;
      context_.velocity = {radius * draw_.one_of({64, 256, 1024}), 0};
      add(kind);
    }
  }

  /// Sorts by tick and player, stable, and numbers the inputs within both.
  void sort() {
    const auto before = [](const Input& a, const Input& b) {
      return a.tick != b.tick ? a.tick < b.tick : a.player < b.player;
    };
    for (std::size_t i = 1; i < inputs_.size(); ++i) {
      const Input input = inputs_[i];
      std::size_t place = i;
      for (; place > 0 && before(input, inputs_[place - 1]); --place) inputs_[place] = inputs_[place - 1];
      inputs_[place] = input;
    }
    for (std::size_t i = 1; i < inputs_.size(); ++i)
      if (!before(inputs_[i - 1], inputs_[i])) inputs_[i].sequence = inputs_[i - 1].sequence + 1;
  }

  /// Replaces ids, since an input may only name a body that an earlier tick has made.
  void name_issued_ids() {
    const auto first = static_cast<std::uint32_t>(scene_.bodies.size());
    std::uint32_t issued = 0, in_tick = 0;  // spawned in earlier ticks, and in this one
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      if (i > 0 && inputs_[i].tick != inputs_[i - 1].tick) {
        issued += in_tick;
        in_tick = 0;
      }
      const InputInfo& info = info_of(input_kinds, inputs_[i].kind);
      if (info.has_body && inputs_[i].body >= first)
        inputs_[i].body = issued > 0 ? first + inputs_[i].body % issued : movable_.empty() ? 0 : movable_[0];
      if (info.has_prototype) ++in_tick;
    }
  }

  Draw& draw_;
  const WorldPlan& plan_;
  Scene& scene_;
  std::vector<Input> inputs_;
  std::vector<std::uint32_t> movable_;  // bodies
  std::vector<std::uint32_t> resting_;  // bodies that do not move at the start
  std::vector<std::uint32_t> motors_;   // joints
  std::uint32_t next_id_ = 0;           // of the next spawned body, if only this class spawns
  std::uint64_t tick_ = 0;
  std::uint8_t player_ = 0;
  std::uint32_t body_ = 0;
  InputContext context_;
};

}  // namespace

std::vector<Input> add_inputs(Draw& draw, const WorldPlan& plan, Scene& scene) {
  return InputMaker(draw, plan, scene).run();
}

}  // namespace ticktrue::engine
