// The shapes of the bodies and the boxes around them, followed from tick to tick.
// SPDX-License-Identifier: MIT
#include "engine/broad_phase/proxy_boxes.h"

#include <atomic>
#include <cstring>

#include "engine/broad_phase/broad_phase.h"
#include "engine/model/selection.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// The margin of a body's boxes, relative to its size.
constexpr Real box_margin_share = Real(1) / 512;
constexpr Real ticks_of_margin = 4;  // at the present velocity; a margin for fewer ticks does not pay
// A body that moves by less than this share of its size per tick is not fast (motion_bounds.h).
constexpr Real certainly_slow_share = Real(0.2);

// Bits of ProxyBoxes::box_flags_.
constexpr std::uint8_t has_ccd_margin = 1;  // its proxies have a `ccd_margin` > 0
constexpr std::uint8_t is_swept = 2;        // (swept_displacement_of)
constexpr std::uint8_t has_margin = 4;

bool is_inside(const Box& inner, const Box& outer) {
  return outer.lower.x <= inner.lower.x && outer.lower.y <= inner.lower.y && inner.upper.x <= outer.upper.x &&
         inner.upper.y <= outer.upper.y;
}

bool same_bits(const BodyRow& a, const BodyRow& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}
bool same_pose(const BodyRow& a, const BodyRow& b) {
  return std::memcmp(&a.position, &b.position, sizeof a.position) == 0 &&
         std::memcmp(&a.rotation, &b.rotation, sizeof a.rotation) == 0;
}

/// An upper bound of the speed of all points of a body, m/s.
Real speed_bound(const BodyRow& body, Real extent) {
  return (magnitude(body.velocity.x) + magnitude(body.velocity.y)) + magnitude(body.angular_velocity) * extent;
}

/// The margin of the boxes of a body that is not swept, m; 0 for a body that would soon leave this margin.
Real margin_for(const BodyModel& constants, const BodyRow& body, const MotionBounds& bounds) {
  // The second term is the rounding error of a box.
  const Real far = larger(magnitude(body.position.x), magnitude(body.position.y)) + constants.extent;
  const Real margin = box_margin_share * constants.size - 16 * epsilon * far;
  return ticks_of_margin * bounds.dt * speed_bound(body, constants.extent) < margin ? margin : Real(0);
}

}  // namespace

// ---- Bodies ----

bool BodySet::valid_for(const State& state, const Parallel& parallel) const {
  const std::size_t count = state.bodies.size();
  if (!is_valid_ || keys_.size() != count) return false;
  std::atomic<bool> same_bodies{true};
  parallel.for_chunks(count, parallel.chunk_size(count, 512), [&](const Chunk& chunk) {
    bool same = true;
    for (std::size_t row = chunk.begin; row < chunk.end; ++row)
      same &= keys_[row].id == state.bodies[row].id && keys_[row].source == state.bodies[row].source;
    if (!same) same_bodies.store(false, std::memory_order_relaxed);
  });
  return same_bodies.load(std::memory_order_relaxed);
}

void BodySet::rebuild(const Model& model, const State& state) {
  ++generation_;
  is_valid_ = true;
  keys_.clear();
  static_count_ = 0;
  for (const BodyRow& body : state.bodies) {
    keys_.push_back({body.id, body.source});
    static_count_ += model.bodies[body.source].type == BodyType::static_body ? 1 : 0;
  }
}

void BodySet::follow(const Model& model, const State& state, const Parallel& parallel) {
  const bool is_hit = valid_for(state, parallel);
  count_use(is_hit);
  if (!is_hit) rebuild(model, state);
}

// ---- Boxes ----

void ProxyBoxes::list_proxies(const Model& model, const State& state) {
  proxies_.clear();
  first_proxy_.clear();
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    first_proxy_.push_back(static_cast<std::uint32_t>(proxies_.size()));
    add_proxies(model, state, row, proxies_);
  }
  first_proxy_.push_back(static_cast<std::uint32_t>(proxies_.size()));
  boxes_.resize(proxies_.size());
  bodies_ = state.bodies;
  boxed_.resize(state.bodies.size());
  is_unchanged_.resize(state.bodies.size());
  box_flags_.assign(state.bodies.size(), 0);
}

/// Whether the enlarged boxes of a body still hold its shapes. A point moves by no more than its body and the chord of
/// its rotation.
bool ProxyBoxes::is_still_valid(const BoxedBody& boxed, const BodyRow& body) {
  const Real delta_position =
      larger(magnitude(body.position.x - boxed.position.x), magnitude(body.position.y - boxed.position.y));
  const Real delta_rotation =
      magnitude(body.rotation.c - boxed.rotation.c) + magnitude(body.rotation.s - boxed.rotation.s);
  return delta_position + delta_rotation * boxed.extent < boxed.margin && speed_bound(body, boxed.extent) < boxed.speed;
}

ProxyBoxes::BoxedBody ProxyBoxes::boxed_body(const BodyModel& constants, const BodyRow& body,
                                             const MotionBounds& bounds, Real margin) {
  const Real gravity_displacement = absolute(constants.gravity_scale) * bounds.gravity * bounds.dt;
  const Real speed =
      bounds.has_ccd ? certainly_slow_share * constants.size / bounds.dt - gravity_displacement : Real(1e30);
  return {body.position, body.rotation, constants.extent, margin, speed};
}

/// The bodies first..end-1 of a tick, and the results for them.
struct ProxyBoxes::Followed {
  std::size_t first;
  std::size_t end;
  bool everything;
  bool adds_margin;
  const Box* fat_boxes;    // null: no proxy is listed
  std::uint32_t* leaving;  // capacity for each proxy of these bodies
  std::size_t leaving_count = 0;
  bool any_made = false;
};

