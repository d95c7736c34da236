// The shapes of the bodies and the boxes around them, followed from tick to tick.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "base/parallel/parallel.h"
#include "engine/broad_phase/broad_phase_work.h"
#include "engine/model/caches.h"
#include "engine/model/model.h"
#include "engine/model/motion_bounds.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The set of bodies. Key: their ids and sources in order. Structures that are made for one set of bodies have its
/// generation in their keys.
class BodySet final : public TickCache {
 public:
  BodySet() : TickCache(CacheKind::body_set) {}
  /// Begins a new generation unless the set of bodies is that of the last call.
  void follow(const Model& model, const State& state, const Parallel& parallel);
  void invalidate() override { is_valid_ = false; }
  std::uint32_t generation() const { return generation_; }
  std::size_t static_count() const { return static_count_; }

 private:
  struct Key {
    std::uint32_t id;
    std::uint32_t source;
  };
  bool valid_for(const State& state, const Parallel& parallel) const;
  void rebuild(const Model& model, const State& state);

  bool is_valid_ = false;
  std::uint32_t generation_ = 0;
  std::size_t static_count_ = 0;
  std::vector<Key> keys_;  // [body]
};

/// The inputs of all boxes, beside the poses and velocities of the bodies.
struct BoxKey {
  std::uint32_t body_generation = 0;
  Real dt = 0;                    // s
  Real gravity_displacement = 0;  // m
  Real farthest = 0;              // m (MotionBounds)

  bool operator==(const BoxKey&) const = default;
};

/// Proxies and their tight boxes. The box of a slow body is enlarged by 1/512 of its size, so that it stays valid for
/// about four ticks. Key: BoxKey for all boxes; for each body its row, or the motion that its enlarged boxes allow.
class ProxyBoxes final : public TickCache {
 public:
  ProxyBoxes() : TickCache(CacheKind::boxes) {}

  /// Remakes the boxes that are not valid for the tick. `adds_margin`: boxes of slow bodies are enlarged. `fat_boxes`:
  /// [proxy]; work.leaving gets the proxies that are not inside. Empty: no proxy is listed.
  void follow(const Model& model, const State& state, const Parallel& parallel, BroadPhaseWork& work,
              const MotionBounds& bounds, const BoxKey& key, bool adds_margin, std::span<const Box> fat_boxes);
  /// Boxes without margins, for the count of pairs.
  void make_tight(const Model& model, const State& state, const MotionBounds& bounds);
  void invalidate() override { key_.farthest = -1; }  // no tick has this

  const std::vector<Proxy>& proxies() const { return proxies_; }
  const std::vector<Box>& boxes() const { return boxes_; }
  const BoxKey& key() const { return key_; }
  /// [body] BodyChanges::is_unchanged.
  std::span<const std::uint8_t> is_unchanged() const { return is_unchanged_; }
  bool any_ccd_margin() const { return any_ccd_margin_; }
  bool any_swept() const { return any_swept_; }
  /// A different number after each tick that made a box.
  std::uint64_t revision() const { return revision_; }

 private:
  /// The pose for which the boxes of a body were made. They stay valid while all points have moved by less than
  /// `margin` and the body is slower than `speed`.
  struct BoxedBody {
    Vec2 position;
    Rotation rotation;
    Real extent;  // m, BodyModel's
    Real margin;  // m
    Real speed;   // m/s, limit of the speed bound of its points
  };
  struct Followed;

  bool valid_for(const BoxKey& key) const { return key_ == key; }
  void list_proxies(const Model& model, const State& state);
  static BoxedBody boxed_body(const BodyModel& constants, const BodyRow& body, const MotionBounds& bounds, Real margin);
  static bool is_still_valid(const BoxedBody& boxed, const BodyRow& body);
  void rebuild(const Model& model, const State& state, const MotionBounds& bounds, Followed& part);

  BoxKey key_;
  std::uint64_t revision_ = 0;
  bool any_ccd_margin_ = false;
  bool any_swept_ = false;
  std::vector<std::uint32_t> first_proxy_;  // [body]; one more at the end
  std::vector<Proxy> proxies_;
  std::vector<Box> boxes_;                  // [proxy] m, around the shapes with their margins
  std::vector<BodyRow> bodies_;             // of the tick before
  std::vector<BoxedBody> boxed_;            // [body] if its boxes are enlarged
  std::vector<std::uint8_t> box_flags_;     // [body] how its boxes were made (proxy_boxes.cpp)
  std::vector<std::uint8_t> is_unchanged_;  // [body] (BodyChanges)
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
