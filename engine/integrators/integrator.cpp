// The table of integrators.
// SPDX-License-Identifier: MIT
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr std::array<Integrator, integrators.size()> table{{
    {IntegratorKind::semi_implicit_euler, begin_semi_implicit_euler, predict_semi_implicit_euler,
     drift_semi_implicit_euler},
}};

}  // namespace

const Integrator& integrator(IntegratorKind kind) {
  return info_of(table, kind);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
