// Broad phase: which pairs of shapes may touch. Every algorithm gives the same bits: any superset of the touching pairs
// will do, since a contact exists only where the narrow phase finds one, and pairs are sorted before it looks.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/pipeline.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The stage of this kind.
StageFunction broad_phase_function(BroadPhaseKind kind);

/// Fills scratch.proxies from the present poses.
void make_proxies(const Model& model, const State& state, Scratch& scratch);

/// Whether two proxies may touch at all, wherever they are: different bodies, one of them dynamic.
inline bool may_touch(const Proxy& a, const Proxy& b) {
  return a.body != b.body && (a.is_dynamic || b.is_dynamic);
}

/// Sorts scratch.unsorted_pairs (each pair once, any order) into scratch.pairs.
void sort_pairs(Scratch& scratch);

void brute_force(const Model& model, State& state, Scratch& scratch, Real dt);
void bounding_circle(const Model& model, State& state, Scratch& scratch, Real dt);
void sweep_and_prune(const Model& model, State& state, Scratch& scratch, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
