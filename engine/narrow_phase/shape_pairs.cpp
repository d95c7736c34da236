// The pairs of shapes that can touch in a scene, and the shapes that can touch no other.
// SPDX-License-Identifier: MIT
#include "engine/narrow_phase/shape_pairs.h"

#include <array>
#include <string_view>

#include "engine/model/proxies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// In the order of ShapeFamily.
constexpr std::array<std::string_view, shape_family_count> family_names{"circle", "polygon", "round", "chain"};

constexpr std::uint32_t several_bodies = 0xffffffff;
constexpr std::size_t kind_count_max = 512;  // of one family; with more, all count as able to touch

/// Shapes that the broad phase cannot tell apart.
struct ProxyKind {
  Proxy proxy{};                          // the fields that may_touch reads
  std::uint32_t source = several_bodies;  // the only body with shapes of this kind
};
using FamilyKinds = std::array<std::vector<ProxyKind>, shape_family_count>;

bool alike(const Proxy& a, const Proxy& b) {
  return a.is_dynamic == b.is_dynamic && a.is_static == b.is_static && a.is_sensor == b.is_sensor &&
         a.is_line == b.is_line && a.filter == b.filter;
}

bool can_come(const Model& model, std::uint32_t source) {
  if (source < model.first_prototype) return true;
  for (const InputKind kind : model.scene.inputs)
    if (kind == InputKind::spawn) return true;
  for (const std::uint32_t spawned : model.pointer_spawns)
    if (model.first_prototype + spawned == source) return true;
  return false;
}

void add(std::vector<ProxyKind>& kinds, const Proxy& proxy, std::uint32_t source) {
  for (ProxyKind& kind : kinds) {
    if (!alike(kind.proxy, proxy)) continue;
    if (kind.source != source) kind.source = several_bodies;
    return;
  }
  if (kinds.size() < kind_count_max) kinds.push_back({proxy, source});
}

Proxy proxy_of(const BodyModel& body, const ShapeModel& shape) {
  Proxy proxy{};
  proxy.is_dynamic = body.type == BodyType::dynamic_body;
  proxy.is_static = body.type == BodyType::static_body;
  proxy.is_sensor = shape.is_sensor;
  proxy.is_line = is_line(shape);
  proxy.filter = shape.filter;
  return proxy;
}

std::uint32_t owner_of(const Model& model, std::uint32_t source) {
  return source < model.first_prototype ? source : several_bodies;
}

FamilyKinds find_kinds(const Model& model) {
  FamilyKinds kinds;
  for (std::uint32_t source = 0; source < model.bodies.size(); ++source) {
    if (!can_come(model, source)) continue;
    const BodyModel& body = model.bodies[source];
    for (std::uint32_t child = 0; child < body.shape_count; ++child) {
      const ShapeModel& shape = model.shape(body, child);
      add(kinds[static_cast<std::size_t>(shape.family)], proxy_of(body, shape), owner_of(model, source));
    }
  }
  return kinds;
}

bool can_meet(const std::vector<ProxyKind>& of_a, const std::vector<ProxyKind>& of_b) {
  if (of_a.size() == kind_count_max || of_b.size() == kind_count_max) return !of_a.empty() && !of_b.empty();
  for (const ProxyKind& kind_a : of_a)
    for (const ProxyKind& kind_b : of_b) {
      if (kind_a.source == kind_b.source && kind_a.source != several_bodies) continue;
      Proxy a = kind_a.proxy;
      Proxy b = kind_b.proxy;
      a.body = 0;
      b.body = 1;
      if (may_touch(a, b)) return true;
    }
  return false;
}

}  // namespace

std::string meeting_pairs(const Model& model) {
  const FamilyKinds kinds = find_kinds(model);
  std::string text;
  for (std::size_t a = 0; a < shape_family_count; ++a)
    for (std::size_t b = a; b < shape_family_count; ++b)
      if (can_meet(kinds[a], kinds[b]))
        text += (text.empty() ? "" : ", ") + std::string(family_names[a]) + " x " + std::string(family_names[b]);
  return text.empty() ? "the filters of shapes let no two meet" : text;
}

void find_non_colliding_shapes(Model& model) {
  model.is_non_colliding.assign(model.body_shapes.size(), 0);
  std::vector<ProxyKind> kinds;
  const auto for_each_child = [&](auto use) {
    for (std::uint32_t source = 0; source < model.bodies.size(); ++source) {
      const BodyModel& body = model.bodies[source];
      for (std::uint32_t child = 0; child < body.shape_count; ++child)
        use(body.first_shape + child, proxy_of(body, model.shape(body, child)), owner_of(model, source));
    }
  };
  for_each_child([&](std::uint32_t, const Proxy& proxy, std::uint32_t owner) { add(kinds, proxy, owner); });
  if (kinds.size() == kind_count_max) return;
  std::vector<std::uint8_t> meets;
  for (const ProxyKind& kind : kinds) meets.push_back(can_meet({kind}, kinds) ? 1 : 0);
  for_each_child([&](std::uint32_t place, const Proxy& proxy, std::uint32_t) {
    for (std::size_t i = 0; i < kinds.size(); ++i)
      if (alike(kinds[i].proxy, proxy)) model.is_non_colliding[place] = meets[i] == 0 ? 1 : 0;
  });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
