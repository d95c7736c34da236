// The hash of the list of units.
// SPDX-License-Identifier: MIT
#include "tool/corpus/engine_digest.h"

#include <string_view>

namespace ticktrue::verifier {

std::optional<Hash128> engine_digest() {
  const std::string_view units(engine_units);
  if (units.empty()) return std::nullopt;
  return hash128({reinterpret_cast<const std::uint8_t*>(units.data()), units.size()});
}

}  // namespace ticktrue::verifier
