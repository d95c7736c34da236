// Contacts of a body that has more contacts than a colour pass has colours.
// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

namespace ticktrue::test {
namespace {

constexpr double hub_radius = 10;
constexpr double rim_radius = 0.2;

/// A disc, without gravity, and discs around it that just touch it. One of these discs overlaps it by 5 cm.
Scene hub(int rim_count, int pressing, BodyType rim_type, Precision precision) {
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  scene.bodies.push_back(body_of(disc_shape(hub_radius), {0, 0}));
  for (int i = 0; i < rim_count; ++i) {
    const double angle = 2 * std::numbers::pi * i / rim_count;
    const double distance = hub_radius + rim_radius - (i == pressing ? 0.05 : 0.0001);
    scene.bodies.push_back(
        body_of(disc_shape(rim_radius), {distance * std::cos(angle), distance * std::sin(angle)}, rim_type));
  }
  return scene;
}

}  // namespace

TEST_CASE("each contact of a body is solved however many it has", "[engine][contacts][determinism]") {
  // A colour pass has 32 colours for contacts between moving bodies, and 32 for contacts with a body that does not
  // move.
  for (const int rim_count : {31, 32, 33, 34, 63, 64, 65, 66, 97})
    for (const BodyType rim_type : {BodyType::static_body, BodyType::dynamic_body})
      for (const auto& precision : engine::precisions)
        for (const auto& solver : engine::solvers) {
          if (!solver.reads_contacts) continue;
          for (const int pressing : {0, 1, rim_count - 2, rim_count - 1}) {
            CAPTURE(rim_count, rim_type, precision.name, solver.name, pressing);
            Scene scene = hub(rim_count, pressing, rim_type, precision.kind);
            scene.settings.solver = solver.kind;
            if (!solver.substeps) scene.settings.substeps = 1;
            const auto engine = make_engine_or_fail(scene);
            REQUIRE(engine->step({scene.settings.dt, {}}, nullptr));
            // The contact has a force, or has separated the discs.
            bool is_solved = false;
            for (const engine::ContactReport& contact : engine->contacts())
              if (contact.body_b == static_cast<std::uint32_t>(pressing + 1))
                is_solved = contact.normal_force[0] > 0 || contact.separation[0] > -0.0499;
            CHECK(is_solved);
          }
        }
}

}  // namespace ticktrue::test
