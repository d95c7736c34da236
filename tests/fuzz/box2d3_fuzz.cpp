// Fuzzes the answer of the program that runs Box2D 3: what is read is what was planned, within the scene's limits.
// SPDX-License-Identifier: MIT
#include <cmath>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/fuzz/support/fuzz.h"
#include "tool/box2d3/box2d3_answer.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ticktrue;
  static const engine::Scene scene = *engine::make_builtin_scene("stack?boxes=3");
  tool::Box2d3Plan plan;
  plan.tick_count = 4;
  plan.body_interval = 2;
  plan.contact_window = 1;
  const auto answer = tool::read_box2d3_answer(fuzz::text_of({data, size}), scene, plan);
  if (!answer) {
    fuzz::require_message(answer.error());
    return 0;
  }
  fuzz::require(answer->package.size() <= 100, "a version is short");
  fuzz::require(answer->ticks.size() == 2, "there are as many ticks as planned");
  fuzz::require(answer->clamped_tick <= plan.tick_count, "what was cut was cut in the run");
  fuzz::require(answer->ms_per_tick >= 0 && std::isfinite(answer->ms_per_tick), "a time is a time");
  fuzz::require(answer->ticks[0].contacts.empty(), "contacts are reported where they are planned");
  for (const tool::Box2d3Tick& tick : answer->ticks) {
    std::uint32_t next = 0;
    for (const tool::Box2d3Body& body : tick.bodies) {
      fuzz::require(body.id >= next && body.id < scene.bodies.size(), "bodies ascend and are of the scene");
      fuzz::require(scene.bodies[body.id].type != engine::BodyType::static_body, "a static body does not move");
      next = body.id + 1;
      for (const double number :
           {body.origin.x, body.origin.y, body.cosine, body.sine, body.velocity.x, body.velocity.y, body.spin})
        fuzz::require(std::isfinite(number), "numbers of bodies are finite");
    }
    for (const tool::Box2d3Contact& contact : tick.contacts) {
      fuzz::require(contact.body_a < scene.bodies.size() && contact.body_b < scene.bodies.size(), "bodies touch");
      fuzz::require(contact.point_count == 1 || contact.point_count == 2, "a pair has one point or two");
      for (int i = 0; i < contact.point_count; ++i)
        for (const double number : {contact.point[i].x, contact.point[i].y, contact.separation[i], contact.force[i]})
          fuzz::require(std::isfinite(number), "numbers of contacts are finite");
    }
  }
  return 0;
}
