// Makes the constants of a run from a scene.
// SPDX-License-Identifier: MIT
#include "engine/model/model.h"

#include "engine/contacts/choose_kernels.h"
#include "engine/integrators/forces.h"
#include "engine/math/trig.h"
#include "engine/narrow_phase/shape_pairs.h"
#include "engine/scene/hull.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

Vec2 to_vec2(Point p) {
  return {static_cast<Real>(p.x), static_cast<Real>(p.y)};
}

// The thesis' inertia: boxes from half extents (four times too small), polygons without their mass and about the body's
// origin, also when static. Source: thesis figures 20, 21; used as printed, by the `impulse` solver.

double thesis_circle(const Shape& shape, double mass) {
  return 0.5 * shape.radius * shape.radius * mass;
}

double thesis_box(const Shape& shape, double mass) {
  return (shape.half_size.x * shape.half_size.x + shape.half_size.y * shape.half_size.y) / 12 * mass;
}

double thesis_polygon(const Shape& shape, double) {
  const Result<std::vector<Point>> hull = build_hull(shape.vertices);
  TICKTRUE_ASSERT(hull.has_value());
  double area = 0, weight = 0;
  for (std::size_t i = 0; i < hull->size(); ++i) {
    const Point a = (*hull)[i];
    const Point b = (*hull)[(i + 1) % hull->size()];
    const double signed_cross = a.x * b.y - a.y * b.x;
    const double size = signed_cross < 0 ? -signed_cross : signed_cross;
    area += size * ((a.x * a.x + a.y * a.y) + (b.x * b.x + b.y * b.y) + (a.x * b.x + a.y * b.y));
    weight += size;
  }
  return area / 6 / weight;
}

double thesis_none(const Shape&, double) {
  return 0;
}

Vec2 from(Point center, Point p) {
  return to_vec2({p.x - center.x, p.y - center.y});
}

double distance(Point a, Point b) {
  return __builtin_sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

/// Adds the vertices and normals of a hull of two or more vertices around `middle`, and its sizes.
void add_hull(Model& model, ShapeModel& out, const std::vector<Point>& hull, Point middle, Point body_center) {
  out.center = from(body_center, middle);
  out.first_vertex = static_cast<std::uint32_t>(model.vertices.size());
  out.vertex_count = static_cast<std::uint32_t>(hull.size());
  double farthest = 0;
  double nearest = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point a = hull[i];
    const Point b = hull[(i + 1) % hull.size()];
    const double edge_length = __builtin_sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
    const Point normal{(b.y - a.y) / edge_length, (a.x - b.x) / edge_length};
    model.vertices.push_back(from(body_center, a));
    model.normals.push_back(to_vec2(normal));
    const double distance_to_vertex = distance(a, middle);
    const double depth = (a.x - middle.x) * normal.x + (a.y - middle.y) * normal.y;
    if (distance_to_vertex > farthest) farthest = distance_to_vertex;
    if (i == 0 || depth < nearest) nearest = depth;
  }
  out.bounding_radius = static_cast<Real>(farthest);
  out.size = static_cast<Real>(2 * nearest);
}

void add_child(Model& model, ShapeModel out, const Shape& shape) {
  if (shape.radius > 0) {
    out.radius = static_cast<Real>(shape.radius);
    out.bounding_radius = out.bounding_radius + out.radius;
    out.size = out.size + 2 * out.radius;
    out.rolling_resistance = static_cast<Real>(shape.material.rolling_resistance * shape.radius);
  }
  model.shapes.push_back(out);
}

// Each function adds the children of a shape of its kind to model.shapes. `out` has the fields that all kinds share.

void add_circle(Model& model, ShapeModel out, const Shape& shape, Point body_center) {
  out.family = ShapeFamily::circle;
  out.center = from(body_center, shape.center);
  add_child(model, out, shape);
}

void add_polygon(Model& model, ShapeModel out, const Shape& shape, Point body_center) {
  Shape unit = shape;
  unit.density = 1;
  unit.radius = 0;
  out.family = shape.radius > 0 ? ShapeFamily::round : ShapeFamily::polygon;
  add_hull(model, out, core_of(shape), shape_mass(unit).center, body_center);
  add_child(model, out, shape);
}

void set_line(Model& model, ShapeModel& out, Point a, Point b, Point body_center) {
  out.family = ShapeFamily::round;
  add_hull(model, out, {a, b}, {(a.x + b.x) / 2, (a.y + b.y) / 2}, body_center);
  out.size = 0;
}

void add_line(Model& model, ShapeModel out, const Shape& shape, Point body_center) {
  set_line(model, out, shape.vertices[0], shape.vertices[1], body_center);
  add_child(model, out, shape);
}

