// The stiffness of contacts.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/contacts/soft.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Stiffness of contacts between dynamic bodies, and of contacts with other bodies. `slop`: the overlap that is not
/// corrected.
struct ContactStiffness {
  Softness moving;
  Softness immovable;
  Real slop = 0;  // relative to the size of the smaller shape
};

/// Stiffness of soft contacts, proportional to the substep rate 1 / h.
ContactStiffness soft_contacts(Real h);
/// Contacts that remove a fifth of the overlap beyond the slop in each step of length h.
ContactStiffness baumgarte_contacts(Real h);
/// N/m of a soft contact point per kg of effective mass, for substeps of length h.
Real soft_contact_stiffness(Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
