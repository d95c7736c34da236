// One step of all active contacts: where passes converge slowly, one solution gives all impulses.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/contacts/contact_batch.h"
#include "engine/impacts/impulse_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Changes the impulses of the active contacts of a set. The resulting velocities become the targets of the relax pass,
/// as far as all rows stay active. A system whose envelope is too wide is not solved.
void step_active_contacts(const SolvedSet& solved, ContactBatches& contacts, ImpulseStep& out);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