/// Adds one shape for each edge. The first and last edges of an open chain have no neighbour at its ends.
void add_chain(Model& model, ShapeModel common, const Shape& shape, Point body_center) {
  const std::vector<Point>& points = shape.vertices;
  const std::size_t count = points.size();
  const std::size_t edge_count = shape.loop ? count : count - 1;
  for (std::size_t i = 0; i < edge_count; ++i) {
    ShapeModel edge = common;
    set_line(model, edge, points[i], points[(i + 1) % count], body_center);
    edge.family = ShapeFamily::chain_edge;
    edge.has_before = shape.loop || i > 0;
    edge.has_after = shape.loop || i + 2 < count;
    if (edge.has_before) edge.before = from(body_center, points[(i + count - 1) % count]);
    if (edge.has_after) edge.after = from(body_center, points[(i + 2) % count]);
    model.shapes.push_back(edge);
  }
}

struct ShapeMaker {
  ShapeKind kind;
  void (*add)(Model& model, ShapeModel out, const Shape& shape, Point body_center);
  double (*thesis_inertia)(const Shape& shape, double mass);
};
constexpr std::array<ShapeMaker, shape_kinds.size()> makers{{
    {ShapeKind::circle, add_circle, thesis_circle},
    {ShapeKind::box, add_polygon, thesis_box},
    {ShapeKind::polygon, add_polygon, thesis_polygon},
    {ShapeKind::capsule, add_line, thesis_none},
    {ShapeKind::segment, add_line, thesis_none},
    {ShapeKind::chain, add_chain, thesis_none},
}};
static_assert(rows_are_in_order(makers));

void add_shape(Model& model, const Shape& shape, Point body_center) {
  ShapeModel out;
  out.friction = static_cast<Real>(shape.material.friction);
  out.restitution = static_cast<Real>(shape.material.restitution);
  out.tangent_speed = static_cast<Real>(shape.material.tangent_speed);
  out.filter = shape.filter;
  out.is_sensor = shape.sensor;
  info_of(makers, shape.kind).add(model, out, shape, body_center);
}

double thesis_inertia(const Body& body, double mass) {
  double sum = 0;
  for (const Shape& shape : body.shapes) sum += info_of(makers, shape.kind).thesis_inertia(shape, mass);
  return sum;
}

/// An earlier shape, so that equal shapes are shared. A hash of the description finds it.
struct KnownShape {
  Shape shape;
  Point center;
  std::uint32_t index;  // of its first child
  std::uint32_t child_count;
};

std::uint64_t shape_key(const Shape& shape, Point center) {
  std::uint64_t key = static_cast<std::uint64_t>(shape.kind) + 1;
  const auto fold = [&key](double value) { key = (key ^ bits_of(value)) * 0x9e3779b97f4a7c15ull, key ^= key >> 29; };
  fold(shape.center.x), fold(shape.center.y), fold(shape.angle), fold(shape.radius), fold(shape.half_size.x);
  fold(shape.half_size.y), fold(shape.material.friction), fold(shape.material.restitution), fold(center.x),
      fold(center.y);
  for (const Point p : shape.vertices) fold(p.x), fold(p.y);
  return key;
}

void add_body(Model& model, const Body& body, std::vector<std::vector<KnownShape>>& known) {
  const MassProperties mass = body_mass(body);
  BodyModel out;
  out.type = body.type;
  out.center = to_vec2(mass.center);
  if (body.type == BodyType::dynamic_body) {
    out.mass = static_cast<Real>(mass.mass);
    out.inv_mass = static_cast<Real>(1 / mass.mass);
    out.inertia = static_cast<Real>(mass.inertia);
    out.inv_inertia = mass.inertia > 0 ? static_cast<Real>(1 / mass.inertia) : Real(0);
  }
  const double thesis = thesis_inertia(body, mass.mass);
  out.impulse_inv_inertia = thesis > 0 && !body.fixed_rotation ? static_cast<Real>(1 / thesis) : Real(0);
  out.linear_damping = static_cast<Real>(body.linear_damping);
  out.angular_damping = static_cast<Real>(body.angular_damping);
  out.gravity_scale = static_cast<Real>(body.gravity_scale);
  out.first_shape = static_cast<std::uint32_t>(model.body_shapes.size());
  for (Shape shape : body.shapes) {
    shape.density = 1;  // affects the mass only, which is known by now
    std::vector<KnownShape>& bucket = known[shape_key(shape, mass.center) % known.size()];
    const KnownShape* same = nullptr;
    for (const KnownShape& candidate : bucket)
      if (candidate.shape == shape && candidate.center == mass.center) same = &candidate;
    if (same == nullptr) {
      const auto first = static_cast<std::uint32_t>(model.shapes.size());
      add_shape(model, shape, mass.center);
      bucket.push_back({shape, mass.center, first, static_cast<std::uint32_t>(model.shapes.size()) - first});
      same = &bucket.back();
    }
    for (std::uint32_t child = 0; child < same->child_count; ++child) model.body_shapes.push_back(same->index + child);
  }
  out.shape_count = static_cast<std::uint32_t>(model.body_shapes.size()) - out.first_shape;
  if (out.shape_count > model.child_count_max) model.child_count_max = out.shape_count;
  out.can_sleep = body.can_sleep;
  out.is_bullet = body.bullet;
  for (std::uint32_t child = 0; child < out.shape_count; ++child) {
    const ShapeModel& shape = model.shape(out, child);
    out.extent = larger(out.extent, length(shape.center) + shape.bounding_radius);
    if (shape.size > 0 && (out.size == 0 || shape.size < out.size)) out.size = shape.size;
  }
  model.bodies.push_back(out);
}

