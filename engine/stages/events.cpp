// Begin and end of contacts, and of overlaps with sensors, as rows of this tick.
// SPDX-License-Identifier: MIT
//
// The touching pairs of this tick are compared with those of the tick before. Both lists are sorted by ids. One walk
// over both lists therefore finds every difference, in an order that no broad phase can change.
#include "engine/stages/events.h"

#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

bool comes_before(const TouchRow& a, const TouchRow& b) {
  if (a.body_a != b.body_a) return a.body_a < b.body_a;
  if (a.child_a != b.child_a) return a.child_a < b.child_a;
  if (a.body_b != b.body_b) return a.body_b < b.body_b;
  return a.child_b < b.child_b;
}

bool is_sorted(const std::vector<TouchRow>& rows) {
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (comes_before(rows[i], rows[i - 1])) return false;
  return true;
}

/// Merge sort, bottom up. Contacts are already sorted.
void sort_rows(std::vector<TouchRow>& rows, std::vector<TouchRow>& buffer) {
  if (is_sorted(rows)) return;
  buffer.resize(rows.size());
  for (std::size_t width = 1; width < rows.size(); width *= 2) {
    for (std::size_t begin = 0; begin < rows.size(); begin += 2 * width) {
      const std::size_t middle = begin + width < rows.size() ? begin + width : rows.size();
      const std::size_t end = begin + 2 * width < rows.size() ? begin + 2 * width : rows.size();
      std::size_t left = begin, right = middle;
      for (std::size_t i = begin; i < end; ++i) {
        const bool take_left = left < middle && (right == end || !comes_before(rows[right], rows[left]));
        buffer[i] = take_left ? rows[left++] : rows[right++];
      }
    }
    rows.swap(buffer);
  }
}

bool touches(const Manifold& manifold) {
  bool any = false;
  for (int i = 0; i < manifold.point_count; ++i) any = any || manifold.points[i].separation <= 0;
  return any;
}

/// Adds a row of `kind` for each row of `present` that is not in `past`. Both lists are sorted.
void add_events(EventKind kind, const std::vector<TouchRow>& present, const std::vector<TouchRow>& past,
                std::vector<EventRow>& events) {
  std::size_t at = 0;
  for (const TouchRow& row : present) {
    while (at < past.size() && comes_before(past[at], row)) ++at;
    if (at < past.size() && !comes_before(row, past[at])) continue;
    events.push_back({static_cast<std::uint32_t>(kind), row});
  }
}

/// Replaces `past` by `present` and adds the changes to `events`. `removed`: rows of `past` whose bodies were removed
/// in this tick.
void compare(EventKind begin, EventKind end, std::vector<TouchRow>& past, std::vector<TouchRow>& present,
             std::vector<TouchRow>& removed, std::vector<TouchRow>& buffer, std::vector<EventRow>& events) {
  sort_rows(present, buffer);
  past.insert(past.end(), removed.begin(), removed.end());
  sort_rows(past, buffer);
  add_events(begin, present, past, events);
  add_events(end, past, present, events);
  past.swap(present);
}

void find_contact_events(State& state, TickLists& tick, EventWork& work) {
  work.now_touching.clear();
  for (std::size_t i = 0; i < tick.contact_pairs.size(); ++i) {
    if (!touches(tick.contact_pairs[i].manifold)) continue;
    const ContactRow& row = state.contacts[i];
    work.now_touching.push_back({row.body_a, row.child_a, row.body_b, row.child_b});
  }
  compare(EventKind::contact_begin, EventKind::contact_end, state.touching, work.now_touching, tick.removed_touching,
          work.touch_buffer, state.events);
  tick.removed_touching.clear();
}

void find_sensor_events(const Model& model, State& state, TickLists& tick, EventWork& work) {
  work.now_touching.clear();
  for (const Pair& pair : tick.pairs) {
    const Proxy& a = tick.proxies[pair.first];
    const Proxy& b = tick.proxies[pair.second];
    if (!a.is_sensor && !b.is_sensor) continue;
    const BodyRow& body_a = state.bodies[a.body];
    const BodyRow& body_b = state.bodies[b.body];
    if (!touches(collide(model, model.shapes[a.shape], model.shapes[b.shape], body_a, body_b, 0))) continue;
    work.now_touching.push_back(a.is_sensor ? TouchRow{body_a.id, a.child, body_b.id, b.child}
                                            : TouchRow{body_b.id, b.child, body_a.id, a.child});
  }
  compare(EventKind::sensor_begin, EventKind::sensor_end, state.sensors, work.now_touching, tick.removed_sensors,
          work.touch_buffer, state.events);
  tick.removed_sensors.clear();
}

}  // namespace

void EventFinder::run(const Model& model, State& state, TickLists& tick, Real) {
  state.events.clear();
  if (model.scene.settings.events) find_contact_events(state, tick, work_);
  if (model.has_sensors) find_sensor_events(model, state, tick, work_);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
