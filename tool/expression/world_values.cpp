// Measures of a world by name.
// SPDX-License-Identifier: MIT
#include "tool/expression/world_values.h"

#include <algorithm>
#include <cmath>

#include "tool/expression/named_table.h"
#include "tool/study/measures.h"

namespace ticktrue::tool {
namespace {

using engine::BodyReport;

double kinetic_energy_of(const BodyReport& body) {
  return 0.5 * body.mass * (body.velocity.x * body.velocity.x + body.velocity.y * body.velocity.y) +
         0.5 * body.inertia * body.angular_velocity * body.angular_velocity;
}

}  // namespace

const std::vector<BodyReport>& WorldMeasures::bodies() {
  if (!bodies_) bodies_ = engine_.bodies();
  return *bodies_;
}

const std::vector<engine::ContactReport>& WorldMeasures::contacts() {
  if (!contacts_) contacts_ = engine_.contacts();
  return *contacts_;
}

double WorldMeasures::angular_momentum() {
  double sum = 0;
  for (const BodyReport& body : bodies())
    sum += body.inertia * body.angular_velocity +
           body.mass * (body.center.x * body.velocity.y - body.center.y * body.velocity.x);
  return sum;
}

double WorldMeasures::asleep_count() const {
  const NamedTable sleep(engine_.state(), "sleep");
  double count = 0;
  for (std::uint32_t row = 0; row < sleep.row_count(); ++row) count += sleep.value(row, "asleep");
  return count;
}

double WorldMeasures::of(WorldValue value) {
  switch (value) {
    case WorldValue::tick:
      return static_cast<double>(engine_.tick());
    case WorldValue::time:
      return engine_.time_s();
    case WorldValue::bodies:
      return static_cast<double>(bodies().size());
    case WorldValue::contacts:
      return static_cast<double>(contacts().size());
    case WorldValue::energy:
      return energy_of(engine_.scene(), bodies());
    case WorldValue::kinetic:
      return kinetic_energy(bodies());
    case WorldValue::potential:
      return energy_of(engine_.scene(), bodies()) - kinetic_energy(bodies());
    case WorldValue::momentum_x:
      return momentum_of(bodies()).x;
    case WorldValue::momentum_y:
      return momentum_of(bodies()).y;
    case WorldValue::angular_momentum:
      return angular_momentum();
    case WorldValue::overlap:
      return deepest_overlap(contacts());
    case WorldValue::joint_gap:
      return largest(joint_gaps(engine_.scene(), bodies()));
    case WorldValue::speed_max:
      return fastest(bodies());
    case WorldValue::asleep:
      return asleep_count();
  }
  return 0;
}

std::vector<std::uint32_t> WorldMeasures::bodies_of(WorldValue value) {
  switch (value) {
    case WorldValue::overlap:
      return deepest_pair();
    case WorldValue::joint_gap:
      return worst_joint();
    case WorldValue::speed_max:
      return body_with_most(speed_of);
    default:
      return body_with_most(kinetic_energy_of);
  }
}

std::vector<std::uint32_t> WorldMeasures::deepest_pair() {
  std::vector<std::uint32_t> pair;
  double deepest = 0;
  for (const engine::ContactReport& contact : contacts())
    for (int i = 0; i < contact.point_count; ++i) {
      if (!(-contact.separation[i] > deepest)) continue;
      deepest = -contact.separation[i];
      pair = {contact.body_a, contact.body_b};
    }
  return pair;
}

std::vector<std::uint32_t> WorldMeasures::worst_joint() {
  const std::vector<double> gaps = joint_gaps(engine_.scene(), bodies());
  if (gaps.empty()) return {};
  const auto worst = static_cast<std::size_t>(std::max_element(gaps.begin(), gaps.end()) - gaps.begin());
  const engine::Joint& joint = engine_.scene().joints[worst];
  if (!engine::has_body_a(joint.kind)) return {joint.body_b};
  return {joint.body_a, joint.body_b};
}

std::vector<std::uint32_t> WorldMeasures::body_with_most(double (*measure)(const BodyReport&)) {
  const BodyReport* most = nullptr;
  for (const BodyReport& body : bodies()) {
    if (body.type != engine::BodyType::dynamic_body) continue;
    if (most == nullptr || measure(body) > measure(*most)) most = &body;
  }
  if (most == nullptr) return {};
  return {most->id};
}

}  // namespace ticktrue::tool
