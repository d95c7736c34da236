// One step of all active contacts: where passes converge slowly, all impulses are solved for at once.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/contacts/contact_batch.h"
#include "engine/impacts/impulse_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Changes the impulses of the active contacts of a set. Their velocities become the targets of the relax pass, as far
/// as all rows stay active. A system that is too wide is left alone.
void step_active_contacts(const SolvedSet& solved, ContactBatches& contacts, ImpulseStep& out);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
