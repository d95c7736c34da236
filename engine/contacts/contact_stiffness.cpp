// The stiffness of contacts.
// SPDX-License-Identifier: MIT
#include "engine/contacts/contact_stiffness.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Stiffness relative to the substep rate 1/h. With a fixed frequency the error would not fall as substeps^-2.
constexpr Real hertz_per_rate = Real(0.125);
constexpr Real contact_damping_ratio = 10;

/// Share of an overlap that is corrected per step. Source: Baumgarte, "Stabilization of Constraints", 1972.
constexpr Real baumgarte = Real(0.2);

}  // namespace

Real soft_contact_stiffness(Real h) {
  const Real omega = Real(2 * pi) * hertz_per_rate / h;
  return omega * omega;
}

ContactStiffness soft_contacts(Real h) {
  const Real hertz = hertz_per_rate / h;
  return {make_soft(hertz, contact_damping_ratio, h), make_soft(2 * hertz, contact_damping_ratio, h), 0};
}

ContactStiffness baumgarte_contacts(Real h) {
  const Softness rigid{baumgarte / h, 1, 0};
  return {rigid, rigid, Real(0.005)};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
