// Small scenes that the studies build: parts, stacks, chains, pendulums.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/scene/scene.h"

namespace ticktrue::worlds {

engine::Shape box(double half_width, double half_height);
engine::Shape disc(double radius);
engine::Shape polygon(std::vector<engine::Point> vertices);
/// A regular polygon, flat side down, of circumradius `radius`. Requires: 3..16 corners.
engine::Shape regular(int corner_count, double radius);
/// The distance from the centre of a regular polygon to the middle of a side.
double apothem(int corner_count, double radius);

engine::Body body(engine::Shape shape, engine::Point position, engine::BodyType type = engine::BodyType::dynamic_body);
/// A body with this mass, and with this inertia if inertia > 0.
engine::Body weighted(engine::Shape shape, engine::Point position, double mass, double inertia = 0);
/// A static box, 200 m wide, whose top is at y = 0.
engine::Body ground();
/// A static disc of 5 cm.
engine::Body peg(engine::Point position);

engine::Scene empty(engine::Precision precision);
/// Nothing collides; one disc of 1 kg, no gravity, one substep.
engine::Scene flight(engine::Precision precision, engine::Point position, engine::Point velocity);
void set_material(engine::Scene& scene, double friction, double restitution);
/// Lets no two bodies of the scene collide.
void touch_nothing(engine::Scene& scene);
/// Makes every contact bounce with `restitution` at the moment of impact, without friction.
void set_bounces(engine::Scene& scene, double restitution);
/// Inclines gravity over level ground: equals a slope down to the right.
void lean(engine::Scene& scene, double degrees);

engine::Joint joint(engine::JointKind kind, std::uint32_t body_a, std::uint32_t body_b, engine::Point anchor_a = {},
                    engine::Point anchor_b = {});

/// A gear between two joints of the scene.
engine::Joint gear(std::uint32_t joint_a, std::uint32_t joint_b, double ratio);

/// Boxes of `size` m on the ground, the first at y = size / 2, alternately shifted by `jitter` m to either side.
engine::Scene stack(engine::Precision precision, int count, double size = 1, double jitter = 0);
/// A chain of links of 1 m and 1 kg from a peg at the origin in `direction`, joined end to end by revolute joints. The
/// last link has `end_mass`.
engine::Scene chain(engine::Precision precision, int links, engine::Point direction, double end_mass);
/// Twenty links of 0.6 m and 1 kg between two pegs 10 m apart, with damping, in two straight lines.
engine::Scene catenary(engine::Precision precision);

}  // namespace ticktrue::worlds
