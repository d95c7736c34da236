// Box2D 2.4.1 as a plug-in: a pyramid of boxes whose state can be observed, not restored.
// SPDX-License-Identifier: MIT
//
//   ticktrue record --plugin ./libplugin_box2d.so 10 --ticks 300 -o pyramid.ttr      10: the setup, boxes at the base
//   ticktrue verify --plugin ./libplugin_box2d.so pyramid.ttr
//
// Box2D shows poses and velocities and hides what it warm-starts with, so a trace proves what can be seen, and always
// from tick 0. Inputs: pairs of bytes, a body's number and an upward push in N s.
#include <box2d/box2d.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <vector>

#include "ticktrue.h"

namespace {

struct Seen {
  uint32_t id;
  float position[2];
  float angle;
  float velocity[2];
  float angular_velocity;
  uint8_t awake;
};

class Pyramid {
 public:
  explicit Pyramid(int base) {
    b2EdgeShape ground;
    ground.SetTwoSided({-50, 0}, {50, 0});
    b2BodyDef definition;
    world_.CreateBody(&definition)->CreateFixture(&ground, 0);
    b2PolygonShape box;
    box.SetAsBox(0.5F, 0.5F);
    definition.type = b2_dynamicBody;
    for (int row = 0; row < base; ++row)
      for (int i = 0; i < base - row; ++i) {
        definition.position.Set(1.125F * (static_cast<float>(i) - 0.5F * static_cast<float>(base - row)),
                                0.55F + 1.1F * static_cast<float>(row));
        bodies_.push_back(world_.CreateBody(&definition));
        bodies_.back()->CreateFixture(&box, 1);
      }
    look();
  }

  void step(float dt, const uint8_t* inputs, size_t size) {
    for (size_t i = 0; i + 1 < size; i += 2)
      bodies_[inputs[i] % bodies_.size()]->ApplyLinearImpulseToCenter({0, static_cast<float>(inputs[i + 1])}, true);
    world_.Step(dt, 8, 3);
    look();
  }

  void show(const ticktrue_host& host, ticktrue_columns* out) {
    const auto rows = static_cast<uint32_t>(seen_.size());
    Seen* first = seen_.data();
    host.column(out, "bodies", "id", &first->id, TICKTRUE_U32, 1, rows, sizeof(Seen));
    host.column(out, "bodies", "position", first->position, TICKTRUE_F32, 2, rows, sizeof(Seen));
    host.column(out, "bodies", "angle", &first->angle, TICKTRUE_F32, 1, rows, sizeof(Seen));
    host.column(out, "bodies", "velocity", first->velocity, TICKTRUE_F32, 2, rows, sizeof(Seen));
    host.column(out, "bodies", "angular_velocity", &first->angular_velocity, TICKTRUE_F32, 1, rows, sizeof(Seen));
    host.column(out, "bodies", "awake", &first->awake, TICKTRUE_U8, 1, rows, sizeof(Seen));
    host.key(out, "bodies", 1);
  }

 private:
  void look() {
    seen_.resize(bodies_.size());
    for (size_t i = 0; i < bodies_.size(); ++i) {
      const b2Body& body = *bodies_[i];
      const b2Vec2 velocity = body.GetLinearVelocity();
      seen_[i] = {static_cast<uint32_t>(i),  {body.GetPosition().x, body.GetPosition().y},
                  body.GetAngle(),           {velocity.x, velocity.y},
                  body.GetAngularVelocity(), static_cast<uint8_t>(body.IsAwake())};
    }
  }

  b2World world_{b2Vec2(0, -10)};
  std::vector<b2Body*> bodies_;
  std::vector<Seen> seen_;
};

Pyramid& pyramid(void* simulation) {
  return *static_cast<Pyramid*>(simulation);
}

int create(const ticktrue_host*, const void* setup, size_t size, void** simulation, char* text, size_t text_size) {
  const int base = std::atoi(std::string(static_cast<const char*>(setup), size < 8 ? size : 8).c_str());
  if (base < 1 || base > 40) {
    std::snprintf(text, text_size, "boxes at the base: expected 1..40");
    return 1;
  }
  *simulation = new (std::nothrow) Pyramid(base);
  return *simulation == nullptr;
}

}  // namespace

extern "C" const ticktrue_plugin* ticktrue_plugin_entry(uint32_t) {
  static const ticktrue_plugin plugin = [] {
    ticktrue_plugin made = {};
    made.struct_size = sizeof made;
    made.api_version = TICKTRUE_API_VERSION;
    made.version = 20401;
    made.name = "box2d-pyramid-example";
    made.create = create;
    made.destroy = [](void* simulation) { delete &pyramid(simulation); };
    made.columns = [](void* simulation, const ticktrue_host* host, ticktrue_columns* out) {
      pyramid(simulation).show(*host, out);
      return 0;
    };
    made.step = [](void* simulation, double dt, const void* inputs, size_t size, const ticktrue_host*, ticktrue_stages*,
                   char*, size_t) {
      pyramid(simulation).step(static_cast<float>(dt), static_cast<const uint8_t*>(inputs), size);
      return 0;
    };
    return made;
  }();
  return &plugin;
}
