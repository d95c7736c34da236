// Arrangements of bodies in random worlds: resting, gliding, spinning, approaching, colliding.
// SPDX-License-Identifier: MIT
//
// Most arrangements are lattices with a rule for the motion of bodies. Errors of caches hide where unmoved bodies are
// beside moving bodies and are touched later. Distances are therefore chosen around those at which pairs begin.
#include "engine/math/trig.h"
#include "engine/random_worlds/world_builder.h"

namespace ticktrue::engine {
namespace {

struct Lattice {
  Point corner;
  std::uint32_t count;
  std::uint32_t columns;
  Point pitch;  // in sizes
};

/// The motion of the i-th body of a lattice; `base` is drawn once for the lattice.
struct Motion {
  Point velocity;
  double angular_velocity = 0;
};
using MotionRule = Motion (*)(WorldBuilder& builder, const Motion& base, std::uint32_t column, std::uint32_t row);

Motion rest(WorldBuilder&, const Motion&, std::uint32_t, std::uint32_t) {
  return {};
}

Motion glide(WorldBuilder&, const Motion& base, std::uint32_t, std::uint32_t) {
  return {base.velocity, 0};
}

Motion spin(WorldBuilder&, const Motion& base, std::uint32_t column, std::uint32_t row) {
  return {{}, (column + row) % 2 == 0 ? base.angular_velocity : -base.angular_velocity};
}

Motion integrate_freely(WorldBuilder& builder, const Motion& base, std::uint32_t, std::uint32_t) {
  const double speed = builder.size * 2;
  Motion motion;
  motion.velocity = {speed * builder.draw.part(-8, 8, 4), speed * builder.draw.part(-8, 8, 4)};
  if (builder.draw.half()) motion.angular_velocity = base.angular_velocity;
  return motion;
}

/// Columns approach each other with exactly opposite velocities.
Motion meet(WorldBuilder&, const Motion& base, std::uint32_t column, std::uint32_t) {
  const double sign = column % 2 == 0 ? 1 : -1;
  return {{sign * base.velocity.x, sign * base.velocity.y}, sign * base.angular_velocity};
}

/// The first body of each row moves, the others rest.
Motion strike(WorldBuilder&, const Motion& base, std::uint32_t column, std::uint32_t) {
  return column == 0 ? base : Motion{};
}

/// Half of the bodies rest, the others glide with the same velocity.
Motion mix_rest_and_glide(WorldBuilder&, const Motion& base, std::uint32_t column, std::uint32_t row) {
  return (column + row) % 2 == 0 ? Motion{} : Motion{base.velocity, 0};
}

/// Rows rest and glide in turn: some neighbours never move relative to each other, others do.
Motion glide_in_rows(WorldBuilder&, const Motion& base, std::uint32_t, std::uint32_t row) {
  return row % 2 == 0 ? Motion{} : Motion{base.velocity, 0};
}

Motion draw_base(WorldBuilder& builder) {
  Draw& draw = builder.draw;
  // From speeds that leave a margin at once to speeds that stay within it for hundreds of ticks.
  const double speed = builder.size * draw.one_of({0.000244140625, 0.00390625, 0.03125, 0.25, 0.5, 1, 2, 4, 16});
  Motion base;
  switch (draw.below(3)) {
    case 0:
      base.velocity = {draw.half() ? speed : -speed, 0};
      break;
    case 1:
      base.velocity = {0, draw.half() ? speed : -speed};
      break;
    default:
      base.velocity = {draw.half() ? speed : -speed, draw.half() ? speed : -speed};
      break;
  }
  base.angular_velocity = draw.one_of({0, 0, 0.0078125, 0.5, -2, 8});
  return base;
}

/// `exact`: all shapes are discs or squares of exactly the size.
void add_lattice(WorldBuilder& builder, const Lattice& lattice, MotionRule rule, bool is_jittered,
                 std::optional<ShapeKind> exact) {
  const Motion base = draw_base(builder);
  const double angle = builder.draw.chance(15) ? builder.draw.part(-8, 8, 8) : 0;
  for (std::uint32_t i = 0; i < lattice.count; ++i) {
    const std::uint32_t column = i % lattice.columns;
    const std::uint32_t row = i / lattice.columns;
    Placement placement;
    placement.position = {lattice.corner.x + builder.size * (lattice.pitch.x * column + 0.5),
                          lattice.corner.y + builder.size * (lattice.pitch.y * row + 0.5)};
    if (is_jittered) {
      placement.position.x += builder.size * builder.draw.part(-8, 8, 128);
      placement.angle = builder.draw.part(-8, 8, 64);
    }
    if (angle != 0) placement.angle = angle;
    const Motion motion = rule(builder, base, column, row);
    placement.velocity = motion.velocity;
    placement.angular_velocity = motion.angular_velocity;
    if (exact)
      builder.add_exact(placement, builder.size, *exact);
    else
      builder.add(placement, builder.size);
  }
}

struct LatticeKind {
  MotionRule rule;
  int weight;
};
constexpr std::array<LatticeKind, 8> lattice_kinds{{
    {rest, 6},
    {glide, 3},
    {spin, 1},
    {integrate_freely, 4},
    {meet, 3},
    {strike, 3},
    {mix_rest_and_glide, 2},
    {glide_in_rows, 2},
}};

MotionRule draw_rule(Draw& draw) {
  int sum = 0;
  for (const LatticeKind& kind : lattice_kinds) sum += kind.weight;
  int at = draw.between(0, sum - 1);
  for (const LatticeKind& kind : lattice_kinds) {
    if (at < kind.weight) return kind.rule;
    at -= kind.weight;
  }
  return rest;
}

/// The pitch, in sizes: overlapping, touching exactly, within margins, apart.
double draw_pitch(Draw& draw) {
  return draw.one_of({0.96875, 1, 1, 1, 1.00390625, 1.015625, 1.0625, 1.25, 1.5, 2, 4});
}

double arrange_lattice(WorldBuilder& builder, Point corner, std::uint32_t count) {
  Draw& draw = builder.draw;
  Lattice lattice{corner, count, 1, {}};
  const bool is_pile = draw.half();  // as high as wide; otherwise a few rows
  while (is_pile ? lattice.columns * lattice.columns < count : 2 * lattice.columns < count) ++lattice.columns;
  if (draw.chance(15)) lattice.columns = count;
  if (draw.chance(10)) lattice.columns = 1;
  lattice.pitch = {draw_pitch(draw), draw_pitch(draw)};
  const MotionRule rule = draw_rule(draw);
  const bool is_jittered = draw.chance(25);
  std::optional<ShapeKind> exact;
  if (draw.chance(40)) exact = builder.draw_exact_kind();
  add_lattice(builder, lattice, rule, is_jittered, exact);
  return builder.size * (lattice.pitch.x * (lattice.columns - 1) + 1);
}

/// Diagonal neighbours whose boxes overlap while the shapes do not touch.
double arrange_diagonal(WorldBuilder& builder, Point corner, std::uint32_t count) {
  Draw& draw = builder.draw;
  const double pitch = draw.one_of({0.75, 0.875, 0.9375, 1, 1.03125});
  const std::uint32_t pair_count = (count + 1) / 2;
  std::uint32_t columns = 1;
  while (columns * columns < pair_count) ++columns;
  const double apart = draw.one_of({1, 1.5, 3});
  const MotionRule rule = draw.half() ? rest : draw_rule(draw);
  const Motion base = draw_base(builder);
  const double size = builder.size;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t column = i / 2 % columns, row = i / 2 / columns;
    const double shift = i % 2 == 0 ? 0 : pitch;
    const Motion motion = rule(builder, base, column, row);
    const Point position{corner.x + size * ((1 + apart + pitch) * column + shift + 0.5),
                         corner.y + size * ((1 + apart + pitch) * row + shift + 0.5)};
    builder.add({position, 0, motion.velocity, motion.angular_velocity}, size);
  }
  return size * (1 + apart + pitch) * columns;
}

/// Large bodies among small ones.
double arrange_sizes(WorldBuilder& builder, Point corner, std::uint32_t count) {
  Draw& draw = builder.draw;
  const bool is_extreme = builder.plan.has(WorldFeature::size_ratio);
  const double large = builder.size * (is_extreme ? draw.one_of({16, 64, 128}) : draw.one_of({2, 4, 8}));
  const double small = is_extreme ? builder.size / 8 : builder.size;
  const Motion base = draw_base(builder);
  const bool is_static = draw.chance(30);
  Placement placement{{corner.x + large / 2, corner.y + large / 2}, 0, {}, 0};
  if (is_static && !is_extreme)
    builder.add_static(placement.position, make_shape(draw, ShapeKind::circle, large));
  else
    builder.add(placement, large);
  for (std::uint32_t i = 1; i < count; ++i) {
    placement.position = {corner.x + large + small * (0.5 + i), corner.y + small / 2};
    placement.velocity = draw.half() ? base.velocity : Point{};
    builder.add(placement, small);
  }
  return large + small * (count + 1);
}

/// Bodies at the same place, or almost.
double arrange_coincident(WorldBuilder& builder, Point corner, std::uint32_t count) {
  const double offset = builder.draw.one_of({0, 0, 0.0009765625, 0.125});
  const std::uint32_t group = 2 + builder.draw.below(3);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t place = i / group;
    const double x = builder.size * (0.5 + 2.0 * place + offset * (i % group));
    builder.add({{corner.x + x, corner.y + builder.size / 2}, 0, {}, 0}, builder.size);
  }
  const std::uint32_t place_count = count / group + 1;
  return builder.size * 2 * place_count;
}

