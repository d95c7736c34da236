// Small scenes that the studies build: parts, stacks, chains, pendulums.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/scene/scene.h"

namespace ticktrue::verifier::worlds {

engine::Shape box(double half_width, double half_height);
engine::Shape disc(double radius);
engine::Shape polygon(std::vector<engine::Point> vertices);
/// Regular, flat side down, circumradius `radius`. Requires: 3..16 corners.
engine::Shape regular(int corner_count, double radius);
/// From its centre to the middle of a side.
double apothem(int corner_count, double radius);

engine::Body body(engine::Shape shape, engine::Point position, engine::BodyType type = engine::BodyType::dynamic_body);
/// A body with this mass, and with this inertia if it is > 0.
engine::Body weighted(engine::Shape shape, engine::Point position, double mass, double inertia = 0);
/// A static box, 200 m wide, whose top is at y = 0.
engine::Body ground();
/// A static disc of 5 cm.
engine::Body peg(engine::Point position);

engine::Scene empty(engine::Precision precision);
/// Nothing collides; one disc of 1 kg, no gravity, one substep.
engine::Scene flight(engine::Precision precision, engine::Point position, engine::Point velocity);
void set_material(engine::Scene& scene, double friction, double restitution);
/// No two bodies of the scene meet.
void touch_nothing(engine::Scene& scene);
/// Every contact bounces with `restitution` at the moment of impact, without friction.
void set_bounces(engine::Scene& scene, double restitution);
/// Level ground under inclined gravity: a slope down to the right.
void lean(engine::Scene& scene, double degrees);

engine::Joint joint(engine::JointKind kind, std::uint32_t body_a, std::uint32_t body_b, engine::Point anchor_a = {},
                    engine::Point anchor_b = {});

/// Unit boxes upon the ground, the first at y = size / 2, alternately `jitter` m to either side.
engine::Scene stack(engine::Precision precision, int count, double size = 1, double jitter = 0);
/// Links of 1 m and 1 kg pinned end to end from a peg at the origin; `direction` of the chain; the last of `end_mass`.
engine::Scene chain(engine::Precision precision, int links, engine::Point direction, double end_mass);
/// Twenty links of 0.6 m and 1 kg between two pegs at a distance of 10 m, damped, in two straight lines.
engine::Scene catenary(engine::Precision precision);

}  // namespace ticktrue::verifier::worlds
