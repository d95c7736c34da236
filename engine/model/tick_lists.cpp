// The lists of a tick before its first stage.
// SPDX-License-Identifier: MIT
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_tick(TickLists& tick) {
  tick.first_new_id = no_reference;
  tick.moved_before.clear();
  tick.force.clear();
  tick.torque.clear();
  tick.proxies = {};
  tick.pairs = {};
  tick.has_too_many_pairs = false;
  tick.changes = {};
  tick.contact_pairs = {};
  tick.has_solver_sets = false;
  tick.shock_work_left = 0;  // a scene without islands has no stage that sets it
  tick.shock_is_cut = false;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