/// Kinematic bodies that pass or hit a row of bodies at rest.
double arrange_movers(WorldBuilder& builder, Point corner, std::uint32_t count) {
  Draw& draw = builder.draw;
  const double size = builder.size;
  const double pitch = draw.one_of({1, 1.015625, 1.5, 3});
  const bool is_moving = builder.plan.has(WorldFeature::kinematic_movers);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Motion base = draw_base(builder);
    const std::uint32_t place = i / 2;
    Placement placement{{corner.x + size * (pitch * place + 0.5), corner.y + size / 2}, 0, {}, 0};
    if (i % 2 != 0) {
      builder.add(placement, size);
      continue;
    }
    placement.position.y += size * draw.one_of({1, 1.03125, 2, 4});
    if (is_moving) {
      placement.velocity = base.velocity;
      placement.angular_velocity = base.angular_velocity;
    }
    builder.add_kinematic(placement, size);
  }
  const std::uint32_t place_count = count / 2 + 1;
  return size * pitch * place_count;
}

struct Arrangement {
  double (*add)(WorldBuilder& builder, Point corner, std::uint32_t count);
  int weight;
};
constexpr std::array<Arrangement, 5> arrangements{{
    {arrange_lattice, 12},
    {arrange_diagonal, 6},
    {arrange_sizes, 2},
    {arrange_coincident, 1},
    {arrange_movers, 4},
}};

}  // namespace