void add_quads(Model& model) {
  for (ShapeModel& shape : model.shapes) {
    if (shape.family != ShapeFamily::polygon || shape.vertex_count != 4) continue;
    shape.quad = static_cast<std::uint32_t>(model.quads.size());
    Quad quad;
    for (std::uint32_t i = 0; i < 4; ++i) {
      const Vec2 vertex = model.vertices[shape.first_vertex + i];
      const Vec2 normal = model.normals[shape.first_vertex + i];
      quad.x[i] = vertex.x, quad.y[i] = vertex.y;
      quad.normal_x[i] = normal.x, quad.normal_y[i] = normal.y;
    }
    model.quads.push_back(quad);
  }
}

constexpr std::size_t material_count_max = 64;  // the table of their pairs fits into the cache

void mix_materials(Model& model) {
  std::vector<const ShapeModel*> kinds;
  for (ShapeModel& shape : model.shapes) {
    shape.material = 0;
    while (shape.material < kinds.size() && (kinds[shape.material]->friction != shape.friction ||
                                             kinds[shape.material]->restitution != shape.restitution))
      ++shape.material;
    if (shape.material < kinds.size()) continue;
    if (kinds.size() == material_count_max) return;
    kinds.push_back(&shape);
  }
  std::vector<MixedMaterial> mixed;
  for (const ShapeModel* a : kinds)
    for (const ShapeModel* b : kinds) mixed.push_back(mixed_material(model, *a, *b));
  model.mixed_materials = std::move(mixed);
  model.material_count = static_cast<std::uint32_t>(kinds.size());
}

}  // namespace

Real mix(MixRule rule, Real a, Real b) {
  switch (rule) {
    case MixRule::geometric_mean:
      return square_root(a * b);
    case MixRule::maximum:
      return larger(a, b);
    case MixRule::minimum:
      return smaller(a, b);
    case MixRule::average:
      return Real(0.5) * (a + b);
  }
  return 0;
}

Model make_model(const Scene& scene) {
  Model model;
  model.scene = scene;
  std::vector<std::vector<KnownShape>> known(1024);
  for (const Body& body : scene.bodies) add_body(model, body, known);
  model.first_prototype = static_cast<std::uint32_t>(model.bodies.size());
  for (const Body& body : scene.prototypes) add_body(model, body, known);

  make_joints(model);
  add_forces(model);

  model.restitution_threshold = static_cast<Real>(scene.settings.restitution_threshold);
  model.can_collide = info_of(solvers, scene.settings.solver).solves_constraints && engine::can_collide(scene);
  // Without contacts and joints nothing carries anything, so that all islands have the least substeps.
  const bool chooses_substeps = scene.settings.auto_substeps && (model.can_collide || !scene.joints.empty());
  model.finds_islands = chooses_substeps || scene.settings.sleep.has_value();
  model.takes_inputs = !scene.inputs.empty();
  model.has_pointer = scene.pointer.has_value();
  if (scene.pointer)
    for (const std::string& name : scene.pointer->spawns)
      for (std::uint32_t i = 0; i < scene.prototypes.size(); ++i)
        if (scene.prototypes[i].name == name) model.pointer_spawns.push_back(i);
  model.has_bounds = scene.bounds.has_value();
  if (scene.bounds) model.bounds = {to_vec2(scene.bounds->lower), to_vec2(scene.bounds->upper)};
  for (const ShapeModel& shape : model.shapes) {
    model.bounces |= shape.restitution > 0;  // under every rule, at least against an equal shape
    model.has_surfaces |= shape.tangent_speed != 0 || shape.rolling_resistance > 0;
    model.has_sensors |= shape.is_sensor;
  }
  add_quads(model);
  mix_materials(model);
  find_non_colliding_shapes(model);
  set_kernels(model, instruction_set_in_use(), contact_features(model));
  return model;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