/// Makes the boxes of the bodies of a part that have left their margin, or of all bodies of the part.
void ProxyBoxes::rebuild(const Model& model, const State& state, const MotionBounds& bounds, Followed& part) {
  const bool speculates = bounds.speculates;  // contacts then depend on velocities and dt, too
  const bool everything = part.everything;
  const bool adds_margin = part.adds_margin;
  const Real gravity_displacement = key_.gravity_displacement;
  // Local pointers: to the compiler, a write through a byte pointer could change the pointers inside the vectors.
  const BodyRow* bodies = state.bodies.data();
  const BodyModel* constants = model.bodies.data();
  const ShapeModel* shapes = model.shapes.data();
  BodyRow* bodies_before = bodies_.data();
  std::uint8_t* is_unchanged = is_unchanged_.data();
  std::uint8_t* box_flags = box_flags_.data();
  BoxedBody* boxed = boxed_.data();
  const std::uint32_t* first_proxy = first_proxy_.data();
  Proxy* proxies = proxies_.data();
  Box* boxes = boxes_.data();
  const Box* fat_boxes = part.fat_boxes;
  std::uint32_t* leaving = part.leaving;
  std::size_t leaving_count = 0;
  bool any_made = false;
  for (std::size_t row = part.first; row < part.end; ++row) {
    const BodyRow& body = bodies[row];
    BodyRow& before = bodies_before[row];
    const bool has_pose = same_pose(body, before);
    const bool is_same = has_pose && same_bits(body, before);
    is_unchanged[row] = (speculates ? is_same : has_pose) ? 1 : 0;
    if (!everything && is_same) continue;
    before = body;
    if (adds_margin && (box_flags[row] & has_margin) != 0 && is_still_valid(boxed[row], body)) continue;
    const std::uint32_t proxy_end = first_proxy[row + 1];
    if (first_proxy[row] == proxy_end) continue;
    const Real swept = swept_displacement_of(bounds, constants[body.source], body);
    const Real ccd_margin = ccd_margin_of(bounds, constants[body.source], swept);
    any_made = true;
    const Real margin = adds_margin && !(swept > 0) ? margin_for(constants[body.source], body, bounds) : Real(0);
    if (margin > 0) boxed[row] = boxed_body(constants[body.source], body, bounds, margin);
    box_flags[row] = static_cast<std::uint8_t>((ccd_margin > 0 ? has_ccd_margin : 0) | (swept > 0 ? is_swept : 0) |
                                               (margin > 0 ? has_margin : 0));
    for (std::uint32_t i = first_proxy[row]; i < proxy_end; ++i) {
      if (proxies[i].ccd_margin != ccd_margin) proxies[i].ccd_margin = ccd_margin;  // avoids most writes
      boxes[i] = box_around(model, body, shapes[proxies[i].shape], gravity_displacement, swept);
      if (margin > 0)
        boxes[i] = {{boxes[i].lower.x - margin, boxes[i].lower.y - margin},
                    {boxes[i].upper.x + margin, boxes[i].upper.y + margin}};
      if (fat_boxes != nullptr && !is_inside(boxes[i], fat_boxes[i])) leaving[leaving_count++] = i;
    }
  }
  part.leaving_count = leaving_count;
  part.any_made = any_made;
}

void ProxyBoxes::follow(const Model& model, const State& state, const Parallel& parallel, BroadPhaseWork& work,
                        const MotionBounds& bounds, const BoxKey& key, bool adds_margin,
                        std::span<const Box> fat_boxes) {
  const bool is_valid = valid_for(key);
  if (key_.body_generation != key.body_generation) list_proxies(model, state);
  key_ = key;
  work.leaving.resize(proxies_.size());
  const std::size_t count = state.bodies.size();
  const std::size_t size = parallel.chunk_size(count, 128);
  std::atomic<bool> any_made{false};
  work.part_counts.assign(Parallel::chunk_count(count, size), 0);
  parallel.for_chunks(count, size, [&](const Chunk& chunk) {
    Followed part{chunk.begin,
                  chunk.end,
                  !is_valid,
                  is_valid && adds_margin,
                  fat_boxes.empty() ? nullptr : fat_boxes.data(),
                  work.leaving.data() + first_proxy_[chunk.begin]};
    rebuild(model, state, bounds, part);
    work.part_counts[chunk.index] = static_cast<std::uint32_t>(part.leaving_count);
    if (part.any_made) any_made.store(true, std::memory_order_relaxed);
  });
  std::uint8_t flags = 0;
  for (const std::uint8_t of_body : box_flags_) flags |= of_body;
  any_ccd_margin_ = (flags & has_ccd_margin) != 0;
  any_swept_ = (flags & is_swept) != 0;
  const auto begin_of = [&](std::size_t chunk) { return std::size_t{first_proxy_[chunk * size]}; };
  work.leaving.resize(put_together(work.leaving.data(), work.part_counts, begin_of));
  const bool some_made = any_made.load(std::memory_order_relaxed);
  if (some_made) ++revision_;
  count_uses({is_valid ? 1u : 0u, some_made ? 1u : 0u});
}

void ProxyBoxes::make_tight(const Model& model, const State& state, const MotionBounds& bounds) {
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    const BodyRow& body = state.bodies[row];
    const Real swept = swept_displacement_of(bounds, model.bodies[body.source], body);
    for (std::uint32_t i = first_proxy_[row]; i < first_proxy_[row + 1]; ++i)
      boxes_[i] = box_around(model, body, model.shapes[proxies_[i].shape], key_.gravity_displacement, swept);
    box_flags_[row] &= static_cast<std::uint8_t>(~has_margin);
  }
  ++revision_;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
