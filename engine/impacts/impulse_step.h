// One step of all active contacts: where passes converge slowly, one solution gives all impulses.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "engine/contacts/contact_batch.h"
#include "engine/impacts/impulse_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

inline constexpr std::uint64_t no_step_limit = ~std::uint64_t{0};

/// The work of a step, in contacts solved once.
struct StepWork {
  bool is_done = false;
  std::uint64_t done = 0;
  std::uint64_t needed = 0;  // of a step that is not done; no_step_limit: no limit of work helps
};

/// Changes the impulses of the active contacts of a set. The resulting velocities become the targets of the relax pass,
/// as far as all rows stay active. A system whose envelope is too wide, or which needs more work than `work_max`, is
/// not solved.
StepWork step_active_contacts(const SolvedSet& solved, ContactBatches& contacts, std::uint64_t work_max,
                              ImpulseStep& out);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