double add_quiet_corner(WorldBuilder& builder, Point corner, std::uint32_t count) {
  Draw& draw = builder.draw;
  const std::uint32_t quiet = 2 + draw.below(count / 6 + 1);
  const double pitch = draw.one_of({0.75, 0.875, 1.015625, 1.0625, 1.25});
  const bool is_diagonal = draw.chance(75);
  const double rise = is_diagonal ? pitch : draw.half() ? 0 : 0.25;
  const bool is_exact = draw.chance(70);
  for (std::uint32_t i = 0; i < quiet; ++i) {
    const std::uint32_t place = i / 2;
    const Point shift{builder.size * (0.5 + 2.5 * place + pitch * (i % 2)), builder.size * (0.5 + rise * (i % 2))};
    const Placement placement{{corner.x + shift.x, corner.y + shift.y}, 0, {}, 0};
    if (is_exact)
      builder.add_exact(placement, builder.size, ShapeKind::circle);
    else
      builder.add(placement, builder.size);
  }
  const double left = builder.size * (2.5 * (quiet / 2.0 + 1) + draw.one_of({0.5, 2, 6}));
  // Stacks of two or more, so that most pairs are contacts.
  Lattice lattice{{corner.x + left, corner.y}, count - quiet, 1, {draw.one_of({1, 1.5, 2, 3}), 1}};
  const std::uint32_t height = 2 + draw.below(4);
  lattice.columns = (lattice.count + height - 1) / height;
  if (lattice.columns == 0) return left;
  const bool glides = !builder.has_gravity() || draw.half();
  std::optional<ShapeKind> exact;
  if (draw.chance(80)) exact = builder.draw_exact_kind();
  add_lattice(builder, lattice, glides ? glide : rest, false, exact);
  return left + builder.size * (lattice.pitch.x * (lattice.columns - 1) + 1);
}

double add_arrangement(WorldBuilder& builder, Point corner, std::uint32_t count) {
  // Features that only one arrangement makes come first, if the plan has them.
  const bool is_first = builder.scene.bodies.size() < 2;
  if (is_first && builder.plan.has(WorldFeature::size_ratio) && count > 1) return arrange_sizes(builder, corner, count);
  if (is_first && builder.plan.has(WorldFeature::kinematic_movers) && count > 1)
    return arrange_movers(builder, corner, count);
  int at = builder.draw.between(0, 24);
  for (const Arrangement& arrangement : arrangements) {
    if (at < arrangement.weight) return arrangement.add(builder, corner, count);
    at -= arrangement.weight;
  }
  return arrange_lattice(builder, corner, count);
}

}  // namespace ticktrue::engine
