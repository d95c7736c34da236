// Narrow phase: contact points of two convex shapes that touch or will touch soon.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/margins.h"
#include "engine/model/model.h"
#include "engine/model/stage.h"
#include "engine/model/tick_lists.h"
#include "engine/narrow_phase/contact_caches.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The stage that turns pairs into contacts.
class NarrowPhase final : public Stage {
 public:
  void run(const Model& model, State& state, TickLists& tick, Real dt) override;
  void list_caches(std::vector<TickCache*>& caches) override;
  void poison() override { list_fields(work_, Poison{}); }

 private:
  ManifoldCache manifolds_;
  ContactPlaces places_;
  PairBlocks blocks_;
  NarrowPhaseWork work_;
};

/// The pose of A's frame in the world, or of B's frame in A's.
struct Placement {
  Vec2 position;
  Rotation rotation;
};

/// Contact points of two shapes, in A's frame: anchors from A's origin, `anchor_b` not filled in. The normal points
/// from A to B. No points if the shapes are farther apart than `margin`. Requires: the kinds in the function's name.
using CollideFunction = Manifold (*)(const Model& model, const ShapeModel& a, const ShapeModel& b,
                                     const Placement& b_in_a, Real margin);
/// The direction in which two circles in one point part: that between the seeds of a sunflower with the numbers of
/// their bodies' ids. With one direction for all, many circles in one point would part as a row, which takes as long as
/// it is. Source: Vogel, "A better way to construct the sunflower head", 1979, equation 1.
Vec2 parting_direction(std::uint32_t id_a, std::uint32_t id_b);
Manifold collide_circles(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                         Real margin);
Manifold collide_polygon_circle(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                                Real margin);
Manifold collide_circle_polygon(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                                Real margin);
/// The same for a polygon that moves: it may lie on a large circle with an edge, in two points. A polygon that does not
/// move keeps one, about which the circle rolls.
Manifold collide_polygon_on_circle(const Model& model, const ShapeModel& a, const ShapeModel& b,
                                   const Placement& b_in_a, Real margin);
Manifold collide_circle_under_polygon(const Model& model, const ShapeModel& a, const ShapeModel& b,
                                      const Placement& b_in_a, Real margin);
Manifold collide_polygons(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                          Real margin);

/// A: a hull with a radius; B: a circle.
Manifold collide_round_circle(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                              Real margin);
/// Two hulls, with or without radius.
Manifold collide_rounds(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                        Real margin);
/// A: an edge of a chain. B: a circle, or a hull with or without radius.
Manifold collide_chain_circle(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                              Real margin);
Manifold collide_chain_hull(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                            Real margin);

/// The manifold of two shapes of two bodies, in world axes, with anchors from each centre of mass.
/// `gravity_displacement`: gravity_displacement_of_tick. `reach`: by which the margin is larger, m.
Manifold collide(const Model& model, const ShapeModel& a, const ShapeModel& b, const BodyRow& body_a,
                 const BodyRow& body_b, Real gravity_displacement, Real reach = 0);

/// A normal of a chain edge.
struct EdgeNormal {
  bool is_allowed;  // the normal is the edge's own, or one of a convex corner or free end
  bool in_front;    // the centre of the other shape is on the right side of the edge
  bool is_owned;    // false: of the convex corner at which the edge before ends, to which it belongs
  Vec2 normal;      // the allowed normal, or the edge's own
};
/// `normal` from the edge, `center` of the other shape, both in the frame of the edge's body.
EdgeNormal edge_normal(const Model& model, const ShapeModel& edge, Vec2 normal, Vec2 center);

/// Whether the shape of a body at `row` contains the world point. Segments and chains contain none.
bool contains(const Model& model, const ShapeModel& shape, const BodyRow& row, Vec2 point);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
